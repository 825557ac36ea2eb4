// The checked labels of stage `segment` on disk.
#pragma once

#include <filesystem>
#include <optional>

#include "imaging/segmentation.hpp"

namespace sanatrix::pipeline {

void save_segmentation(const imaging::Segmentation& segmentation,
                       const std::filesystem::path& folder);
imaging::Segmentation load_segmentation(const std::filesystem::path& folder);
/// LPS [m], of what was saved; nothing where it was not found or is not sure.
std::optional<Vec3> sure_sternal_notch(const std::filesystem::path& folder);

}  // namespace sanatrix::pipeline
