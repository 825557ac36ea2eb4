// What a NIfTI-1 header says of place and size, checked before ITK reads it: ITK ends the process
// on numbers that are not finite, and picks one of two contradicting places without a word.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace sanatrix::io {

/// Error{Input} when lengths or directions are not finite numbers, voxels have a size that no
/// scanner makes, the file does not say where the patient's left is (neither qform nor sform), or
/// both say it differently. Silent about files without such a header, .nii of other kinds among
/// them.
void require_sound_nifti_header(const std::filesystem::path& file);

/// Bytes of header and voxels as stored, before any rescaling; nothing without such a header.
std::optional<std::uint64_t> nifti_bytes(const std::filesystem::path& file);

}  // namespace sanatrix::io
