#include "case_store.hpp"

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::server {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t longest_name = 64, longest_plan_name = 120, kept_views = 4;
/// Stages whose results do not depend on the plan.
constexpr std::array plan_free{"10-image", "20-segment", "30-mesh", "40-unload", "50-supine"};

bool is_name(const std::string& id) {
  return !id.empty() && id.size() <= longest_name && id.front() != '.' && id.front() != '-' &&
         id.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.") ==
             std::string::npos;
}

bool is_plain_folder(const fs::path& path) {
  std::error_code none;
  return fs::symlink_status(path, none).type() == fs::file_type::directory;
}

bool is_plain_file(const fs::path& path) {
  std::error_code none;
  return fs::symlink_status(path, none).type() == fs::file_type::regular;
}

json stage_json(const fs::path& stage_folder) {
  const fs::path file = stage_folder / "stage.json";
  return is_plain_file(file) ? json::parse(read_text(file), nullptr, false) : json();
}

/// The report has no record of its own; it is written completely or not at all.
json report_files(const fs::path& folder) {
  json files = json::array();
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    files.push_back(entry.path().filename().string());
  }
  return files;
}

json listed_files(const fs::path& folder) {
  if (folder.filename() == "95-report") {
    return report_files(folder);
  }
  const json record = stage_json(folder);
  return record.is_object() ? record.value("files", json::array()) : json::array();
}

/// Listed names are our own, but the folder may have been mailed to us: a result is a plain file
/// that really lies in its stage's folder.
bool is_result(const pipeline::Case& patient, const fs::path& folder, const fs::path& file) {
  if (file.is_absolute() || file.lexically_normal() != file || !is_plain_file(folder / file)) {
    return false;
  }
  std::error_code problem;
  const fs::path real = fs::canonical(folder / file, problem);
  return !problem &&
         real == fs::canonical(patient.folder, problem) / "stages" / folder.filename() / file;
}

std::string stamp_of(const pipeline::Case& patient) {
  std::string stamp;
  for (const pipeline::StageInfo& stage : pipeline::all_stages()) {
    std::error_code none;
    const auto time = fs::last_write_time(patient.stage_folder(stage.id) / "stage.json", none);
    stamp += none ? "-" : std::to_string(time.time_since_epoch().count());
  }
  return stamp;
}

json names_in(const fs::path& own_folder) {
  const fs::path file = own_folder / "names.json";
  const json names = is_plain_file(file) ? json::parse(read_text(file), nullptr, false) : json();
  return names.is_object() ? names : json::object();
}

/// What nobody made a case of within a week.
void forget_old_uploads(const fs::path& folder) {
  using namespace std::chrono_literals;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::error_code none;
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(entry.path(), none);
    if (!none && age > 7 * 24h) {
      fs::remove_all(entry.path(), none);
    }
  }
}

}  // namespace

CaseStore::CaseStore(const fs::path& root) : root_(fs::absolute(root).lexically_normal()) {
  std::error_code problem;
  fs::create_directories(own_folder() / "uploads", problem);
  if (problem) {
    throw Error(Fault::Resource,
                fmt::format("{}: cannot be used for cases: {}", root_.filename().string(),
                            problem.message()),
                "give a folder you may write to with --cases");
  }
  fs::permissions(own_folder(), fs::perms::owner_all, problem);
  forget_old_uploads(own_folder() / "uploads");
}

fs::path CaseStore::folder(const std::string& id) const {
  require(is_name(id), "this is not the name of a case");
  return root_ / id;
}

pipeline::Case CaseStore::open(const std::string& id) const {
  const fs::path place = folder(id);
  if (!is_plain_folder(place) || !is_plain_file(place / "case.json")) {
    throw Error(Fault::Input, "there is no such case", "it may have been deleted; see the list");
  }
  return pipeline::open_case(place);
}

std::vector<std::string> CaseStore::ids() const {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  for (const auto& entry : fs::directory_iterator(root_)) {
    const std::string name = entry.path().filename().string();
    std::error_code none;
    if (is_name(name) && is_plain_folder(entry.path()) &&
        is_plain_file(entry.path() / "case.json")) {
      found.emplace_back(fs::last_write_time(entry.path() / "case.json", none), name);
    }
  }
  std::ranges::sort(found, std::greater<>());
  std::vector<std::string> names;
  for (auto& [time, name] : found) {
    names.push_back(std::move(name));
  }
  return names;
}

std::string CaseStore::free_id(const std::string& wanted) const {
  std::string base;
  for (const char c : wanted.substr(0, longest_name - 6)) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    base += plain && !(base.empty() && c == '-') ? c : (base.empty() ? 'c' : '-');
  }
  base = base.empty() ? "case" : base;
  std::string name = base;
  for (int i = 2; fs::exists(root_ / name); ++i) {
    name = fmt::format("{}-{}", base, i);
  }
  return name;
}

void CaseStore::copy_for_plan(const std::string& from, const std::string& to) const {
  const fs::path source = open(from).folder, target = folder(to);
  const fs::path aside = root_ / fmt::format(".{}.copy", to);
  std::error_code none;
  fs::remove_all(aside, none);
  fs::create_directories(aside / "stages");
  fs::copy_file(source / "case.json", aside / "case.json");
  fs::copy(source / "inputs", aside / "inputs", fs::copy_options::recursive);
  for (const char* stage : plan_free) {
    if (is_plain_folder(source / "stages" / stage)) {
      fs::copy(source / "stages" / stage, aside / "stages" / stage, fs::copy_options::recursive);
    }
  }
  fs::rename(aside, target);
}

std::string CaseStore::plan_name(const std::string& id) const {
  const std::scoped_lock lock(names_mutex_);
  const json names = names_in(own_folder());
  return names.contains(id) && names[id].is_string() ? names[id].get<std::string>() : "";
}

void CaseStore::name_plan(const std::string& id, const std::string& name) const {
  require(name.size() <= longest_plan_name, "the name of a plan has at most {} characters",
          longest_plan_name);
  const std::scoped_lock lock(names_mutex_);
  json names = names_in(own_folder());
  if (name.empty()) {
    names.erase(id);
  } else {
    names[id] = name;
  }
  write_text(own_folder() / "names.json", names.dump(1) + "\n");
}

json CaseStore::stamps() const {
  json stamps = json::object();
  for (const std::string& id : ids()) {
    std::error_code none;
    const auto time = fs::last_write_time(root_ / id / "case.json", none).time_since_epoch();
    stamps[id] = std::to_string(time.count()) + plan_name(id);
  }
  return stamps;
}

void CaseStore::remove(const std::string& id) const {
  const pipeline::Case patient = open(id);
  { const pipeline::CaseLock nobody_works_on_it(patient.folder); }
  const fs::path aside = root_ / fmt::format(".{}.deleted", id);
  fs::rename(patient.folder, aside);
  fs::remove_all(aside);
  name_plan(id, "");
}

std::shared_ptr<const pipeline::CaseView> CaseStore::view(const pipeline::Case& patient) {
  const std::string name = patient.folder.filename().string(), stamp = stamp_of(patient);
  const std::scoped_lock lock(mutex_);
  Kept& kept = views_[name];
  if (kept.view == nullptr || kept.stamp != stamp) {
    kept = {stamp, std::make_shared<const pipeline::CaseView>(patient)};
  }
  kept.used = ++questions_;
  auto view = kept.view;
  if (views_.size() > kept_views) {
    views_.erase(std::ranges::min_element(views_, {}, [](const auto& v) { return v.second.used; }));
  }
  return view;
}

fs::path CaseStore::result_file(const pipeline::Case& patient, const std::string& stage_folder,
                                const std::string& file) const {
  const fs::path folder = patient.folder / "stages" / stage_folder;
  const bool known = is_name(stage_folder) && is_plain_folder(folder);
  const json files = known ? listed_files(folder) : json::array();
  const bool listed = std::ranges::any_of(files, [&](const json& f) { return f == file; });
  fs::path path = folder / file;
  if (!listed || !is_result(patient, folder, file)) {
    throw Error(Fault::Input, "there is no such result", "run the case first");
  }
  return path;
}

json result_files(const pipeline::Case& patient) {
  json list = json::array();
  std::error_code none;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(patient.folder / "stages", none)) {
    if (is_plain_folder(entry.path()) && is_name(entry.path().filename().string())) {
      folders.push_back(entry.path());
    }
  }
  std::ranges::sort(folders);
  for (const fs::path& folder : folders) {
    for (const json& file : listed_files(folder)) {
      if (file.is_string() && is_result(patient, folder, file.get<std::string>())) {
        list.push_back({{"stage", folder.filename().string()},
                        {"file", file},
                        {"bytes", fs::file_size(folder / file.get<std::string>(), none)}});
      }
    }
  }
  return list;
}

}  // namespace sanatrix::server
