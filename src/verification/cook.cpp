// Cook's membrane (VALIDATION.md C8): bending and near incompressibility, where elements lock.
#include <algorithm>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "mechanics/problem.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Element;

constexpr double shear = 80.1938, bulk = 400942.0;
constexpr double load = 6.25;  // per unit length of the right edge

/// Displacement of the upper right corner with n x n boxes in the plane, plane strain.
Vec3 corner_displacement(Element element, int n, const Context& ctx) {
  const double depth = 48.0 / n;
  const TetMesh mesh = lattice({n, n, 1}, [=](int i, int j, int k) {
    const double s = static_cast<double>(i) / n;
    const double t = static_cast<double>(j) / n;
    return Vec3{48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s), depth * k};
  });
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element;
  body.tissue.assign(mesh.cells.size(), {0.5 * shear, 0.0, bulk, 1.0, 1.0, 0.0});
  std::size_t corner = 0;
  for (const Vec3& p : mesh.points) {
    body.fixed.push_back(p[0] < 1e-9 ? 7 : 4);  // all lie on one of the two planes z
    if (p[0] + p[1] > mesh.points[corner][0] + mesh.points[corner][1]) {
      corner = body.fixed.size() - 1;
    }
  }
  for (const auto& face : boundary_of(mesh)) {
    if (std::ranges::all_of(face, [&](int v) {
          return mesh.points[static_cast<std::size_t>(v)][0] > 48.0 - 1e-9;
        })) {
      body.loads.traction_faces.push_back({face, 0});
    }
  }
  body.loads.traction = [](const Vec3&) {
    return Vec3{0.0, load, 0.0};
  };
  mechanics::Solver solver(body);
  const mechanics::Shape shape =
      solver.forward(solver.straight_nodes(mesh.points), {}, nullptr, ctx);
  return shape.nodes[corner] - mesh.points[corner];
}

Findings cook(Element element, const std::vector<int>& boxes, double tolerance,
              const Context& ctx) {
  Findings found;
  Table table{"", {"boxes per edge", "u_x", "u_y"}, {}};
  Curve ours{"corner, u_y", {}, {}};
  Vec3 u{};
  for (const int n : boxes) {
    u = corner_displacement(element, n, ctx);
    table.rows.push_back(
        {fmt::format("{}", n), fmt::format("{:.4f}", u[0]), fmt::format("{:.4f}", u[1])});
    ours.x.push_back(n);
    ours.y.push_back(u[1]);
  }
  const Curve reference{
      "32 x 32 Q2/P1 of an independent program", {ours.x.front(), ours.x.back()}, {6.927, 6.927}};
  found.tables.push_back(std::move(table));
  found.plots.push_back({"", "boxes per edge", "u_y of the corner", {ours, reference}, true});
  const std::string reason =
      fmt::format("{:.1f} % at {} boxes per edge", 100 * tolerance, boxes.back());
  found.checks.push_back(near("u_x of the corner", -5.826, u[0], 5.826 * tolerance, "", reason));
  found.checks.push_back(near("u_y of the corner", 6.927, u[1], 6.927 * tolerance, "", reason));
  return found;
}

constexpr auto about =
    "Plane strain, neo-Hookean, mu = 80.1938, kappa = 400942, dead load of 6.25 per unit length on "
    "the right edge. Reference: 32 x 32 Q2/P1 elements of an independent program, "
    "u = (-5.826, 6.927).";

}  // namespace

void add_cook(std::vector<Case>& cases) {
  cases.push_back({"cook-p1p1", "Cook's membrane, P1/P1 (C8)", Chapter::CodeVerification,
                   Cost::Fast, about, [](const Context& ctx) {
                     return cook(Element::P1P1, {8, 16, 32, 64}, 0.03, ctx);
                   }});
  cases.push_back({"cook-smoothed", "Cook's membrane, smoothed P1/P1 (C8)",
                   Chapter::CodeVerification, Cost::Fast, about, [](const Context& ctx) {
                     return cook(Element::Smoothed, {8, 16, 32}, 0.03, ctx);
                   }});
  cases.push_back({"cook-p2p1", "Cook's membrane, P2/P1 (C8)", Chapter::CodeVerification,
                   Cost::Fast, about, [](const Context& ctx) {
                     return cook(Element::P2P1, {4, 8, 16}, 0.01, ctx);
                   }});
}

}  // namespace sanatrix::verification
