// The checked labels of stage `segment` on disk.
#pragma once

#include <filesystem>

#include "imaging/segmentation.hpp"

namespace sanatrix::pipeline {

void save_segmentation(const imaging::Segmentation& segmentation,
                       const std::filesystem::path& folder);
imaging::Segmentation load_segmentation(const std::filesystem::path& folder);

}  // namespace sanatrix::pipeline
