// Where the tumour is, from whatever says it: a plan, a Slicer markups file, or a mask.
#pragma once

#include <filesystem>

#include "imaging/segmentation.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::pipeline {

/// A plan (its tumour) or a Slicer markups file `.mrk.json` with an ROI, or with two or more points
/// at the tumour's border (a line across it); LPS or RAS millimetres as the file says.
/// Of a mask (NIfTI, NRRD, MetaImage; not zero is tumour; of a `.seg.nrrd` the segment with a
/// tumour's name) the centre and the sphere of the same volume. Error{Input} naming what is
/// missing.
imaging::TumourSphere read_tumour(const std::filesystem::path& file);

/// Error{Input} when a prone plan's tumour does not touch this one: another side, frame or patient.
void check_agreement(const imaging::TumourSphere& tumour, const surgery::Plan& plan);

/// As text for the case folder, and back.
std::string tumour_text(const imaging::TumourSphere& tumour);
imaging::TumourSphere tumour_from(const std::string& text);

}  // namespace sanatrix::pipeline
