// Where the mesh must be fine. It follows the plan lazily: small changes of a plan keep the mesh.
#pragma once

#include <optional>

#include "geometry/image.hpp"
#include "meshing/breast_mesh.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::pipeline {

/// What the plan says about the place, before any anatomy is known. [m], LPS, prone
struct FocusRule {
  std::optional<Vec3>
      centre;                ///< nothing: the labelled tumour of this side (plans drawn in supine)
  std::optional<Vec3> axis;  ///< towards the skin; nothing: away from the nearest chest wall
  surgery::Side side = surgery::Side::Left;
  double radius = 0.0;  ///< fine within this distance of the resection's axis
};

/// The old rule while the plan's resection lies inside it (or reaches at most 10 mm out, where the
/// mesh is still graded), else a new one with room to spare.
FocusRule follow(const std::optional<FocusRule>& old, const surgery::Plan& plan);

/// The axis of the resection between chest wall and skin, found in the labels. Nothing when the
/// rule needs a labelled tumour and there is none.
std::optional<meshing::Focus> place(const FocusRule& rule, const LabelImage& labels,
                                    double midline_x_mm);

}  // namespace sanatrix::pipeline
