// The segmentation drawn over the image, slice by slice, for a look before anything is believed.
#pragma once

#include <filesystem>
#include <span>

#include "geometry/image.hpp"

namespace sanatrix::render {

/// Nine axial slices from inferior to superior, seen from the feet as radiologists do (patient's
/// right on the left hand), with outlines of skin, gland, chest wall and tumour, orientation
/// letters, and z in mm; landmarks as crosses in the nearest of them. Needs no display. `labels`
/// lies in LPS. Written aside and renamed.
void write_overlay(const Image3<float>& image, const LabelImage& labels,
                   std::span<const Vec3> landmarks_mm, const std::filesystem::path& file);

}  // namespace sanatrix::render
