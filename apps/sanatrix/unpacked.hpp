// Inputs that may be zip archives.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace sanatrix::app {

/// Unpacks archives beside the case that is being made, and removes what it unpacked at its end.
class Unpacked {
 public:
  explicit Unpacked(const std::filesystem::path& new_case);
  ~Unpacked();
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;

  /// The path itself; for a zip archive the one image or scan in it, or else its folder (DICOM).
  /// Nothing for an empty text. Error{Input} when several images or scans are in it.
  std::optional<std::filesystem::path> operator()(const std::string& given);
  std::map<std::string, std::filesystem::path> operator()(
      std::map<std::string, std::filesystem::path> given);

 private:
  std::filesystem::path folder_;
  int archives_ = 0;
};

}  // namespace sanatrix::app
