// Cosmetic indices: nothing for a symmetric torso, nothing for a moved one, the depth of a dent.
#include "outcome/metrics.hpp"

#include <algorithm>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "geometry/rigid.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

/// A half trunk (x >= 0) and its exact mirror image; breasts are bumps of the height field.
Torso symmetric_torso() {
  constexpr int columns = 50, rows = 60;
  Torso torso;
  std::map<std::array<int, 3>, int> number;  // of (side, i, j); both halves share the seam
  for (const int side : {1, -1}) {
    for (int j = 0; j <= rows; ++j) {
      for (int i = 0; i <= columns; ++i) {
        if (i == 0 && side < 0) {
          number[{side, i, j}] = number.at({1, i, j});
          continue;
        }
        number[{side, i, j}] = static_cast<int>(torso.skin.points.size());
        const double angle = 0.45 * std::numbers::pi * i / columns;
        const double z = 0.24 * (j / static_cast<double>(rows) - 0.5);
        Vec3 p{0.16 * std::sin(angle), -0.11 * std::cos(angle), z};
        const double dx = (p[0] - 0.075) / 0.055, dz = (z + 0.01) / 0.055;
        p[1] -= 0.05 * std::exp(-dx * dx - dz * dz);
        p[1] += 0.06 * std::pow(std::max(z, 0.0) / 0.12, 2);
        torso.breast.push_back(dx * dx + dz * dz < 1.2 ? static_cast<signed char>(side) : 0);
        torso.skin.points.push_back({side * p[0], p[1], p[2]});
      }
    }
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const int a = number.at({side, i, j}), b = number.at({side, i + 1, j});
        const int c = number.at({side, i, j + 1}), d = number.at({side, i + 1, j + 1});
        if (side > 0) {
          torso.skin.triangles.push_back({a, b, d});
          torso.skin.triangles.push_back({a, d, c});
        } else {
          torso.skin.triangles.push_back({a, d, b});
          torso.skin.triangles.push_back({a, c, d});
        }
      }
    }
  }
  torso.notch = {0, -0.05, 0.12};
  torso.nipple = {Vec3{-0.08, -0.145, -0.01}, Vec3{0.08, -0.145, -0.01}};
  torso.fold = {Vec3{-0.08, -0.11, -0.07}, Vec3{0.08, -0.11, -0.07}};
  torso.volume_m3 = {6e-4, 6e-4};
  torso.upper_share = {0.5, 0.5};
  return torso;
}

Torso moved(Torso torso, const Rigid& pose) {
  torso.skin = sanatrix::moved(std::move(torso.skin), pose);
  torso.up = pose.rotation * torso.up;
  torso.notch = pose(torso.notch);
  for (auto* pair : {&torso.nipple, &torso.fold}) {
    for (Vec3& p : *pair) {
      p = pose(p);
    }
  }
  return torso;
}

/// Left breast changed: nipple up and in, a dent.
Torso operated(Torso torso, double depth) {
  const std::vector<Vec3> normals = vertex_normals(torso.skin);
  const Vec3 middle = *std::ranges::min_element(torso.skin.points, {}, [](const Vec3& p) {
    return norm(p - Vec3{0.09, -0.136, 0.0});
  });
  for (std::size_t v = 0; v < torso.skin.points.size(); ++v) {
    const double r = norm(torso.skin.points[v] - middle) / 0.02;
    torso.skin.points[v] += -depth * std::exp(-r * r) * normals[v];
  }
  torso.nipple[1] += Vec3{-0.003, 0.002, 0.006};
  torso.volume_m3[1] -= 5e-5;
  return torso;
}

const std::vector<std::string> perfect_at_one{"m1", "m2", "m3", "m4", "m5", "m6"};

TEST(CosmeticMetrics, AMirrorSymmetricTorsoHasNoAsymmetry) {
  const Torso torso = symmetric_torso();
  for (const std::size_t treated : {0U, 1U}) {
    for (const auto& [key, value] :
         shape_indices(torso, body_frame(torso, {1, 0.05, 0}), treated)) {
      if (std::ranges::find(perfect_at_one, key) != perfect_at_one.end()) {
        EXPECT_NEAR(value, 1.0, 1e-9) << key;
      } else if (key == "volume_symmetry_pct") {
        EXPECT_NEAR(value, 100.0, 1e-9) << key;
      } else if (!key.starts_with("nipple_above") && !key.starts_with("nipple_fold") &&
                 !key.starts_with("notch_nipple_treated") &&
                 !key.starts_with("notch_nipple_other") && key != "nipple_nipple_mm" &&
                 key != "volume_treated_cm3" && key != "upper_pole_pct") {
        EXPECT_NEAR(value, 0.0, 1e-6) << key;  // 1e-9 m in mm; the plane is found by iteration
      }
    }
  }
}

TEST(CosmeticMetrics, ATapeFollowsTheSkin) {
  const Torso torso = symmetric_torso();
  const auto values = shape_indices(torso, body_frame(torso, {1, 0, 0}), 1);
  for (const std::string key : {"notch_nipple", "nipple_fold"}) {
    const double straight = values.at(key + "_treated_mm");
    const double along = values.at(key + "_treated_skin_mm");
    EXPECT_GT(along, straight) << key;  // a breast of 5 cm is not flat
    EXPECT_LT(along, 1.5 * straight) << key;
    EXPECT_NEAR(along, values.at(key + "_other_skin_mm"), 1e-3) << key;  // a micrometre
  }
}

TEST(CosmeticMetrics, ATapeHasNoSkinToANotchAboveTheModel) {
  Torso torso = symmetric_torso();
  torso.notch[2] += 0.05;
  const auto values = shape_indices(torso, body_frame(torso, {1, 0, 0}), 1);
  EXPECT_TRUE(values.contains("notch_nipple_treated_mm"));
  EXPECT_FALSE(values.contains("notch_nipple_treated_skin_mm"));
  EXPECT_TRUE(values.contains("nipple_fold_treated_skin_mm"));
}

TEST(CosmeticMetrics, ARigidMoveChangesNothing) {
  const Torso torso = operated(symmetric_torso(), 0.006);
  const double c = std::cos(0.7), s = std::sin(0.7);
  const Rigid pose{
      Mat3{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}} * Mat3{{{1, 0, 0}, {0, c, -s}, {0, s, c}}},
      {0.3, -1.2, 0.8}};
  const auto here = shape_indices(torso, body_frame(torso, {1, 0, 0}), 1);
  const Torso there = moved(torso, pose);
  for (const auto& [key, value] :
       shape_indices(there, body_frame(there, pose.rotation * Vec3{1, 0, 0}), 1)) {
    EXPECT_NEAR(value, here.at(key), 1e-5 * std::max(1.0, std::abs(value))) << key;
  }
}

TEST(CosmeticMetrics, MirroringThePatientSwapsTheSidesOnly) {
  const Torso torso = operated(symmetric_torso(), 0.006);
  Torso mirrored = torso;
  for (Vec3& p : mirrored.skin.points) {
    p[0] = -p[0];
  }
  for (auto& t : mirrored.skin.triangles) {
    std::swap(t[1], t[2]);
  }
  for (signed char& side : mirrored.breast) {
    side = static_cast<signed char>(-side);
  }
  for (auto* pair : {&mirrored.nipple, &mirrored.fold}) {
    std::swap((*pair)[0], (*pair)[1]);
    for (Vec3& p : *pair) {
      p[0] = -p[0];
    }
  }
  std::swap(mirrored.volume_m3[0], mirrored.volume_m3[1]);
  const auto one = shape_indices(torso, body_frame(torso, {1, 0, 0}), 1);
  for (const auto& [key, value] : shape_indices(mirrored, body_frame(mirrored, {1, 0, 0}), 0)) {
    // Ways along the skin agree to a micrometre: the triangles around a mark are taken in order.
    const double tolerance =
        key.ends_with("_skin_mm") ? 1e-3 : 1e-6 * std::max(1.0, std::abs(value));
    EXPECT_NEAR(value, one.at(key), tolerance) << key;
  }
}

TEST(CosmeticMetrics, KnownChangesComeBackWithTheirSigns) {
  Question q;
  q.before = symmetric_torso();
  q.after = operated(q.before, 0.008);
  q.excised_percent = 7;
  const BodyFrame frame = body_frame(q.before, {1, 0, 0});
  std::map<std::string, Metric> metrics;
  for (const Metric& m : cosmetic_metrics(q, frame)) {
    metrics[m.key] = m;
    EXPECT_FALSE(m.name.empty() || m.source.empty()) << m.key;
  }
  EXPECT_NEAR(*metrics.at("retraction_mm").change, 8.0, 0.3);  // a mean over 3 mm
  EXPECT_NEAR(*metrics.at("unr_mm").after, 6.0, 0.01);
  EXPECT_NEAR(*metrics.at("bra_mm").after, std::hypot(3.0, 6.0), 0.01);
  EXPECT_NEAR(*metrics.at("nipple_up_mm").change, 6.0, 1e-6);
  EXPECT_NEAR(*metrics.at("nipple_lateral_mm").change, -3.0, 1e-6);
  EXPECT_NEAR(*metrics.at("nipple_forward_mm").change, -2.0, 1e-6);
  EXPECT_NEAR(*metrics.at("volume_treated_cm3").change, -50.0, 1e-9);
  EXPECT_TRUE(metrics.at("volume_treated_cm3").is_noise);  // 56 cm3 can be told apart
  EXPECT_FALSE(metrics.at("unr_mm").is_noise);
  EXPECT_NEAR(*metrics.at("excised_pct").change, 7.0, 0);
  // Two nipples 2.5 mm off in two directions each.
  EXPECT_NEAR(metrics.at("unr_mm").after_range->sd, 2.5 * std::sqrt(2.0), 0.5);
  EXPECT_LT(chance_of_bra_above(q, frame, 26), 0.01);
  EXPECT_GT(chance_of_bra_above(q, frame, 1), 0.95);
}

TEST(CosmeticMetrics, LandmarksSevenMillimetresOffHardlyMoveThe3dIndex) {
  Torso torso = operated(symmetric_torso(), 0.006);
  const BodyFrame frame = body_frame(torso, {1, 0, 0});
  const double exact = shape_indices(torso, frame, 1).at("pbra3d_pct");
  torso.nipple[1] += Vec3{0.004, 0.004, 0.004};
  const double off = shape_indices(torso, frame, 1).at("pbra3d_pct");
  // The index is a length over the notch-nipple distance of 190 mm: at most 7 mm of it.
  EXPECT_LE(std::abs(off - exact), 100 * 7.0 / 180);
}

TEST(CosmeticMetrics, PtosisFollowsRegnault) {
  EXPECT_EQ(ptosis_grade(30, 30), "none");
  EXPECT_EQ(ptosis_grade(5, 40), "pseudoptosis");
  EXPECT_EQ(ptosis_grade(-5, 40), "I");
  EXPECT_EQ(ptosis_grade(-20, 40), "II");
  EXPECT_EQ(ptosis_grade(-40, 40), "III");
  EXPECT_EQ(ptosis_grade(-20, 5), "III");
}

}  // namespace
}  // namespace sanatrix::outcome
