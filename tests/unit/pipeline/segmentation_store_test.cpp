// The checked labels on disk, and what later stages may take from them.
#include "pipeline/segmentation_store.hpp"

#include <gtest/gtest.h>

#include "geometry/image_filters.hpp"
#include "own_folder.hpp"
#include "synthetic_torso.hpp"

namespace sanatrix::pipeline {
namespace {

imaging::Segmentation torso_up_to(double top_mm) {
  testing::SyntheticTorso torso;
  torso.notch_z_mm = 90.0;
  const int slices = 2 * static_cast<int>(top_mm / 1.5) + 1;
  imaging::Segmentation found;
  found.labels = torso.labels({168, 84, slices}, {1.5, 1.5, 1.5});
  found.fibroglandular = image_like<float>(found.labels);
  found.nipple_mm = {torso.tip(-1), torso.tip(1)};
  return found;
}

TEST(SegmentationStore, GivesASternalNotchInMetresOnlyWhenItIsSure) {
  const std::filesystem::path folder = testing::own_folder();
  save_segmentation(torso_up_to(120.0), folder);
  const auto notch = sure_sternal_notch(folder);
  ASSERT_TRUE(notch);
  EXPECT_NEAR((*notch)[2], 0.090, 0.004);
  save_segmentation(torso_up_to(99.0), folder);  // found, but the field ends close above it
  EXPECT_FALSE(sure_sternal_notch(folder));
  save_segmentation(torso_up_to(60.0), folder);
  EXPECT_FALSE(sure_sternal_notch(folder));
}

}  // namespace
}  // namespace sanatrix::pipeline
