// Routing, the page's own files, and answers about jobs, events and uploads.
#include "planner.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <iterator>

#include "answers.hpp"
#include "child.hpp"
#include "client_files.hpp"
#include "core/error.hpp"

namespace sanatrix::server {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What may be uploaded; the name it was given may name a person and is not kept.
constexpr std::array upload_extensions{".nii.gz", ".nii", ".nrrd", ".mha", ".json",
                                       ".dcm",    ".zip", ".obj",  ".mtl", ".ply",
                                       ".stl",    ".jpg", ".jpeg", ".png"};

constexpr std::ptrdiff_t most_files_of_an_upload = 20'000;

std::string extension_of(const std::string& name) {
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (std::string known : upload_extensions) {
    if (lower.ends_with(known)) {
      return known;
    }
  }
  // Files of a DICOM series often have no extension, or digits and dots.
  return ".dcm";
}

/// Files of a scan name each other, so the page gives them names that say nothing; only those are
/// kept.
bool is_neutral(const std::string& name) {
  static const std::regex form(
      R"(scan\.obj|material-[0-9]{1,3}\.mtl|picture-[0-9]{1,3}\.(jpe?g|png))");
  return std::regex_match(name, form);
}

/// A server-sent event.
std::string event(const std::string& name, const json& data) {
  return "event: " + name + "\ndata: " + data.dump(-1, ' ', false, json::error_handler_t::replace) +
         "\n\n";
}

bool is_upload_id(const std::string& id) {
  return id.size() == 32 && id.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

Planner::Planner(CaseStore& cases, JobQueue& jobs, const Abilities& abilities)
    : cases_(cases), jobs_(jobs), abilities_(abilities) {
  add("GET", "/api/session", &Planner::session);
  add("GET", "/api/cases", &Planner::list_cases);
  add("POST", "/api/cases", &Planner::create_case);
  add("GET", "/api/cases/{case}", &Planner::show_case);
  add("DELETE", "/api/cases/{case}", &Planner::delete_case);
  add("POST", "/api/cases/{case}/copies", &Planner::copy_case);
  add("POST", "/api/cases/{case}/run", &Planner::run_case);
  add("GET", "/api/cases/{case}/scene", &Planner::scene);
  add("GET", "/api/cases/{case}/healing", &Planner::healing);
  add("GET", "/api/cases/{case}/volume", &Planner::volume);
  add("GET", "/api/cases/{case}/plan", &Planner::show_plan);
  add("POST", "/api/cases/{case}/preview", &Planner::preview_plan);
  add("POST", "/api/cases/{case}/incisions/{kind}", &Planner::propose_incision);
  add("POST", "/api/cases/{case}/name", &Planner::name_plan);
  add("GET", "/api/cases/{case}/photograph", &Planner::photograph);
  add("GET", "/api/cases/{case}/carry", &Planner::carry_point);
  add("GET", "/api/cases/{case}/files", &Planner::list_files);
  add("GET", "/api/cases/{case}/files/{stage}/{file}", &Planner::send_file);
  add("GET", "/api/jobs", &Planner::list_jobs);
  add("POST", "/api/jobs/{job}/cancel", &Planner::cancel_job);
  add("POST", "/api/jobs/{job}/resume", &Planner::resume_job);
  add("GET", "/api/events", &Planner::events);
  add("POST", "/api/uploads", &Planner::take_upload);
  add("GET", "/api/uploads/{upload}/series", &Planner::list_series);
}

void Planner::add(const std::string& method, const std::string& pattern, Answer reply) {
  std::string form = std::regex_replace(pattern, std::regex(R"(\{file\})"), "(.+)");
  form = std::regex_replace(form, std::regex(R"(\{[a-z]+\})"), "([^/]+)");
  routes_.push_back({method, pattern, std::regex("^" + form + "$"), reply});
}

std::vector<std::string> Planner::routes() const {
  std::vector<std::string> list;
  for (const Route& route : routes_) {
    list.push_back(route.method + " " + route.pattern);
  }
  return list;
}

std::optional<Response> Planner::refuse(const Request& head) {
  if (auto refusal = guard_->refuse(head)) {
    return refusal;
  }
  // A full disk would fail the computation in the middle; better say it before.
  constexpr std::uintmax_t reserve = 1ULL << 30U;
  std::error_code none;
  if (head.path == "/api/uploads" && fs::space(cases_.root(), none).available < reserve) {
    return json_answer({{"fault", "server"},
                        {"what", "less than 1 GB is free on the disk of the cases"},
                        {"hint", "delete cases that are not needed any more"}},
                       507);
  }
  return std::nullopt;
}

std::optional<fs::path> Planner::upload_target(const Request& head) {
  if (head.method != "POST" || head.path != "/api/uploads") {
    return std::nullopt;
  }
  const std::string batch = head.parameter("batch");
  const std::string id = is_upload_id(batch) ? batch : random_name();
  const fs::path folder = cases_.own_folder() / "uploads" / id;
  std::error_code none;
  fs::create_directories(folder, none);
  const std::string name = head.parameter("name");
  if (is_neutral(name)) {
    return folder / name;
  }
  // A file that exists already makes the upload fail: a series has fewer files than this.
  if (std::distance(fs::directory_iterator(folder, none), fs::directory_iterator()) >=
      most_files_of_an_upload) {
    return folder;
  }
  return folder / (random_name().substr(0, 8) + extension_of(name));
}

Response Planner::answer(const Request& request) {
  try {
    return route(request);
  } catch (...) {  // every failure is an answer
    return error_answer();
  }
}

Response Planner::route(const Request& request) {
  if (request.method == "GET" && request.path == "/start") {
    return guard_->enter(request);
  }
  if (request.method == "GET" && !request.path.starts_with("/api/")) {
    const std::string name = request.path == "/" ? "/index.html" : request.path;
    if (const auto file = client_file(name)) {
      return {.type = content_type(name), .body = std::string(*file)};
    }
  }
  bool known = false;
  for (const Route& route : routes_) {
    std::smatch match;
    if (std::regex_match(request.path, match, route.form)) {
      known = true;
      if (route.method == request.method) {
        return (this->*route.answer)(request, Parts(std::next(match.begin()), match.end()));
      }
    }
  }
  const int status = known ? 405 : 404;
  return json_answer({{"fault", "input"},
                      {"what", known ? "this cannot be done here" : "there is nothing here"},
                      {"hint", ""}},
                     status);
}

Response Planner::session(const Request&, const Parts&) {
  json presets = json::array(), parameters = json::array();
  for (const pipeline::ParameterInfo& p : pipeline::parameter_table()) {
    if (p.key == "heal.preset") {
      presets = p.choices;
    }
  }
  return json_answer({{"proof", guard_->proof()},
                      {"abilities",
                       {{"dicom", abilities_.dicom},
                        {"scan", abilities_.scan},
                        {"scan_only", abilities_.scan_only},
                        {"tumour", abilities_.tumour},
                        {"report", abilities_.report}}},
                      {"healing_presets", presets},
                      {"notice", "Research use only. Not a medical device."}});
}

Response Planner::list_jobs(const Request&, const Parts&) {
  json list = json::array();
  for (const Job& job : jobs_.jobs()) {
    list.push_back(to_json(job));
  }
  return json_answer({{"jobs", list}});
}

Response Planner::cancel_job(const Request&, const Parts& parts) {
  jobs_.cancel(parts[0]);
  return json_answer({{"ok", true}});
}

Response Planner::resume_job(const Request&, const Parts& parts) {
  jobs_.resume(parts[0]);
  return json_answer({{"ok", true}});
}

Response Planner::events(const Request&, const Parts&) {
  Response response;
  response.feed = [this, told = -1L, stamps = json(), looked = std::time_t{0}]() mutable {
    std::string news;
    // Cases also change without the queue: other pages, the command line.
    if (const std::time_t second = std::time(nullptr); second != looked) {
      looked = second;
      json fresh = cases_.stamps();
      if (fresh != stamps) {
        stamps = std::move(fresh);
        news += event("cases", {{"cases", stamps}});
      }
    }
    const long now = jobs_.revision();
    if (now == told) {
      return news;
    }
    told = now;
    json list = json::array();
    for (const Job& job : jobs_.jobs()) {
      if (list.size() < 20) {
        list.push_back(to_json(job));
      }
    }
    return news + event("jobs", {{"jobs", list}});
  };
  return response;
}

Response Planner::take_upload(const Request& request, const Parts&) {
  ensure(!request.upload.empty(), "an upload without a file");
  require(fs::file_size(request.upload) > 0, "the uploaded file is empty");
  return json_answer({{"upload", request.upload.parent_path().filename().string()}}, 201);
}

fs::path Planner::uploaded(const json& id) const {
  require(id.is_string() && is_upload_id(id.get<std::string>()), "this is not an upload");
  const fs::path folder = cases_.own_folder() / "uploads" / id.get<std::string>();
  require(fs::is_directory(folder) && !fs::is_empty(folder), "the upload is not there any more");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  // A scan's material and photographs lie beside it and are found from there.
  const auto scan =
      std::ranges::find(files, "scan.obj", [](const fs::path& f) { return f.filename(); });
  return scan != files.end() ? *scan : files.size() == 1 ? files[0] : folder;
}

Response Planner::list_series(const Request&, const Parts& parts) {
  using namespace std::chrono_literals;
  // One at a time: each takes a thread of the few that answer.
  const std::unique_lock alone(looking_, std::try_to_lock);
  if (!alone) {
    throw Error(Fault::Resource, "other images are being read", "wait a moment and choose again");
  }
  const std::string told =
      output_of({"inspect", uploaded(parts[0]).string(), "--json"}, cases_.own_folder(), 120s);
  return json_answer(json::parse(told));
}

}  // namespace sanatrix::server
