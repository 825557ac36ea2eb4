// What a plan would remove, answered from memory while the surgeon is still drawing. The same code
// as stage `surgery`.
#pragma once

#include "pipeline/case_view.hpp"
#include "surgery/place.hpp"

namespace sanatrix::pipeline {

struct PlanPreview {
  surgery::Wound wound;
  double excised_g = 0.0;
  double breast_cm3 = 0.0;  ///< of the operated breast, prone, as in outcome.json
  surgery::Place place;
  TriMesh surface;                           ///< of what is removed, in the plan's pose [m]
  std::vector<std::vector<Vec3>> incisions;  ///< on the skin, in the plan's pose [m]
};

PlanPreview preview(const surgery::Plan& plan, const CaseView& view, const Parameters& parameters,
                    surgery::Detail detail);
/// A usual incision for this plan, in the plan's frame: "circumareolar", "radial", "inframammary".
/// Error{Input} for other words.
std::vector<Vec3> usual_incision(const std::string& kind, const surgery::Plan& plan,
                                 const CaseView& view);

}  // namespace sanatrix::pipeline
