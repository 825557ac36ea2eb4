// Closest points and point location against brute force, with a limit on their time.
#include "geometry/distance.hpp"

#include <chrono>
#include <random>

#include <gtest/gtest.h>

#include "simple_meshes.hpp"

namespace sanatrix {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TEST(SurfaceTree, DistanceToASphereIsTheRadialOne) {
  const int rings = 60;
  const SurfaceTree tree(testing::sphere(rings, 1.0));
  // The chords of the triangles lie at most this far inside the sphere.
  const double sag = 1 - std::cos(std::numbers::pi / rings);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{normal(random), normal(random), normal(random)};
    const auto hit = tree.closest(p);
    EXPECT_NEAR(hit.distance, std::abs(norm(p) - 1.0), sag);
    EXPECT_NEAR(norm(hit.point - p), hit.distance, 1e-14);
    EXPECT_GE(hit.triangle, 0);
  }
}

TEST(SurfaceTree, FindsFacesEdgesAndCornersOfASquare) {
  const SurfaceTree tree(testing::square(7, 1.0, 0.0));
  EXPECT_NEAR(tree.closest({0.3, 0.6, 0.2}).distance, 0.2, 1e-15);
  EXPECT_NEAR(tree.closest({1.3, 0.6, 0.4}).distance, 0.5, 1e-15);
  EXPECT_NEAR(tree.closest({-1, -2, 2}).distance, 3.0, 1e-15);
}

TEST(TetLocator, EveryPointOfACubeIsInOneCellWithItsCoordinates) {
  const TetMesh mesh = testing::cube(20);
  const TetLocator locator(mesh, mesh.points);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  int found = 0;
  const auto start = std::chrono::steady_clock::now();
  const int count = 200000;
  for (int i = 0; i < count; ++i) {
    const Vec3 p{uniform(random), uniform(random), uniform(random)};
    const bool inside =
        *std::min_element(p.begin(), p.end()) >= 0 && *std::max_element(p.begin(), p.end()) <= 1;
    const auto place = locator.locate(p);
    ASSERT_EQ(place.has_value(), inside);
    if (place) {
      ++found;
      Vec3 q{0, 0, 0};
      for (std::size_t k = 0; k < 4; ++k) {
        const int v = mesh.cells[static_cast<std::size_t>(place->cell)][k];
        q += place->barycentric[k] * mesh.points[static_cast<std::size_t>(v)];
      }
      ASSERT_NEAR(norm(p - q), 0.0, 1e-13);
    }
  }
  // A label image of a million voxels must take seconds; ten times that for a busy machine.
  EXPECT_LT(seconds_since(start), 10.0);
  EXPECT_GT(found, count / 2);
}

TEST(TetLocator, NearestOfAPointJustOutsideIsTheCellBelowIt) {
  const TetMesh mesh = testing::cube(5);
  const TetLocator locator(mesh, mesh.points);
  const Vec3 above{0.47, 0.31, 1.0 + 1e-6};
  EXPECT_FALSE(locator.locate(above));
  const auto below = locator.locate({0.47, 0.31, 1.0 - 1e-6});
  ASSERT_TRUE(below);
  const auto place = locator.nearest(above);
  EXPECT_EQ(place.cell, below->cell);
  EXPECT_LT(*std::min_element(place.barycentric.begin(), place.barycentric.end()), 0.0);
  for (const Vec3& corner : mesh.points) {  // vertices are shared by many cells and must be found
    EXPECT_GE(locator.nearest(corner).cell, 0);
  }
}

}  // namespace
}  // namespace sanatrix
