// The phantom after surgery and complete healing: a prescribed truth. docs/theory/phantom.md
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/tet_mesh.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::phantom {

struct Scar {
  std::vector<mechanics::Tissue> tissue;  ///< per cell of the body
  double excised_m3;                      ///< of the prone body
};
/// What the plan removes from the true prone body (`prone`: per vertex) has become scar: full of
/// cells, as stiff as the wound's tissue and pulling with all of its traction, by the values of
/// vavourakis2016. No species are computed: that they end like this is what is asked of the
/// program.
Scar scar_of(const std::string& plan_json, const TetMesh& body, std::span<const Vec3> prone,
             std::span<const mechanics::Tissue> healthy, const Context& ctx);

}  // namespace sanatrix::phantom
