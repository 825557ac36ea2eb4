// A scan is found in any pose, bent onto the model, and compared with it.
#include "outcome/alignment.hpp"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "outcome/scan_comparison.hpp"
#include "outcome/warp.hpp"

namespace sanatrix::outcome {
namespace {

/// The front of a trunk as a grid over (angle, height): an elliptic cylinder with two breasts of
/// different size, a dent at the left one. `droop` moves the breasts down.
TriMesh trunk(double dent_m = 0.0, double droop = 0.0, int columns = 120, int rows = 90) {
  TriMesh surface;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double angle = std::numbers::pi * (i / static_cast<double>(columns) - 0.5) * 0.9;
      const double z = 0.24 * (j / static_cast<double>(rows) - 0.5);
      Vec3 p{0.16 * std::sin(angle), -0.11 * std::cos(angle), z};
      p[0] *= 1 + 1.5 * z;                                  // wider at the shoulders
      p[1] += 0.06 * std::pow(std::max(z, 0.0) / 0.12, 2);  // falls back towards the neck
      for (const double side : {-1.0, 1.0}) {
        const double size = side > 0 ? 0.055 : 0.048;
        const double dx = (p[0] - side * 0.075) / 0.055;
        const double dz = (p[2] + 0.015 + droop) / 0.055;
        const double r2 = dx * dx + dz * dz;
        p[1] -= size * std::exp(-r2);
      }
      surface.points.push_back(p);
    }
  }
  const int width = columns + 1;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = j * width + i, b = a + 1, c = a + width, d = c + 1;
      surface.triangles.push_back({a, b, d});
      surface.triangles.push_back({a, d, c});
    }
  }
  const std::vector<Vec3> normals = vertex_normals(surface);
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    const double r = norm(surface.points[v] - Vec3{0.085, -0.145, -0.01}) / 0.02;
    surface.points[v] += -dent_m * std::exp(-r * r) * normals[v];
  }
  return surface;
}

Rigid random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vec3 a = normalised({normal(random), normal(random), normal(random)});
  const double angle = std::numbers::pi * std::uniform_real_distribution<>(0, 1)(random);
  const double c = std::cos(angle), s = std::sin(angle);
  Rigid pose;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      pose.rotation[i][j] = (i == j ? c : 0.0) + (1 - c) * a[i] * a[j];
    }
  }
  pose.rotation[0][1] -= s * a[2];
  pose.rotation[0][2] += s * a[1];
  pose.rotation[1][0] += s * a[2];
  pose.rotation[1][2] -= s * a[0];
  pose.rotation[2][0] -= s * a[1];
  pose.rotation[2][1] += s * a[0];
  pose.shift = {normal(random), normal(random), normal(random)};
  return pose;
}

StandingSkin standing(const TriMesh& surface) {
  return {surface, std::vector<double>(surface.points.size(), 1.0), {}};
}

TEST(Alignment, AnyPoseOfTheWholeSpaceIsFound) {
  const TriMesh patient = trunk(0, 0, 60, 45);
  std::mt19937 random(7);
  for (int trial = 0; trial < 4; ++trial) {
    const Rigid pose = random_pose(random);
    const Alignment found = align(standing(patient), moved(trunk(), pose));
    const Rigid left = found.to_patient * pose;  // the identity when all is well
    for (const Vec3& p : {Vec3{0.1, 0, 0.1}, Vec3{-0.1, -0.1, 0}, Vec3{0, 0, -0.1}}) {
      EXPECT_LT(norm(left(p) - p), 2e-4);  // facets of 5 mm sag by that much
    }
    EXPECT_GT(found.overlap, 0.85);
  }
}

TEST(Alignment, BreastsThatSagLessThanThoughtDoNotPullTheScanAlong) {
  StandingSkin patient = standing(trunk(0, 0.01));
  const TriMesh real = trunk();
  patient.modes.emplace_back();
  for (std::size_t v = 0; v < real.points.size(); ++v) {
    patient.modes[0].push_back(patient.surface.points[v] - real.points[v]);
    const double moved = norm(patient.modes[0].back()) / 0.005;
    patient.trust[v] = 1 / (1 + moved * moved);
  }
  const Rigid left = align(patient, real).to_patient;
  EXPECT_LT(norm(left(Vec3{0, -0.1, 0}) - Vec3{0, -0.1, 0}), 1e-3);
}

TEST(Alignment, SomethingElseIsRefusedWithNumbers) {
  TriMesh ball;  // a sphere's front is no trunk
  for (const TriMesh whole = trunk(); const Vec3& p : whole.points) {
    ball.points.push_back(0.15 * normalised(p + Vec3{0, -0.02, 0}));
  }
  ball.triangles = trunk().triangles;
  EXPECT_THROW(align(standing(trunk(0, 0, 60, 45)), ball), Error);
}

TEST(Alignment, LandmarksGiveTheirRigidMotion) {
  std::mt19937 random(3);
  const Rigid pose = random_pose(random);
  const std::vector<Vec3> patient{{0.1, 0, 0}, {-0.1, 0.02, 0}, {0, -0.05, 0.2}};
  std::vector<Vec3> scan;
  for (const Vec3& p : patient) {
    scan.push_back(pose(p));
  }
  const Rigid found = match_landmarks(scan, patient);
  EXPECT_LT(norm(found(scan[2]) - patient[2]), 1e-12);
  EXPECT_THROW(match_landmarks(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}},
                               std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
               Error);
}

TEST(Comparison, AnUnmovedPatientHasNoDistanceAndADentItsDepth) {
  const TriMesh before = trunk();
  const std::vector<bool> all(before.points.size(), true);
  std::vector<double> inward = signed_distances(before, before);
  EXPECT_LT(distance_statistics(before, inward, all).max, 1e-9);

  const double depth = 0.009;
  inward = signed_distances(before, trunk(depth));
  for (double& d : inward) {
    d = -d;
  }
  const Retraction dent = retraction(before, inward, all);
  EXPECT_NEAR(dent.depth_m, depth, 0.0005);  // its middle lies between vertices 2.5 mm apart
  EXPECT_GT(dent.area_3mm_m2, dent.area_5mm_m2);
  EXPECT_GT(dent.area_5mm_m2, 1e-4);
}

TEST(Warp, BendsTheSkinOntoTheScanAndCarriesDisplacements) {
  const TriMesh skin = trunk(0, 0.004, 60, 45), scan = trunk();
  const Warp warp = warp_onto(skin, scan);
  EXPECT_LT(warp.median_m, 2e-4);
  const std::vector<Vec3> moved(skin.points.size(), Vec3{0, 0.005, -0.002});
  for (const Vec3& u : carry_to_scan(warp, moved, scan)) {
    EXPECT_NEAR(u[1], 0.005, 1e-4);
    EXPECT_NEAR(u[2], -0.002, 1e-4);
  }
}

TEST(Warp, CarriesThePhotographToTheSamePlaces) {
  TexturedSurface scan{trunk(), {}, {256, 256, {}}, {}};
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      for (const int value : {x, y, 100}) {
        scan.photograph.rgb.push_back(static_cast<unsigned char>(value));
      }
    }
  }
  const auto corner = [](const Vec3& p) {
    return TextureCorner{static_cast<float>(0.5 + 2.5 * p[0]), static_cast<float>(0.5 + 3 * p[2])};
  };
  for (const auto& t : scan.mesh.triangles) {
    std::array<TextureCorner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = corner(scan.mesh.points[static_cast<std::size_t>(t[k])]);
    }
    scan.corners.push_back(corners);
  }
  const TriMesh skin = trunk(0, 0, 40, 30);
  const TexturedSurface carried = carry_texture(warp_onto(skin, scan.mesh), scan, skin);
  for (std::size_t t = 1000; t < 1400; ++t) {
    Vec3 middle{};
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      middle += (1.0 / 3) * skin.points[static_cast<std::size_t>(skin.triangles[t][k])];
      u += carried.corners[t][k][0] / 3.0;
      v += carried.corners[t][k][1] / 3.0;
    }
    const auto seen = carried.photograph.at(u, v);
    const auto wanted = scan.photograph.at(corner(middle)[0], corner(middle)[1]);
    EXPECT_NEAR(seen[0], wanted[0], 3);  // levels of 255: a millimetre is 0.6
    EXPECT_NEAR(seen[1], wanted[1], 3);
  }
}

}  // namespace
}  // namespace sanatrix::outcome
