#include "job_store.hpp"

#include <memory>

#include <nlohmann/json.hpp>
#include <sqlite3.h>

#include "core/error.hpp"

namespace sanatrix::server {
namespace {

using nlohmann::json;

constexpr auto schema =
    "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA busy_timeout=5000;"
    "CREATE TABLE IF NOT EXISTS jobs("
    " id TEXT PRIMARY KEY, created_s INTEGER NOT NULL, case_id TEXT NOT NULL, kind TEXT NOT NULL,"
    " state INTEGER NOT NULL, pid INTEGER NOT NULL, pid_start INTEGER NOT NULL, job TEXT NOT NULL)";

struct Finish {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Finish>;

[[noreturn]] void fail(sqlite3* db) {
  throw Error(Fault::Resource, fmt::format("the job queue cannot be used: {}", sqlite3_errmsg(db)),
              "check the free disk space and the permissions of the cases folder");
}

Statement prepare(sqlite3* db, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(db, sql, -1, &statement, nullptr) != SQLITE_OK) {
    fail(db);
  }
  return Statement(statement);
}

void bind_text(const Statement& statement, int at, const std::string& text) {
  sqlite3_bind_text(statement.get(), at, text.c_str(), -1, SQLITE_TRANSIENT);
}

std::string text_of(const Statement& statement, int column) {
  const auto* text = sqlite3_column_text(statement.get(), column);
  return text == nullptr ? std::string() : reinterpret_cast<const char*>(text);
}

json to_json(const Job& job) {
  json steps = json::array();
  for (const Step& step : job.steps) {
    steps.push_back({{"words", step.words}});
    if (step.clear_first) {
      steps.back()["clear_first"] = *step.clear_first;
    }
  }
  return {{"steps", steps},
          {"step", job.step},
          {"started_s", job.started_s},
          {"ended_s", job.ended_s},
          {"exit_code", job.exit_code},
          {"message", job.message},
          {"finished", job.progress.finished}};
}

void read_json(const json& j, Job& job) {
  for (const json& step : j.at("steps")) {
    job.steps.push_back({step.at("words").get<std::vector<std::string>>()});
    if (step.contains("clear_first")) {
      job.steps.back().clear_first = step["clear_first"].get<std::string>();
    }
  }
  job.step = j.at("step");
  job.started_s = j.at("started_s");
  job.ended_s = j.at("ended_s");
  job.exit_code = j.at("exit_code");
  job.message = j.at("message");
  job.progress.finished = j.at("finished").get<std::vector<std::string>>();
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& file) {
  if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK ||
      sqlite3_exec(db_, schema, nullptr, nullptr, nullptr) != SQLITE_OK) {
    const std::string cause = sqlite3_errmsg(db_);
    sqlite3_close(db_);
    throw Error(Fault::Resource, fmt::format("the job queue cannot be opened: {}", cause),
                "check the permissions of the cases folder");
  }
}

JobStore::~JobStore() {
  sqlite3_close(db_);
}

void JobStore::save(const StoredJob& stored) {
  const Job& job = stored.job;
  const Statement s = prepare(db_, "INSERT OR REPLACE INTO jobs VALUES(?,?,?,?,?,?,?,?)");
  bind_text(s, 1, job.id);
  sqlite3_bind_int64(s.get(), 2, job.created_s);
  bind_text(s, 3, job.case_id);
  bind_text(s, 4, job.kind);
  sqlite3_bind_int(s.get(), 5, static_cast<int>(job.state));
  sqlite3_bind_int64(s.get(), 6, stored.process.pid);
  sqlite3_bind_int64(s.get(), 7, static_cast<sqlite3_int64>(stored.process.start));
  bind_text(s, 8, to_json(job).dump());
  if (sqlite3_step(s.get()) != SQLITE_DONE) {
    fail(db_);
  }
}

std::vector<StoredJob> JobStore::load() const {
  const Statement s = prepare(db_,
                              "SELECT id,created_s,case_id,kind,state,pid,pid_start,job FROM jobs"
                              " ORDER BY created_s,rowid");
  std::vector<StoredJob> result;
  while (sqlite3_step(s.get()) == SQLITE_ROW) {
    StoredJob stored;
    stored.job.id = text_of(s, 0);
    stored.job.created_s = sqlite3_column_int64(s.get(), 1);
    stored.job.case_id = text_of(s, 2);
    stored.job.kind = text_of(s, 3);
    stored.job.state = static_cast<JobState>(sqlite3_column_int(s.get(), 4));
    stored.process.pid = static_cast<int>(sqlite3_column_int64(s.get(), 5));
    stored.process.start = static_cast<unsigned long long>(sqlite3_column_int64(s.get(), 6));
    read_json(json::parse(text_of(s, 7)), stored.job);
    result.push_back(std::move(stored));
  }
  return result;
}

void JobStore::forget(const std::string& id) {
  const Statement s = prepare(db_, "DELETE FROM jobs WHERE id=?");
  bind_text(s, 1, id);
  sqlite3_step(s.get());
}

}  // namespace sanatrix::server
