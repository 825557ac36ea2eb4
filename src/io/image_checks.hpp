// What the readers of image files do not check, or answer with an abort of the process.
#pragma once

#include <cstdint>
#include <filesystem>

#include "geometry/vec3.hpp"

namespace sanatrix::io {

/// False when the file (.nii, .nii.gz, .mha) cannot hold its voxels (`voxel_bytes`, unless a NIfTI
/// header says how they are stored), or its compressed stream is cut off or damaged. True for
/// formats whose reader checks this itself.
bool is_complete(const std::filesystem::path& file, std::uint64_t voxel_bytes);

/// Error{Input} when a NIfTI or NRRD header has no place, an impossible or an ambiguous one; that
/// ITK would guess it, left and right included, or end the process. Other formats have no such
/// cases.
void require_sound_header(const std::filesystem::path& file);

/// Error{Input} unless voxels have a size that a scanner makes (0.02 to 50 mm) and perpendicular
/// axes: a gantry's tilt (shear) would silently be lost. `direction`: columns are i, j, k.
void require_sound_place(const Vec3& spacing_mm, const Vec3& origin_mm, const Mat3& direction);

}  // namespace sanatrix::io
