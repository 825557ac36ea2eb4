// Measures and checks of meshes against closed forms.
#include <cmath>
#include <numbers>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "geometry/geodesic.hpp"
#include "geometry/tri_mesh.hpp"
#include "simple_meshes.hpp"

namespace sanatrix {
namespace {

using ::testing::HasSubstr;

TEST(TetMeshMeasures, CubeHasItsVolumeBoundaryAndAngles) {
  TetMesh mesh = testing::cube(4, 0.1);
  check_and_orient(mesh, "cube");
  const std::vector<double> volumes = cell_volumes(mesh, mesh.points);
  EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), 1e-3, 1e-15);
  EXPECT_EQ(boundary_of(mesh).size(), 6u * 16u * 2u);
  for (const double angle : min_dihedral_angles(mesh, mesh.points)) {
    EXPECT_NEAR(angle, 45.0, 1e-9);  // of Kuhn's tetrahedron
  }
  EXPECT_EQ(vertices_on(mesh, "top").size(), 25u);
  EXPECT_TRUE(vertices_on(mesh, "bottom").empty());
}

TEST(TetMeshMeasures, BoundaryIsClosedAndOutward) {
  TetMesh mesh = testing::cube(3);
  check_and_orient(mesh, "cube");
  Vec3 sum{0, 0, 0};
  double volume6 = 0;  // divergence theorem
  for (const auto& [a, b, c] : boundary_of(mesh)) {
    const auto at = [&](int v) {
      return mesh.points[static_cast<std::size_t>(v)];
    };
    sum += cross(at(b) - at(a), at(c) - at(a));
    volume6 += dot(at(a), cross(at(b), at(c)));
  }
  EXPECT_NEAR(norm(sum), 0.0, 1e-14);
  EXPECT_NEAR(volume6 / 6, 1.0, 1e-14);
}

TEST(TetMeshCheck, TurnsInvertedCellsAndInwardFaces) {
  TetMesh mesh = testing::cube(2);
  for (auto& cell : mesh.cells) {
    std::swap(cell[0], cell[1]);
  }
  for (auto& face : mesh.faces) {
    std::swap(face.vertex[0], face.vertex[1]);
  }
  check_and_orient(mesh, "cube");
  EXPECT_THAT(cell_volumes(mesh, mesh.points), ::testing::Each(::testing::Gt(0.0)));
  const Surface top = extract_surface(mesh, mesh.points, {"top"});
  EXPECT_NEAR(surface_area(top.mesh), 1.0, 1e-14);
  for (const Vec3& normal : vertex_normals(top.mesh)) {
    EXPECT_NEAR(normal[2], 1.0, 1e-14);
  }
  EXPECT_EQ(top.vertex, vertices_on(mesh, "top"));
}

TEST(TetMeshCheck, RefusesWhatCannotBeComputedOn) {
  const auto message = [](auto&& spoil) {
    TetMesh mesh = testing::cube(1);
    spoil(mesh);
    try {
      check_and_orient(mesh, "case/mesh.msh");
    } catch (const Error& e) {
      return e.one_line();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](TetMesh&) {}), "accepted");
  EXPECT_THAT(message([](TetMesh& m) { m.cells[2][1] = m.cells[2][0]; }),
              HasSubstr("case/mesh.msh: tetrahedron 2 is flat"));
  EXPECT_THAT(message([](TetMesh& m) { m.cells[0][3] = 99; }), HasSubstr("out of range"));
  EXPECT_THAT(message([](TetMesh& m) { m.points[4][0] = std::nan(""); }), HasSubstr("vertex 4"));
  EXPECT_THAT(message([](TetMesh& m) { m.points.push_back({0, 0, 0}); }), HasSubstr("vertex 8"));
  EXPECT_THAT(message([](TetMesh& m) { m.region[1] = 1; }), HasSubstr("region number 1"));
  EXPECT_THAT(message([](TetMesh& m) { m.faces[0].vertex = {0, 1, 6}; }), HasSubstr("not a face"));
}

TEST(SurfaceExtraction, AnUnknownBoundaryIsNamedTogetherWithTheKnown) {
  const TetMesh mesh = testing::cube(1);
  try {
    extract_surface(mesh, mesh.points, {"skin"});
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("named skin; it has top"));
  }
}

TEST(LengthsAlongASurface, FollowTheCylinderAndEndWithThePiece) {
  // A half cylinder of 0.1 m radius in flat strips 0.2 m high; exact: the helix between two places.
  TriMesh half;
  constexpr int strips = 180;
  for (int i = 0; i <= strips; ++i) {
    const double angle = std::numbers::pi * i / strips;
    for (const double z : {0.0, 0.2}) {
      half.points.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle), z});
    }
  }
  for (int i = 0; i < strips; ++i) {
    half.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    half.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  const auto island = static_cast<int>(half.points.size());
  for (const Vec3& p : {Vec3{1, 0, 0}, Vec3{1.1, 0, 0}, Vec3{1, 0.1, 0}}) {
    half.points.push_back(p);
  }
  half.triangles.push_back({island, island + 1, island + 2});
  const std::vector<double> lengths = lengths_along(
      half, {0.1, 0, 0.03}, std::vector<Vec3>{{-0.1, 0, 0.15}, {0.1, 0, 0.13}, {1, 0, 0}});
  EXPECT_NEAR(lengths[0], std::hypot(std::numbers::pi * 0.1, 0.12), 1e-5);  // chords of 1 degree
  EXPECT_NEAR(lengths[1], 0.1, 1e-7);  // places are kept off edges by that much
  EXPECT_TRUE(std::isnan(lengths[2]));
}

}  // namespace
}  // namespace sanatrix
