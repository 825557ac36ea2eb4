// ITK reads truncated NIfTI and MetaImage files without a word; this notices them.
#pragma once

#include <cstdint>
#include <filesystem>

namespace sanatrix::io {

/// False when the file (.nii, .nii.gz, .mha) cannot hold `voxel_bytes` of voxels or its compressed
/// stream is cut off or damaged. True for formats whose reader checks this itself.
bool is_complete(const std::filesystem::path& file, std::uint64_t voxel_bytes);

}  // namespace sanatrix::io
