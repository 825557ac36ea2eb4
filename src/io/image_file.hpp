// Images in and out: NIfTI, NRRD, MetaImage through ITK. Positions are LPS millimetres.
#pragma once

#include <filesystem>

#include "geometry/image.hpp"

namespace sanatrix::io {

/// Integer label volume. Error{Input} names the file when it is missing, broken, not 3-D, or holds
/// values outside 0..255 or fractions.
LabelImage read_labels(const std::filesystem::path& file);
Image3<float> read_image(const std::filesystem::path& file);
/// Format by extension (.nii.gz, .nrrd, .mha). Written aside and renamed.
void write_labels(const LabelImage& image, const std::filesystem::path& file);
void write_image(const Image3<float>& image, const std::filesystem::path& file);

}  // namespace sanatrix::io
