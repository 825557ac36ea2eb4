// Zip archives as patients' images and scans are sent: unpacked with suspicion.
#pragma once

#include <cstdint>
#include <filesystem>

namespace sanatrix::io {

struct ArchiveLimits {
  std::uint64_t entries = 20'000;
  std::uint64_t bytes = std::uint64_t{8} << 30;  ///< of everything that is in it
  std::uint64_t ratio = 200;                     ///< unpacked to packed, from 16 MB on
};

/// By its first bytes, not by its name.
bool is_zip(const std::filesystem::path& file);

/// Unpacks into a folder that must not exist yet; it is gone again when something is wrong. The
/// archive is read by libarchive in a confined child process. Error{Input}: damaged, with a
/// password, an entry that is no plain file or whose name leaves the folder, two entries of one
/// name, or nothing in it; Error{Resource}: beyond the limits, or the disk is full. Messages number
/// entries and never name them, since names may hold a person's.
void unpack_zip(const std::filesystem::path& archive, const std::filesystem::path& folder,
                const ArchiveLimits& limits = {});

}  // namespace sanatrix::io
