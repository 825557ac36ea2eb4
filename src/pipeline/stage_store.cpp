#include "pipeline/stage_store.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr auto recipe_file = "recipe.json";
constexpr auto record_file = "stage.json";

fs::path sibling(const Case& patient, Stage stage, const std::string& prefix,
                 const std::string& suffix) {
  return patient.folder / "stages" / (prefix + info(stage).folder + suffix);
}
fs::path retired_folder(const Case& patient, Stage stage) {
  return sibling(patient, stage, ".", ".old");
}
fs::path failure_file(const Case& patient, Stage stage) {
  return sibling(patient, stage, "", ".failed.json");
}

std::optional<json> read_json(const fs::path& file) {
  if (!fs::exists(file)) {
    return std::nullopt;
  }
  json j = json::parse(read_text(file), nullptr, false);
  return j.is_object() ? std::optional(std::move(j)) : std::nullopt;
}

std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path().lexically_relative(folder).string());
    }
  }
  std::ranges::sort(files);
  return files;
}

void sync_tree(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    sync_to_disk(entry.path());
  }
  sync_to_disk(folder);
}

}  // namespace

std::optional<StageRecord> read_record(const Case& patient, Stage stage) {
  const auto j = read_json(patient.stage_folder(stage) / record_file);
  if (!j) {
    return std::nullopt;
  }
  try {
    StageRecord record;
    record.recipe.entries = j->at("recipe").get<std::map<std::string, std::string>>();
    record.seconds = j->at("seconds");
    record.warnings = j->at("warnings").get<std::vector<std::string>>();
    for (const auto& [name, value] : j->at("numbers").items()) {
      record.numbers.emplace_back(name, value.is_number() ? value.get<double>() : 0.0);
    }
    record.files = j->at("files").get<std::vector<std::string>>();
    return record;
  } catch (const json::exception&) {
    return std::nullopt;  // not readable: as good as absent, the stage runs again
  }
}

std::string name_of(State state) {
  static const std::array<std::string, 4> names{"fresh", "stale", "failed", "missing"};
  return names[static_cast<std::size_t>(state)];
}

StageStatus status(const Case& patient, Stage stage) {
  StageStatus s{.stage = stage, .state = State::Missing, .reason = "not run yet", .warnings = {}};
  const Recipe now = recipe(patient, stage);
  if (const auto record = read_record(patient, stage)) {
    const fs::path folder = patient.stage_folder(stage);
    s.seconds = record->seconds;
    s.warnings = record->warnings;
    s.reason = difference(record->recipe, now);
    for (const std::string& file : record->files) {
      if (!fs::exists(folder / file)) {
        s.reason = fmt::format("{} is missing", file);
      }
    }
    s.state = s.reason.empty() ? State::Fresh : State::Stale;
  }
  if (const auto failure = read_json(failure_file(patient, stage));
      failure && s.state != State::Fresh &&
      failure->value("fingerprint", "") == now.fingerprint()) {
    s.state = State::Failed;
    s.reason = failure->value("reason", "");
  }
  return s;
}

fs::path aside_folder(const Case& patient, Stage stage) {
  return sibling(patient, stage, ".", ".new");
}

void clean_up(const Case& patient) {
  for (const StageInfo& stage : all_stages()) {
    const fs::path result = patient.stage_folder(stage.id);
    const fs::path retired = retired_folder(patient, stage.id);
    if (fs::exists(retired)) {
      if (fs::exists(result)) {
        fs::remove_all(retired);
      } else {
        fs::rename(retired, result);
      }
    }
    const fs::path aside = aside_folder(patient, stage.id);
    const auto made_for = read_json(aside / recipe_file);
    const bool useful =
        made_for && fs::exists(aside / "checkpoint.bin") &&
        made_for->get<std::map<std::string, std::string>>() == recipe(patient, stage.id).entries;
    if (!useful) {
      fs::remove_all(aside);
    }
  }
}

void begin(const Case& patient, Stage stage) {
  const fs::path aside = aside_folder(patient, stage);
  std::error_code problem;
  fs::create_directories(aside, problem);
  if (problem) {
    throw Error(Fault::Resource,
                fmt::format("the case folder cannot be written: {}", problem.message()),
                "check the free space and the permissions of the case folder");
  }
  write_text(aside / recipe_file, json(recipe(patient, stage).entries).dump(1));
}

void commit(const Case& patient, Stage stage, StageRecord record) {
  const fs::path aside = aside_folder(patient, stage);
  const fs::path result = patient.stage_folder(stage);
  const fs::path retired = retired_folder(patient, stage);
  fs::remove(aside / recipe_file);
  fs::remove(aside / "checkpoint.bin");
  json numbers = json::object();
  for (const auto& [name, value] : record.numbers) {
    numbers[name] = value;
  }
  write_text(aside / record_file, json{{"stage", info(stage).name},
                                       {"status", "done"},
                                       {"fingerprint", record.recipe.fingerprint()},
                                       {"recipe", record.recipe.entries},
                                       {"seconds", record.seconds},
                                       {"warnings", record.warnings},
                                       {"numbers", numbers},
                                       {"files", files_in(aside)}}
                                          .dump(2) +
                                      "\n");
  sync_tree(aside);
  if (fs::exists(result)) {
    fs::rename(result, retired);
  }
  fs::rename(aside, result);
  sync_to_disk(result.parent_path());
  fs::remove_all(retired);
  fs::remove(failure_file(patient, stage));
}

void record_failure(const Case& patient, Stage stage, const std::string& reason) {
  write_text(failure_file(patient, stage),
             json{{"stage", info(stage).name},
                  {"status", "failed"},
                  {"fingerprint", recipe(patient, stage).fingerprint()},
                  {"reason", without_place(patient, reason)}}
                     .dump(2) +
                 "\n");
}

}  // namespace sanatrix::pipeline
