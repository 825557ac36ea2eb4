// Nipples by the skin's colours: painted on a trunk of formulas, away from the tips of its breasts.
#include "standing/areola.hpp"

#include <gtest/gtest.h>

#include "standing/scan_frame.hpp"
#include "standing_trunk.hpp"

namespace sanatrix::standing {
namespace {

using testing::Trunk;

/// Skin with blotches, a shadow below each breast and, perhaps, areolas of 19 mm around the places.
std::vector<Colour> painted(const TriMesh& trunk, const std::array<Vec3, 2>& areola_mm,
                            bool with_areolas, double pigment) {
  std::vector<Colour> colours;
  for (const Vec3& m : trunk.points) {
    const Vec3 p = 1e3 * m;
    const double blotch = 1 + 0.03 * std::sin(0.05 * p[0] + 1) * std::cos(0.04 * p[2]);
    const bool fold = std::abs(std::abs(p[0]) - 85) < 55 && std::abs(p[2] + 62) < 6;
    double red = 215 * blotch, green = 172 * blotch, blue = 148 * blotch;
    for (const Vec3& centre : areola_mm) {
      if (with_areolas && norm(p - centre) < 19) {
        red *= 1 - 0.35 * pigment;
        green *= 1 - 0.55 * pigment;
        blue *= 1 - 0.55 * pigment;
      }
    }
    const double light = fold ? 0.45 : 1.0;
    colours.push_back({static_cast<float>(light * red), static_cast<float>(light * green),
                       static_cast<float>(light * blue)});
  }
  return colours;
}

const TriMesh& trunk() {
  static const TriMesh mesh = Trunk{}.scan();
  return mesh;
}
/// Off the tips of the breasts by 20 to 30 mm, and not the same on both sides.
std::array<Vec3, 2> places() {
  const auto on_skin = [](double x, double z) {
    return Vec3{x, Trunk::chest(x) - Trunk{}.bump(x, z), z};
  };
  return {on_skin(-100, -18), on_skin(108, -10)};
}

TEST(Areola, IsFoundWhereItIsPaintedInAnyPoseAndPigment) {
  for (const double pigment : {1.0, 0.4}) {
    for (const double turn : {0.0, 2.4}) {
      TexturedSurface scan = testing::plain(moved(trunk(), testing::some_pose(turn)));
      scan.point_colour = painted(trunk(), places(), true, pigment);
      const ScanFrame frame = find_frame(scan, {});
      for (const std::size_t side : {0U, 1U}) {
        EXPECT_EQ(frame.nipple_find[side].sign, NippleSign::Colour);
        const Vec3 found =
            inverse(testing::some_pose(turn))(inverse(frame.to_patient)(frame.nipple[side]));
        // A third of the scan's 4 mm columns is the best that its colours can tell.
        EXPECT_LT(norm(1e3 * found - places()[side]), 2.0) << pigment << " " << turn << " " << side;
      }
    }
  }
}

TEST(Areola, ShadowsAndBlotchesAreNone) {
  TexturedSurface scan = testing::plain(trunk());
  scan.point_colour = painted(trunk(), places(), false, 1.0);
  const ScanFrame frame = find_frame(scan, {});
  for (const std::size_t side : {0U, 1U}) {
    EXPECT_EQ(frame.nipple_find[side].sign, NippleSign::Shape);
    EXPECT_GT(frame.nipple_find[side].doubt_mm, 10.0);
  }
  EXPECT_EQ(frame.notes.size(), 3U);  // the vertical and two nipples
}

TEST(Areola, AMarkedNippleStays) {
  TexturedSurface scan = testing::plain(trunk());
  scan.point_colour = painted(trunk(), places(), true, 1.0);
  ScanLandmarks marks;
  marks.nipple[1] = trunk().points[trunk().points.size() / 2 + 21];
  const ScanFrame frame = find_frame(scan, marks);
  EXPECT_EQ(frame.nipple_find[0].sign, NippleSign::Colour);
  EXPECT_EQ(frame.nipple_find[1].sign, NippleSign::Mark);
  EXPECT_LT(1e3 * norm(inverse(frame.to_patient)(frame.nipple[1]) - *marks.nipple[1]), 1e-6);
}

}  // namespace
}  // namespace sanatrix::standing
