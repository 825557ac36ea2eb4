// Body forces, tractions and moved supports: the loads of verification.
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "geometry/structured_mesh.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/problem.hpp"

namespace sanatrix::mechanics {
namespace {

const Tissue tissue{150.0, 100.0, 2.5e5, 1000.0, 1.0, 0.0};

void hold(Body& body, const std::string& boundary, int bits) {
  for (const int v : vertices_on(*body.mesh, boundary)) {
    body.fixed[static_cast<std::size_t>(v)] |= static_cast<std::uint8_t>(bits);
  }
}

struct ABlock : ::testing::TestWithParam<Element> {
  TetMesh mesh = block({0.02, 0.01, 0.01}, {3, 2, 2});
  Body body;
  Silent silent;
  Context ctx{"test", silent};

  ABlock() {
    body.mesh = &mesh;
    body.element = GetParam();
    body.tissue.assign(mesh.cells.size(), tissue);
    body.fixed.assign(mesh.points.size(), 0);
  }
  /// Largest distance between two shapes, relative to the size of the block.
  static double distance(std::span<const Vec3> a, std::span<const Vec3> b) {
    double most = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) {
      most = std::max(most, norm(a[n] - b[n]));
    }
    return most / 0.02;
  }
};
INSTANTIATE_TEST_SUITE_P(Elements, ABlock,
                         ::testing::Values(Element::P1P1, Element::Smoothed, Element::P2P1),
                         [](const auto& p) { return name_of(p.param); });

TEST_P(ABlock, SagsAlikeUnderGravityAndUnderTheSameBodyForce) {
  hold(body, "x0", 7);
  const Vec3 down{0.0, 0.0, -9.81};
  Solver by_gravity(body);
  const auto rest = by_gravity.straight_nodes(mesh.points);
  const Shape hung = by_gravity.forward(rest, down, nullptr, ctx);
  body.loads.body_force = [&](const Vec3&) {
    return tissue.density * down;
  };
  Solver by_force(body);
  // Both solve the same equations to 1e-9 of the load.
  EXPECT_LT(distance(hung.nodes, by_force.forward(rest, {}, nullptr, ctx).nodes), 1e-7);
  EXPECT_THROW(by_force.inverse(rest, {}, ctx), Error);
}

TEST_P(ABlock, GivesUpWhenALoadPathHasTakenAllItsIterations) {
  hold(body, "x0", 7);
  const Vec3 down{0.0, 0.0, -9.81};
  Solver patient(body);
  const auto rest = patient.straight_nodes(mesh.points);
  patient.forward(rest, down, nullptr, ctx);
  const int needed = patient.last_report().newton_iterations;
  Solver hasty(body, {.max_newton_total = needed - 1});
  try {
    hasty.forward(rest, down, nullptr, ctx);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Numerics);
    EXPECT_NE(std::string(e.what()).find(fmt::format("in {} iterations", needed - 1)),
              std::string::npos);
  }
}

// An affine deformation with held faces on one side and its exact traction on the other is
// reproduced exactly: the patch test.
TEST_P(ABlock, TakesAnAffineDeformationFromSupportsAndTraction) {
  const Mat3 F{{{1.15, 0.08, 0.0}, {0.0, 0.95, 0.05}, {0.0, 0.0, 0.92}}};
  const double pressure = tissue.kappa * (determinant(F) - 1.0);
  const StressPoint at = stress(tissue, F, pressure);
  for (const char* face : {"x0", "y0", "y1", "z0", "z1"}) {
    hold(body, face, 7);
  }
  for (const BoundaryFace& face : mesh.faces) {
    if (mesh.boundary_names[static_cast<std::size_t>(face.name)] == "x1") {
      body.loads.traction_faces.push_back(face);
    }
  }
  body.loads.traction = [&](const Vec3&) {
    return at.P * Vec3{1.0, 0.0, 0.0};
  };
  const auto rest = Solver(body).straight_nodes(mesh.points);
  std::vector<Vec3> expected;
  for (const Vec3& X : rest) {
    expected.push_back(F * X);
    body.loads.prescribed.push_back(expected.back() - X);
  }
  Solver solver(body);
  const Shape guess{expected, {}};  // right places, wrong pressure
  const Shape found = solver.forward(rest, {}, &guess, ctx);
  EXPECT_LT(distance(found.nodes, expected), 1e-6);  // P1/P1: its barrier, (J - 1)^2
  const double share =
      GetParam() == Element::P1P1 ? 1.0 - own_bulk_modulus(tissue) / tissue.kappa : 1.0;
  for (const double p : found.pressure) {
    EXPECT_NEAR(p / (share * pressure), 1.0, 1e-4);  // the share's barrier: (J - 1)^2
  }
}

}  // namespace
}  // namespace sanatrix::mechanics
