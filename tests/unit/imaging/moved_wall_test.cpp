// The chest wall moved on purpose: by the distance asked for, and nothing but the wall.
#include "imaging/moved_wall.hpp"

#include <gtest/gtest.h>

namespace {

using namespace sanatrix;

constexpr int wall_at = 12;
constexpr unsigned char fat = 1, gland = 2, muscle = 4, organ = 7, tumour = 8;

/// Along y: air, gland, muscle, organ; a tumour lies on the wall.
imaging::Segmentation layers() {
  imaging::Segmentation s;
  s.labels = {.size = {5, 24, 5}, .spacing_mm = {1, 1, 1}, .origin_mm = {}, .voxels = {}};
  s.labels.voxels.assign(5UL * 24 * 5, 0);
  s.fibroglandular = {
      .size = s.labels.size, .spacing_mm = {1, 1, 1}, .origin_mm = {}, .voxels = {}};
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 24; ++j) {
      for (int i = 0; i < 5; ++i) {
        unsigned char& label = s.labels.voxels[s.labels.index(i, j, k)];
        label = j < 4 ? 0 : j < wall_at ? gland : j < wall_at + 6 ? muscle : organ;
        label = i == 2 && k == 2 && j == wall_at - 1 ? tumour : label;
        s.fibroglandular.voxels.push_back(label == gland ? 1.0F : 0.0F);
      }
    }
  }
  return s;
}

int at(const imaging::Segmentation& s, int i, int j) {
  return s.labels.voxels[s.labels.index(i, j, 2)];
}

TEST(MovedWall, NearerBecomesMuscleAndSparesTheTumour) {
  imaging::Segmentation s = layers();
  imaging::move_wall(s, -3.0);
  EXPECT_EQ(at(s, 0, wall_at - 3), muscle);
  EXPECT_EQ(at(s, 0, wall_at - 4), gland);
  EXPECT_EQ(at(s, 2, wall_at - 1), tumour);
  EXPECT_EQ(s.fibroglandular.voxels[s.labels.index(0, wall_at - 3, 2)], 0.0F);
  EXPECT_EQ(s.fibroglandular.voxels[s.labels.index(0, wall_at - 4, 2)], 1.0F);
}

TEST(MovedWall, DeeperSetsFatFree) {
  imaging::Segmentation s = layers();
  imaging::move_wall(s, 3.0);
  EXPECT_EQ(at(s, 0, wall_at + 2), fat);
  EXPECT_EQ(at(s, 0, wall_at + 3), muscle);
  EXPECT_EQ(at(s, 0, wall_at - 1), gland);
  EXPECT_EQ(at(s, 0, 3), 0);
  EXPECT_EQ(at(s, 0, 23), organ);
}

}  // namespace
