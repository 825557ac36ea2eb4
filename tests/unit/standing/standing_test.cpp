// A trunk of formulas, scanned in any pose: the frame, the closed body and the wall are known.
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"
#include "standing/scan_frame.hpp"
#include "standing/skin_check.hpp"
#include "standing/standing_body.hpp"
#include "standing_trunk.hpp"

namespace sanatrix::standing {
namespace {

using testing::plain;
using testing::some_pose;
using testing::Trunk;

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::min(1.0, dot(a, b))) * 180 / std::numbers::pi;
}

TEST(ScanFrame, IsFoundInAnyPose) {
  for (const double turn : {0.0, 0.9, 2.4, 4.0}) {
    const Rigid pose = some_pose(turn);
    const ScanFrame frame = find_frame(plain(moved(Trunk{}.scan(), pose)), {});
    const Mat3 left_over = frame.to_patient.rotation * pose.rotation;
    // The trunk is straight and symmetric: only the scan's 4 mm columns blur its axes.
    for (std::size_t a = 0; a < 3; ++a) {
      const Vec3 axis{left_over[0][a], left_over[1][a], left_over[2][a]};
      Vec3 wanted{};
      wanted[a] = 1;
      EXPECT_LT(degrees_between(axis, wanted), 3.0) << "axis " << a << ", turn " << turn;
    }
    // Without a bump the nipple is the foremost place, between two search columns of 5 mm.
    EXPECT_NEAR(1e3 * norm(frame.nipple[1] - frame.nipple[0]), 2 * 80.0, 12.0);
    EXPECT_GT(frame.nipple[1][0], 0.0);
  }
}

/// Left and up of the frame in the trunk's own axes, in degrees from its own.
std::array<double, 2> degrees_off(const ScanFrame& frame, const Rigid& pose) {
  const Mat3 left_over = frame.to_patient.rotation * pose.rotation;
  return {degrees_between(left_over[0], {1, 0, 0}), degrees_between(left_over[2], {0, 0, 1})};
}

TEST(ScanFrame, IsFoundOnScansThatGoRoundTheTrunk) {
  const Rigid pose = some_pose(0.9);
  const ScanFrame frame = find_frame(plain(moved(Trunk{.back = true}.scan(), pose)), {});
  const auto [left, up] = degrees_off(frame, pose);
  EXPECT_LT(left, 3.0);
  EXPECT_LT(up, 3.0);
}

TEST(ScanFrame, LeftAndMiddleAreThoseOfTheTrunkNotOfTheBreasts) {
  // A smaller breast, an arm on one side, and a trunk that is rolled by 4 degrees in the scanner.
  const double roll = 4 * std::numbers::pi / 180;
  const Rigid pose{
      {{{std::cos(roll), 0, std::sin(roll)}, {0, 1, 0}, {-std::sin(roll), 0, std::cos(roll)}}},
      {0.02, 0.1, 0.3}};
  const ScanFrame frame =
      find_frame(plain(moved(Trunk{.left_share = 0.75, .left_arm = true}.scan(), pose)), {});
  const auto [left, up] = degrees_off(frame, pose);
  EXPECT_LT(left, 1.0);  // the scan's 4 mm columns at 150 mm
  EXPECT_LT(up, 1.0);
  EXPECT_NEAR(1e3 * frame.to_patient(pose({0, 0, 0}))[0], 0.0, 2.0);
}

TEST(ScanFrame, WhatIsSaidToBeUpIsUp) {
  ScanLandmarks marks;
  marks.up = Vec3{0, 0, -1};  // as if the patient stood on her head
  const ScanFrame frame = find_frame(plain(Trunk{}.scan()), marks);
  EXPECT_LT(frame.to_patient.rotation[2][2], -0.99);
  EXPECT_LT(frame.to_patient.rotation[0][0], -0.99);
}

TEST(ScanFrame, ATrunkWithoutBreastsIsRefused) {
  EXPECT_THROW(find_frame(plain(Trunk{.rise_mm = 4.0}.scan()), {}), Error);
}

TEST(ScanFrame, AFarSmallerBreastIsFoundWhereItIs) {
  const ScanFrame frame = find_frame(plain(Trunk{.left_share = 0.5, .left_arm = true}.scan()), {});
  // The flat top of a small breast blurs its nipple by the stated doubt.
  EXPECT_NEAR(1e3 * frame.nipple[1][0], 80.0, frame.nipple_find[1].doubt_mm);
  EXPECT_NEAR(1e3 * frame.nipple[0][0], -80.0, frame.nipple_find[0].doubt_mm);
}

TEST(ScanFrame, SmallBreastsAreFoundAndTheirNipplesDoubted) {
  const ScanFrame frame = find_frame(plain(Trunk{.rise_mm = 24.0}.scan()), {});
  EXPECT_LT(degrees_off(frame, {})[1], 1.0);  // as for large ones
  for (const std::size_t side : {0U, 1U}) {
    EXPECT_GT(frame.nipple_find[side].doubt_mm, 20.0);
    EXPECT_NEAR(1e3 * frame.nipple[side][0], side == 0 ? -85.0 : 85.0,
                frame.nipple_find[side].doubt_mm);
  }
}

TEST(ScanFrame, MarksCountMoreThanWhatLooksLikeBreasts) {
  // The arm and the large breast would be the likelier pair.
  const Trunk trunk{.left_share = 0.25, .left_arm = true};
  ScanLandmarks marks;
  marks.nipple = {1e-3 * Vec3{-80, Trunk::chest(80) - 50, 0},
                  1e-3 * Vec3{80, Trunk::chest(80) - 12, 0}};
  marks.sternal_notch = 1e-3 * Vec3{0, Trunk::chest(0), 140};
  const ScanFrame frame = find_frame(plain(trunk.scan()), marks);
  EXPECT_LT(degrees_off(frame, {})[1], 1.0);  // the scan's 4 mm columns at 150 mm
  for (const std::size_t side : {0U, 1U}) {
    // By more than that the trunk's middle may not differ from that of the marks.
    EXPECT_NEAR(1e3 * frame.nipple[side][0], side == 0 ? -80.0 : 80.0, 25.0);
  }
}

TEST(ScanFrame, ABreastAndWhatStandsForwardElsewhereAreRefused) {
  for (const bool arm : {false, true}) {
    EXPECT_THROW(find_frame(plain(Trunk{.left_share = 0.0, .left_arm = arm}.scan()), {}), Error);
  }
}

StandingBody body_of(const Trunk& trunk, double depth_mm = usual_wall_depth_mm) {
  Silent silent;
  const double y = Trunk::chest(81) - trunk.rise_mm;
  const std::array<Vec3, 2> nipple{1e-3 * Vec3{-81, y, 0}, 1e-3 * Vec3{81, y, 0}};
  return build_body(trunk.scan(), nipple, {.spacing_mm = 2.0, .wall_depth_mm = depth_mm},
                    Context("test", silent));
}

TEST(StandingBody, TheWallLiesBehindTheBreastsOfAKnownTrunk) {
  const Trunk trunk;
  const StandingBody body = body_of(trunk);
  double sum = 0, count = 0;
  for (int k = 0; k < body.wall_y.size[1]; ++k) {
    for (int i = 0; i < body.wall_y.size[0]; ++i) {
      const double x = body.wall_y.origin_mm[0] + i * body.wall_y.spacing_mm;
      if (body.side[body.wall_y.index(i, k)] != 0 && std::abs(x) < 110) {
        // Perpendicular depth, seen along y.
        const double slope = (Trunk::chest(std::abs(x) + 1) - Trunk::chest(std::abs(x))) / 1.0;
        const double wall = Trunk::chest(x) + usual_wall_depth_mm * std::hypot(1.0, slope);
        sum += std::abs(body.wall_y.at(i, k) - wall);
        count += 1;
      }
    }
  }
  ASSERT_GT(count, 200);
  // Gaussian breasts have wide tails beyond the footprint that pull the wall forward: a hard case.
  EXPECT_LT(sum / count, 1.5 * wall_doubt_mm);
  EXPECT_LT(std::abs(body.breast_cm3[0] - body.breast_cm3[1]), 0.05 * body.breast_cm3[0]);
}

TEST(StandingBody, SmallBreastsKeepTheirBaseAndAFlatChestIsRefused) {
  // The footprint may narrow with the height, not more, and must not grow towards the flank.
  constexpr double height = 24.0 / 50.0;
  const double usual = body_of({}).breast_cm3[1], small = body_of({.rise_mm = 24.0}).breast_cm3[1];
  EXPECT_LT(small, height * usual);
  EXPECT_GT(small, height * height * usual);
  EXPECT_THROW(body_of({.rise_mm = 6.0}), Error);
}

TEST(StandingBody, AnArmBesideTheTrunkIsNoBreast) {
  const StandingBody alone = body_of({}), beside = body_of({.left_arm = true});
  for (const std::size_t side : {0U, 1U}) {
    EXPECT_NEAR(beside.breast_cm3[side], alone.breast_cm3[side], 0.02 * alone.breast_cm3[side]);
  }
}

TEST(StandingBody, AnArmThatTheBreastLeadsOverToIsNoBreast) {
  // On the left a rise of its own above the breast; skin between them stands forward, too.
  constexpr double arm_x = 110, arm_z = 75, arm_width = 16, arm_rise = 45, bridge = 7;
  const Trunk trunk;
  meshing::ColumnMap skin_y{
      .size = {101, 81}, .spacing_mm = 4.0, .origin_mm = {-200, -160}, .value = {}};
  for (int k = 0; k < skin_y.size[1]; ++k) {
    for (int i = 0; i < skin_y.size[0]; ++i) {
      const double x = -200 + 4.0 * i, z = -160 + 4.0 * k;
      const double across = (x - arm_x) / arm_width, along = (z - arm_z) / arm_width;
      const double arm = arm_rise * std::exp(-0.5 * (across * across + along * along));
      const bool between = x > 85 && x < 125 && z > 30 && z < arm_z;
      skin_y.value.push_back(100 - std::max(trunk.bump(x, z), arm) - (between ? bridge : 0.0));
    }
  }
  const auto side_at = [&](double x, double z) {
    const meshing::BreastMap breasts =
        meshing::map_breasts(skin_y, skin_y,
                             {.nipple_mm = {{{-85, 50, 0}, {85, 50, 0}}},
                              .ball = meshing::standing_ball,
                              .breast_reach_mm = meshing::standing_reach_mm,
                              .least_saddle = meshing::standing_least_saddle});
    return breasts.side[breasts.base.nearest(x, z)];
  };
  EXPECT_EQ(side_at(85, 0), 1);
  EXPECT_EQ(side_at(arm_x, arm_z), 0);
}

TEST(StandingBody, ADeeperWallMakesLargerBreasts) {
  const StandingBody usual = body_of({}),
                     deep = body_of({}, usual_wall_depth_mm + wall_offset_doubt_mm);
  // The stated doubt of the volume is what the doubt of the wall does.
  const double change = deep.breast_cm3[1] - usual.breast_cm3[1];
  EXPECT_NEAR(change, usual.breast_doubt_cm3[1], 0.35 * usual.breast_doubt_cm3[1]);
}

TEST(StandingBody, SmallHolesAreClosedAndLargeOnesRefused) {
  const StandingBody whole = body_of({});
  const StandingBody mended = body_of({.hole_mm = {85, 0, 30}, .hole_radius_mm = 10});
  EXPECT_NEAR(mended.breast_cm3[1], whole.breast_cm3[1], 0.02 * whole.breast_cm3[1]);
  EXPECT_THROW(body_of({.hole_mm = {85, 0, 0}, .hole_radius_mm = 30}), Error);
}

TEST(SkinCheck, SeesWhereAModelLeavesTheScanButNotAcrossItsHoles) {
  const Trunk trunk{.hole_mm = {85, 0, 0}, .hole_radius_mm = 12};
  const auto skin_at = [&](double x, double z, double before_mm) {
    return 1e-3 * Vec3{x, Trunk::chest(x) - trunk.bump(x, z) - before_mm, z};
  };
  std::vector<Vec3> skin{skin_at(-60, 40, 0), skin_at(0, 20, 2), skin_at(85, 0, 30)};
  const SkinDistance good = distance_from_scan(skin, trunk.scan());
  EXPECT_NEAR(1e3 * good.largest, 2.0, 0.1);  // the breastbone is flat there
  // Between two teeth of the hole's rim the closest point need not lie on the border.
  for (double turn = 0; turn < 6.2; turn += 0.05) {
    skin.push_back(skin_at(85 + 11 * std::cos(turn), 11 * std::sin(turn), 12));
  }
  EXPECT_NEAR(1e3 * distance_from_scan(skin, trunk.scan()).largest, 2.0, 0.1);
  skin.push_back(skin_at(0, -60, 9));
  const SkinDistance bad = distance_from_scan(skin, trunk.scan());
  EXPECT_NEAR(1e3 * bad.largest, 9.0, 0.1);
  EXPECT_NEAR(1e3 * bad.worst[2], -60, 1e-6);
}

TEST(Coarsened, ARoughFineScanHasNoHolesAfterwards) {
  // 0.5 mm edges that bend by 0.15 mm: many triangles fall onto each other in cubes of 1.5 mm.
  TriMesh mesh;
  constexpr int n = 121;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.15e-3);
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < n; ++i) {
      mesh.points.push_back(
          {0.5e-3 * i + noise(random), 0.02 + noise(random), 0.5e-3 * k + noise(random)});
      if (const int a = k * n + i; i + 1 < n && k + 1 < n) {
        mesh.triangles.push_back({a, a + 1, a + n});
        mesh.triangles.push_back({a + 1, a + n + 1, a + n});
      }
    }
  }
  const TriMesh coarse = outcome::coarsened(mesh, 1.5e-3);
  const std::vector<bool> border = outcome::border_vertices(coarse);
  for (std::size_t p = 0; p < coarse.points.size(); ++p) {
    const Vec3 mm = 1e3 * coarse.points[p];
    const double to_rim = std::min({mm[0], mm[2], 60 - mm[0], 60 - mm[2]});
    EXPECT_FALSE(border[p] && to_rim > 3.0) << mm[0] << " " << mm[2];
  }
}

}  // namespace
}  // namespace sanatrix::standing
