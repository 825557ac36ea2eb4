// Numbers for the surgeon against closed forms.
#include "outcome/outcome.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "simple_meshes.hpp"

namespace sanatrix::outcome {
namespace {

using testing::cube;
using testing::sphere;
using testing::square;

TriMesh mirrored(TriMesh surface) {
  for (Vec3& p : surface.points) {
    p[0] = -p[0];
  }
  for (auto& triangle : surface.triangles) {
    std::swap(triangle[0], triangle[1]);
  }
  return surface;
}

TEST(SurfaceDistances, AShiftedPlaneIsTheShiftAwayEverywhere) {
  const SurfaceDistance d = surface_distance(square(8, 0.1, 0.004), square(5, 0.1, 0.0));
  for (const double value : {d.mean, d.p50, d.p90, d.p95, d.max}) {
    EXPECT_NEAR(value, 0.004, 1e-15);
  }
  EXPECT_NEAR(d.deviation, 0.0, 1e-15);
  EXPECT_EQ(d.samples, 81u);
}

TEST(SurfaceDistances, ATiltedPlaneHasTheMomentsAndPercentilesOfAUniformDistance) {
  TriMesh tilted = square(200, 1.0, 0.0);
  for (Vec3& p : tilted.points) {
    p[2] = 0.01 * p[0];  // so flat that its area is even and its distance is the height
  }
  const SurfaceDistance d = surface_distance(tilted, square(1, 1.0, 0.0));
  const double step = 0.01 / 200;  // of the distance from one row of vertices to the next
  EXPECT_NEAR(d.mean, 0.005, 1e-12);
  EXPECT_NEAR(d.deviation, 0.01 / std::sqrt(12.0), 1e-6);
  EXPECT_NEAR(d.p50, 0.005, step);
  EXPECT_NEAR(d.p90, 0.009, step);
  EXPECT_NEAR(d.p95, 0.0095, step);
  EXPECT_NEAR(d.max, 0.01, 1e-15);
}

TEST(SurfaceDistances, ConcentricSpheresAreTheirRadiiApart) {
  const int rings = 60;
  const SurfaceDistance d = surface_distance(sphere(rings, 0.07), sphere(rings, 0.06));
  const double sag = 0.06 * (1 - std::cos(std::numbers::pi / rings));  // chords lie inside
  EXPECT_NEAR(d.mean, 0.01, sag);
  EXPECT_NEAR(d.max, 0.01, sag);
  EXPECT_LT(d.deviation, sag);
}

TEST(SurfaceDistances, MirroringThePatientChangesNothing) {
  const TriMesh a = sphere(12, 0.06, {0.08, 0.01, 0.0});
  const TriMesh b = sphere(14, 0.055, {0.083, 0.0, 0.002});
  const SurfaceDistance here = surface_distance(a, b);
  const SurfaceDistance there = surface_distance(mirrored(a), mirrored(b));
  EXPECT_NEAR(here.mean, there.mean, 1e-15);
  EXPECT_NEAR(here.p95, there.p95, 1e-15);
  EXPECT_NEAR(here.max, there.max, 1e-15);
}

TEST(SurfaceDistances, FinerTrianglesOnOneHalfDoNotMoveTheMean) {
  TriMesh uneven = square(4, 1.0, 0.0);  // x in 0..1, refined twice as much for x in 1..2
  const TriMesh fine = square(8, 1.0, 0.0);
  const int offset = static_cast<int>(uneven.points.size());
  for (const Vec3& p : fine.points) {
    uneven.points.push_back(p + Vec3{1, 0, 0});
  }
  for (const auto& [a, b, c] : fine.triangles) {
    uneven.triangles.push_back({a + offset, b + offset, c + offset});
  }
  for (Vec3& p : uneven.points) {
    p[2] = 1e-3 * p[0];
  }
  TriMesh flat = square(1, 2.0, 0.0);
  EXPECT_NEAR(surface_distance(uneven, flat).mean, 1e-3, 1e-9);
}

TEST(TissueVolumesOfASide, AddUpAndKnowLeftFromRight) {
  TetMesh mesh = cube(4, 0.1);  // 1000 cm3, x in 0..0.1
  check_and_orient(mesh, "cube");
  std::vector<double> glandular;
  std::vector<signed char> side;
  std::vector<bool> breast;
  for (const auto& cell : mesh.cells) {
    Vec3 centre{0, 0, 0};
    for (const int v : cell) {
      centre += 0.25 * mesh.points[static_cast<std::size_t>(v)];
    }
    side.push_back(centre[0] > 0.025 ? 1 : -1);  // left has three quarters
    breast.push_back(centre[1] < 0.05);          // half of each
    glandular.push_back(0.2);
  }
  const auto [right, left] = tissue_volumes(mesh, mesh.points, glandular, side, breast);
  EXPECT_NEAR(left.model_cm3, 750, 1e-9);
  EXPECT_NEAR(right.model_cm3, 250, 1e-9);
  EXPECT_NEAR(left.breast_cm3, 375, 1e-9);
  EXPECT_NEAR(left.fibroglandular_cm3, 75, 1e-9);
  EXPECT_NEAR(right.adipose_cm3, 100, 1e-9);
}

TEST(SkinDisplacements, AreOfTheChosenSkinOnly) {
  TetMesh mesh = cube(4, 0.1);
  mesh.boundary_names = {"skin"};
  check_and_orient(mesh, "cube");
  std::vector<Vec3> after = mesh.points;
  std::vector<bool> chosen(mesh.points.size());
  for (std::size_t v = 0; v < after.size(); ++v) {
    after[v][2] -= 0.1 * mesh.points[v][0];  // 0..10 mm, and as much below the skin
    chosen[v] = mesh.points[v][0] < 0.08;    // leaves out the last row
  }
  const SkinDisplacement all =
      skin_displacement(mesh, mesh.points, after, std::vector<bool>(after.size(), true));
  EXPECT_NEAR(all.max_mm, 10.0, 1e-12);
  EXPECT_NEAR(all.mean_mm, 5.0, 1e-12);
  const SkinDisplacement some = skin_displacement(mesh, mesh.points, after, chosen);
  EXPECT_NEAR(some.max_mm, 7.5, 1e-12);
  EXPECT_NEAR(mesh.points[static_cast<std::size_t>(some.max_vertex)][0], 0.075, 1e-12);
  EXPECT_NEAR(mesh.points[static_cast<std::size_t>(some.max_vertex)][2], 0.1, 1e-12);
  EXPECT_THROW(skin_displacement(mesh, mesh.points, after, std::vector<bool>(after.size(), false)),
               Error);
}

}  // namespace
}  // namespace sanatrix::outcome
