// What the browser draws, as bundles of typed arrays.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "pipeline/plan_preview.hpp"

namespace sanatrix::server {

/// Skin and cut faces in every pose, nipples, tumour, and the last surgery's wound and incision.
std::string scene_bundle(const pipeline::Case& patient, const pipeline::CaseView& view);
/// Tetrahedra of the operated side with every species at every recorded moment. Error{Input}
/// before stage heal has run.
std::string healing_bundle(const pipeline::Case& patient, const pipeline::CaseView& view);
/// The checked labels and, if there is one, the greyscale image on the same grid.
std::string volume_bundle(const pipeline::Case& patient);
/// Live numbers in the head; the removed piece and incisions as arrays in every pose.
std::string preview_bundle(const surgery::Plan& plan, const pipeline::PlanPreview& preview,
                           const pipeline::CaseView& view);

/// The scan before surgery with its photograph, and the same after surgery as predicted. `scratch`
/// is a file of ours that may be written. Error{Input} without a photograph or a result.
std::string photograph_bundle(const pipeline::Case& patient, const std::filesystem::path& scratch);

}  // namespace sanatrix::server
