// The chest wall where it is hard to see.
#include "imaging/chest_wall.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace sanatrix;

/// Cross-sections that are circles about one axis: muscle and 25 mm of fat on it. From 10 to 45
/// degrees to the left a breast stands 60 mm before it, whose gland lies on the muscle from 15 to
/// 40 degrees. Above the middle slice the chest falls back by 1.2 mm per slice.
struct RoundChest {
  double cleft_i_mm = 150.0, cleft_j_mm = 75.0;
  int slices = 28;

  [[nodiscard]] double radius(int k) const { return 95.0 - 1.2 * std::max(0, k - slices / 2); }
  [[nodiscard]] Vec3 from_axis(double i_mm, double j_mm) const {
    return {i_mm - cleft_i_mm, cleft_j_mm + imaging::thorax_radius_mm - j_mm, 0.0};
  }
  /// Signal relative to fat in T1; 0 outside the body.
  [[nodiscard]] float signal(double i_mm, double j_mm, int k) const {
    const Vec3 p = from_axis(i_mm, j_mm);
    const double before_wall = norm(p) - radius(k);
    const double angle = std::atan2(p[0], p[1]) * 180.0 / std::numbers::pi;
    const bool breast = std::abs(angle - 27.5) < 17.5, gland = std::abs(angle - 27.5) < 12.5;
    return before_wall > (breast ? 60.0 : 25.0) ? 0.0F
           : before_wall < 0.0                  ? 0.23F
           : gland && before_wall < 45.0        ? 0.30F
                                                : 1.0F;
  }
};

TEST(ChestWall, GoesOnBehindGlandThatLiesOnIt) {
  const RoundChest chest;
  Image3<float> relative;
  relative.size = {250, 150, chest.slices};
  relative.spacing_mm = {1.2, 1.2, 3.0};
  Mask body = image_like<unsigned char>(relative);
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 0.04F);
  for (int k = 0; k < chest.slices; ++k) {
    for (int j = 0; j < relative.size[1]; ++j) {
      for (int i = 0; i < relative.size[0]; ++i) {
        const float signal = chest.signal(1.2 * i, 1.2 * j, k);
        relative.voxels.push_back(signal + noise(random));
        body.voxels.push_back(signal > 0.0F ? 1 : 0);
      }
    }
  }
  const imaging::ChestWall wall =
      imaging::find_chest_wall(relative, body, chest.cleft_i_mm, chest.cleft_j_mm);
  for (int k = 0; k < chest.slices; ++k) {
    for (double degrees = -70.0; degrees <= 70.0; degrees += 5.0) {
      const double angle = degrees * std::numbers::pi / 180.0, r = chest.radius(k);
      const double i_mm = chest.cleft_i_mm + r * std::sin(angle);
      const double j_mm = chest.cleft_j_mm + imaging::thorax_radius_mm - r * std::cos(angle);
      // Two voxels, and the smoothing over slices that are not parallel.
      EXPECT_NEAR(wall.behind_mm(i_mm, j_mm, k), 0.0, 3.0) << "slice " << k << " at " << degrees;
    }
  }
}

}  // namespace
