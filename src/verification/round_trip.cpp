// Unloading a body with skin, tension field and two tissues, then loading it again (C10).
#include <algorithm>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "mechanics/problem.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Element;

/// A quarter of a breast-like half ball, held at its base and on no other face.
Findings round_trip(Element element, int layers, const Vec3& gravity, const Context& ctx) {
  std::vector<double> radii;
  for (int i = 0; i <= layers; ++i) {
    radii.push_back(0.065 * i / layers);
  }
  const TetMesh mesh = ball_octant(radii);
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const bool gland = norm(centroid(mesh, c)) < 0.035;
    body.tissue.push_back(gland ? mechanics::Tissue{160.0, 160.0, 5e5, 1020.0, 1.0, 0.0}
                                : mechanics::Tissue{150.0, 100.0, 2.5e5, 950.0, 1.0, 0.0});
  }
  body.skins.push_back({});
  const int outer = boundary_index(mesh, "outer");
  for (const BoundaryFace& face : mesh.faces) {
    if (face.name == outer) {
      body.skin_faces.push_back({face.vertex, 0});
    }
  }
  body.fixed.assign(mesh.points.size(), 0);
  for (const int v : vertices_on(mesh, "z0")) {
    body.fixed[static_cast<std::size_t>(v)] = 7;
  }
  mechanics::Solver solver(body);
  const auto given = solver.straight_nodes(mesh.points);
  const mechanics::Shape unloaded = solver.inverse(given, gravity, ctx);
  const mechanics::Shape again = solver.forward(unloaded.nodes, gravity, nullptr, ctx);
  double moved = 0.0;
  double worst = 0.0;
  for (std::size_t n = 0; n < given.size(); ++n) {
    moved = std::max(moved, norm(unloaded.nodes[n] - given[n]));
    worst = std::max(worst, norm(again.nodes[n] - given[n]));
  }
  const std::string name = fmt::format("{}, gravity ({:g}, {:g}, {:g})", title_of(element),
                                       gravity[0], gravity[1], gravity[2]);
  Findings found;
  found.checks.push_back(within(name + ": largest displacement", 2.0, 40.0, 1e3 * moved, "mm",
                                "the trip must be worth making"));
  found.checks.push_back(within(name + ": gap after the trip / displacement", 0.0, 1e-6,
                                worst / moved, "", "solver tolerance: both solve R(X, x, p) = 0"));
  return found;
}

Findings round_trips(const Context& ctx) {
  Findings found;
  for (const auto& [element, layers, gravity] :
       {std::tuple{Element::P1P1, 8, Vec3{0, 0, 9.81}},
        std::tuple{Element::P1P1, 8, Vec3{0, -9.81, 0}},
        std::tuple{Element::Smoothed, 8, Vec3{0, 0, 9.81}},
        std::tuple{Element::Smoothed, 8, Vec3{0, -9.81, 0}},
        std::tuple{Element::P2P1, 4, Vec3{0, 0, 9.81}}}) {
    const Findings one = round_trip(element, layers, gravity, ctx);
    found.checks.insert(found.checks.end(), one.checks.begin(), one.checks.end());
  }
  return found;
}

}  // namespace

void add_round_trip(std::vector<Case>& cases) {
  cases.push_back({"round-trip", "Unloaded and loaded again (C10)", Chapter::CodeVerification,
                   Cost::Fast,
                   "An eighth of a ball of 65 mm, held at its base, with two tissues and the "
                   "skin with its tension field, prone and upright.",
                   round_trips});
}

}  // namespace sanatrix::verification
