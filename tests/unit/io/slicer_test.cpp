// Segmentations that went through 3D Slicer: what counts is the name of a segment.
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/slicer_segmentation.hpp"
#include "own_folder.hpp"
#include "synthetic_torso.hpp"

namespace sanatrix::io {
namespace {

const char* const header =
    "NRRD0004\ntype: unsigned char\ndimension: 4\nspace: left-posterior-superior\n"
    "sizes: 2 3 2 2\nspace directions: none (2,0,0) (0,2,0) (0,0,3)\n"
    "kinds: list domain domain domain\nencoding: raw\nspace origin: (10,20,30)\n";

std::filesystem::path two_layers(const std::string& second_name) {
  // Layer 0: 7 = fat, 2 = skin. Layer 1: 1 = the second name, in two voxels.
  std::string file = header;
  file += "Segment0_Name:=Skin\nSegment0_LabelValue:=2\nSegment0_Layer:=0\n";
  file += "Segment1_Name:=" + second_name + "\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n";
  file += "Segment2_Name:=Breast Fat\nSegment2_LabelValue:=7\nSegment2_Layer:=0\n\n";
  for (int v = 0; v < 12; ++v) {
    file += static_cast<char>(v == 0 ? 0 : v < 4 ? 2 : 7);
    file += static_cast<char>(v == 3 || v == 11 ? 1 : 0);
  }
  const std::filesystem::path to = testing::own_folder() / "edited.seg.nrrd";
  write_text(to, file);
  return to;
}

TEST(SlicerSegmentation, LayersAndValuesAreReadByTheirNames) {
  const auto labels = read_slicer_segmentation(two_layers("Tumor 1"));
  ASSERT_TRUE(labels);
  // Ten voxels of air more towards anterior; the place of the segments stays.
  EXPECT_EQ(labels->size, (std::array<int, 3>{3, 12, 2}));
  EXPECT_EQ(labels->origin_mm, (Vec3{10, 0, 30}));
  const auto at = [&](int i, int j, int k) {
    return static_cast<Label>(labels->at(i, j + 10, k));
  };
  EXPECT_EQ(at(0, 0, 0), Label::Air);
  EXPECT_EQ(at(1, 0, 0), Label::Skin);
  EXPECT_EQ(at(0, 1, 0), Label::Tumour);  // over skin
  EXPECT_EQ(at(1, 1, 0), Label::Adipose);
  EXPECT_EQ(at(2, 1, 1), Label::Tumour);
}

TEST(SlicerSegmentation, ANameThatIsNoTissueIsNamed) {
  try {
    read_slicer_segmentation(two_layers("Segment_2"));
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(e.one_line().find("'Segment_2'"), std::string::npos) << e.one_line();
  }
}

TEST(SlicerSegmentation, OurOwnComesBack) {
  const LabelImage labels = testing::SyntheticTorso{}.isotropic(4.0);
  const std::filesystem::path file = testing::own_folder() / "own.seg.nrrd";
  write_slicer_segmentation(labels, file);
  const auto again = read_slicer_segmentation(file);
  ASSERT_TRUE(again);
  ASSERT_EQ(again->size[1], labels.size[1] + 10);
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i) {
        ASSERT_EQ(again->at(i, j + 10, k), labels.at(i, j, k));
      }
    }
  }
}

}  // namespace
}  // namespace sanatrix::io
