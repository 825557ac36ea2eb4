// Named arrays of numbers in one file, exact to the bit: what stages hand to each other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace sanatrix {

/// A small container: name -> array of doubles or of 64-bit integers. Little-endian on disk with a
/// magic number, version and SHA-256 trailer; load throws Error{Input} for truncated or changed
/// files.
struct Archive {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
  std::map<std::string, std::string> texts;

  void save(const std::filesystem::path& file) const;  ///< aside, flushed, renamed
  static Archive load(const std::filesystem::path& file);
  /// Error{Input} naming the file's missing entry.
  [[nodiscard]] const std::vector<double>& real(const std::string& name) const;
  [[nodiscard]] const std::vector<std::int64_t>& integer(const std::string& name) const;
};

}  // namespace sanatrix
