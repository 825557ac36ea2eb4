#include "unpacked.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "core/error.hpp"
#include "io/archive.hpp"

namespace sanatrix::app {
namespace {

namespace fs = std::filesystem;

/// Formats that are one file; a DICOM series is a folder.
bool is_single(const fs::path& file) {
  std::string name = file.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::any_of(std::array{".nii.gz", ".nii", ".nrrd", ".mha", ".obj", ".ply", ".stl"},
                             [&](const char* end) { return name.ends_with(end); });
}

}  // namespace

Unpacked::Unpacked(const fs::path& new_case) {
  const fs::path place = fs::absolute(new_case).lexically_normal();
  const fs::path final = place.filename().empty() ? place.parent_path() : place;
  folder_ = final.parent_path() / fmt::format(".{}.unpacked", final.filename().string());
  std::error_code none;
  fs::remove_all(folder_, none);  // of a run that was killed
}

Unpacked::~Unpacked() {
  std::error_code none;
  fs::remove_all(folder_, none);
}

std::optional<fs::path> Unpacked::operator()(const std::string& given) {
  if (given.empty()) {
    return std::nullopt;
  }
  if (!io::is_zip(given)) {
    return given;
  }
  const fs::path folder = folder_ / std::to_string(++archives_);
  fs::create_directories(folder_);
  io::unpack_zip(given, folder);
  std::vector<fs::path> singles;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && is_single(entry.path())) {
      singles.push_back(entry.path());
    }
  }
  require(singles.size() <= 1, "the archive holds {} images or scans; pack the one that is meant",
          singles.size());
  return singles.empty() ? folder : singles[0];
}

std::map<std::string, fs::path> Unpacked::operator()(std::map<std::string, fs::path> given) {
  for (auto& [name, file] : given) {
    file = *(*this)(file.string());
  }
  return given;
}

}  // namespace sanatrix::app
