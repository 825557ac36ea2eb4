// A ball and a height field with known noise: it is measured, taken off, and nothing else.
#include "geometry/surface_noise.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sanatrix {
namespace {

/// A round hill of 60 mm radius and 40 mm height on a plain, seen every `edge_m`.
double height(double x, double y) {
  return 0.04 * std::exp(-0.5 * (x * x + y * y) / (0.04 * 0.04));
}

TriMesh hill(double edge_m, double noise_m) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  TriMesh mesh;
  const int half = static_cast<int>(0.12 / edge_m), n = 2 * half + 1;
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < n; ++i) {
      const double x = edge_m * (i - half), y = edge_m * (k - half);
      const Vec3 off{noise(random), noise(random), noise(random)};
      mesh.points.push_back(Vec3{x, y, height(x, y)} + noise_m * off);
      if (const int a = k * n + i; i + 1 < n && k + 1 < n) {
        mesh.triangles.push_back({a, a + 1, a + n});
        mesh.triangles.push_back({a + 1, a + n + 1, a + n});
      }
    }
  }
  return mesh;
}

TEST(SurfaceNoise, IsMeasuredWhateverTheEdges) {
  for (const double edge_m : {0.002, 0.004}) {
    for (const double noise_m : {0.0005, 0.001, 0.002}) {
      // Some 10,000 points: the median is within 1 %; rough normals and the hill do the rest.
      EXPECT_NEAR(noise_of(hill(edge_m, noise_m)), noise_m, 0.1 * noise_m);
    }
  }
}

TEST(SurfaceNoise, SmoothSurfacesAreLeftAlone) {
  // Coarse ones, too, whose bends between triangles are their shape.
  for (const double edge_m : {0.001, 0.003, 0.01, 0.02}) {
    const TriMesh mesh = hill(edge_m, 0.0);
    EXPECT_EQ(rounds_for(mesh, noise_of(mesh)), 0) << edge_m;
  }
}

TEST(SurfaceNoise, IsTakenOffAndTheShapeStays) {
  for (const double noise_m : {0.001, 0.002}) {
    TriMesh mesh = hill(0.002, noise_m);
    mesh = smoothed(std::move(mesh), rounds_for(mesh, noise_of(mesh)));
    double sum = 0, squares = 0, count = 0;
    for (const Vec3& p : mesh.points) {
      if (std::hypot(p[0], p[1]) < 0.1) {  // borders have fewer neighbours to learn from
        const double off = p[2] - height(p[0], p[1]);
        sum += off;
        squares += off * off;
        count += 1;
      }
    }
    // What the filter's formula says is left is 1.2 times harmless_noise_m; tangential noise makes
    // the grid uneven, which costs as much again.
    EXPECT_LT(std::sqrt(squares / count), 2.4 * harmless_noise_m) << noise_m;
    EXPECT_LT(std::abs(sum / count), 0.2 * harmless_noise_m) << noise_m;  // volume stays
  }
}

}  // namespace
}  // namespace sanatrix
