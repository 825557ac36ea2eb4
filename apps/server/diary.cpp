#include "diary.hpp"

#include <fstream>
#include <regex>

#include <nlohmann/json.hpp>

namespace sanatrix::server {
namespace {

using nlohmann::json;

bool take(const json& event, JobProgress& progress) {
  const std::string kind = event.value("event", "");
  if (kind == "begin") {
    progress = {};
  } else if (kind == "started") {
    progress.stage = event.value("stage", "");
    progress.fraction = 0.0;
    progress.text.clear();
  } else if (kind == "progress") {
    progress.stage = event.value("stage", "");
    progress.fraction = event.value("fraction", 0.0);
    progress.text = event.value("text", "");
  } else if (kind == "finished") {
    progress.finished.push_back(event.value("stage", ""));
    progress.fraction = 1.0;
    progress.text.clear();
  } else {
    return false;
  }
  return true;
}

}  // namespace

void Diary::skip_old() {
  std::error_code none;
  const auto size = std::filesystem::file_size(file_, none);
  read_ = none ? 0 : size;
}

bool Diary::update(JobProgress& progress) {
  std::ifstream in(file_, std::ios::binary);
  if (!in || !in.seekg(static_cast<std::streamoff>(read_))) {
    return false;
  }
  std::string added((std::istreambuf_iterator<char>(in)), {});
  read_ += added.size();
  rest_ += added;
  bool changed = false;
  for (std::size_t end = rest_.find('\n'); end != std::string::npos; end = rest_.find('\n')) {
    const json event = json::parse(rest_.substr(0, end), nullptr, false);
    changed = (event.is_object() && take(event, progress)) || changed;
    rest_.erase(0, end + 1);
  }
  return changed;
}

bool parse_progress_line(const std::string& line, JobProgress& progress) {
  static const std::regex form(
      R"(^(?:\[[A-Z-]+\] )?([a-z]+) +(\d+) %(?:, ETA [0-9:]+)?(?:, (.*))?$)");
  std::smatch part;
  if (!std::regex_match(line, part, form)) {
    return false;
  }
  progress.stage = part[1];
  progress.fraction = std::stod(part[2]) / 100.0;
  progress.text = part[3];
  return true;
}

}  // namespace sanatrix::server
