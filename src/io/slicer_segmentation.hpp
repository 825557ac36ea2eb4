// Segmentations that 3D Slicer opens with names and colours (.seg.nrrd).
#pragma once

#include <filesystem>

#include "geometry/image.hpp"

namespace sanatrix::io {

/// Labels of the sanatrix table, one segment per label that occurs. Slicer's fields:
/// slicer.readthedocs.io, "Segmentations", file format. Written aside and renamed.
void write_slicer_segmentation(const LabelImage& labels, const std::filesystem::path& file);

}  // namespace sanatrix::io
