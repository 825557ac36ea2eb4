// Segmentations that 3D Slicer opens with names and colours (.seg.nrrd).
#pragma once

#include <filesystem>
#include <optional>

#include "geometry/image.hpp"

namespace sanatrix::io {

/// Labels of the sanatrix table, one segment per label that occurs. Slicer's fields:
/// slicer.readthedocs.io, "Segmentations", file format. Written aside and renamed.
void write_slicer_segmentation(const LabelImage& labels, const std::filesystem::path& file);

/// Segments by their names (English, singular or plural, any case) in the sanatrix table; where
/// layers overlap, the more special tissue. With a border of air towards anterior, since Slicer
/// crops to the segments. Nothing when the file is no NRRD with segments. Error{Input} naming a
/// segment whose name is no tissue.
std::optional<LabelImage> read_slicer_segmentation(const std::filesystem::path& file);

}  // namespace sanatrix::io
