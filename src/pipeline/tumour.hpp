// Where the tumour is, from whatever says it: a plan or a Slicer markups file.
#pragma once

#include <filesystem>

#include "imaging/segmentation.hpp"

namespace sanatrix::pipeline {

/// A plan (its tumour) or a Slicer markups file `.mrk.json` with an ROI, or with two or more points
/// at the tumour's border (a line across it); LPS or RAS millimetres as the file says.
/// Error{Input} naming what is missing.
imaging::TumourSphere read_tumour(const std::filesystem::path& file);

/// As text for the case folder, and back.
std::string tumour_text(const imaging::TumourSphere& tumour);
imaging::TumourSphere tumour_from(const std::string& text);

}  // namespace sanatrix::pipeline
