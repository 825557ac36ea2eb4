// Automatic segmentation of other anatomies and of worse images than those it was developed on.
#include <array>
#include <cstdio>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "geometry/image_filters.hpp"
#include "imaging/agreement.hpp"
#include "imaging/automatic.hpp"
#include "imaging/quality.hpp"
#include "imaging/skin_landmarks.hpp"
#include "io/image_file.hpp"
#include "shared_data.hpp"
#include "synthetic_mri.hpp"
#include "synthetic_torso.hpp"

namespace sanatrix::imaging {
namespace {

Agreement agreement_of(const char* name, const Image3<float>& image, const LabelImage& truth) {
  Silent silent;
  const AutomaticLabels found = label_image(image, Context("segment", silent));
  const Agreement a = compare_labels(found.grid.labels, truth);
  std::printf(
      "%-22s soft %.4f  fgt %.3f vol %+.1f%%  wall %.2f p95 %.2f  skin %.2f | gland %.3f fat %.3f "
      "sep %.1f\n",
      name, a.soft_dice, a.glandular_dice, a.glandular_volume_percent, a.chest_wall.mean_mm,
      a.chest_wall.p95_mm, a.skin.mean_mm, found.gland.gland_signal, found.gland.fat_signal,
      found.gland.separation);
  return a;
}

/// An image of the anatomy of one of the real label maps.
testing::SyntheticMri image_of(const testing::Anatomy& body, bool t2,
                               const testing::Scanner& scanner = {}) {
  return testing::synthetic_mri(body, t2 ? testing::t2_contrast : testing::t1_contrast, scanner);
}

struct Exam {
  const char* file;
  bool t2;
  testing::Scanner scanner;
};
void PrintTo(const Exam& exam, std::ostream* out) {
  *out << exam.file << (exam.t2 ? " T2" : " T1") << " noise " << exam.scanner.noise << " pixel "
       << exam.scanner.pixel_mm << " coil " << exam.scanner.coil.decay_mm << " shading "
       << exam.scanner.coil.power;
}
class OtherAnatomy : public ::testing::TestWithParam<Exam> {};

TEST_P(OtherAnatomy, IsSegmentedFromAnImageMadeOfItsLabels) {
  const std::string path = std::string("data/real_prone_labels/") + GetParam().file;
  SANATRIX_REQUIRE_SHARED(path);
  const auto mri = image_of(testing::real_anatomy(shared_file), GetParam().t2, GetParam().scanner);
  const Agreement a = agreement_of(GetParam().file, mri.image, mri.truth);
  EXPECT_GE(a.soft_dice, 0.95);
  EXPECT_LE(a.chest_wall.mean_mm, 2.5);
  EXPECT_LE(a.chest_wall.p95_mm, 7.0);
  EXPECT_LE(a.skin.mean_mm, 1.0);
  EXPECT_GE(a.glandular_dice, 0.75);
  EXPECT_LE(std::abs(a.glandular_volume_percent), 12.0);
}

// 20 s each.
INSTANTIATE_TEST_SUITE_P(
    Exams, OtherAnatomy,
    ::testing::Values(
        Exam{"Exam_15_detailed.nii.gz", false, {.coil = {}, .noise = 6.2}},
        Exam{"Exam_15_detailed.nii.gz",
             false,
             {.coil = {.decay_mm = 45.0, .floor = 0.2}, .noise = 6.2}},
        Exam{"Exam_25_detailed.nii.gz", false, {.coil = {}, .noise = 6.2}},
        // Fat at the flanks has twice the signal of air.
        Exam{"Exam_25_detailed.nii.gz", true, {.coil = {.power = 2.0}, .noise = 7.2}}));

// Of the gland only what is thick is left, as in a fatty breast. 20 s.
TEST(FattyBreast, IsNotTakenForADenseOne) {
  SANATRIX_REQUIRE_SHARED("data/real_prone_labels/Exam_15_detailed.nii.gz");
  testing::Anatomy body = testing::real_anatomy(shared_file);
  testing::make_fatty(body);
  const auto mri = image_of(body, true);
  const Agreement a = agreement_of("fatty", mri.image, mri.truth);
  EXPECT_GE(a.glandular_dice, 0.75);
  EXPECT_LE(std::abs(a.glandular_volume_percent), 20.0);
}

enum class Change { Noise, Shading, LargerBreast, EveryThirdSlice };
struct Worse {
  const char* image;
  const char* truth;
  Change change;
};
void PrintTo(const Worse& worse, std::ostream* out) {
  *out << worse.image << ' '
       << std::array{"noise", "shading", "larger breast",
                     "every third slice"}[static_cast<std::size_t>(worse.change)];
}
class WorseImage : public ::testing::TestWithParam<Worse> {};

template <class T>
Image3<T> every_third_slice(const Image3<T>& image) {
  Image3<T> thin = image;
  thin.size[2] = (image.size[2] + 2) / 3;
  thin.spacing_mm[2] *= 3.0;
  thin.voxels.clear();
  const auto slice = static_cast<long>(image.size[0]) * image.size[1];
  for (int k = 0; k < image.size[2]; k += 3) {
    thin.voxels.insert(thin.voxels.end(), image.voxels.begin() + k * slice,
                       image.voxels.begin() + (k + 1) * slice);
  }
  return thin;
}

/// The coil's 1.6 at the nipple to 0.3 at the back, the tilt and the fall towards the ends of the
/// stack once more.
void double_shading(Image3<float>& image) {
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        const double across = 2.0 * i / image.size[0] - 1.0, along = 2.0 * k / image.size[2] - 1.0;
        image.at(i, j, k) *=
            static_cast<float>(1.5 * std::exp(-j * image.spacing_mm[1] / 110.0) *
                               (1.0 + 0.25 * across) * (1.0 - 0.25 * along * along));
      }
    }
  }
}

TEST_P(WorseImage, IsStillSegmented) {
  SANATRIX_REQUIRE_SHARED(std::string("data/") + GetParam().image);
  Image3<float> image = io::read_image(shared_file);
  LabelImage truth = io::read_labels(testing::shared_folder() / "data" / GetParam().truth);
  switch (GetParam().change) {
    case Change::Noise:  // sqrt(3) of noise on top doubles it
      testing::add_rician_noise(image, std::sqrt(3.0) * 7.2);
      break;
    case Change::Shading:
      double_shading(image);
      break;
    case Change::LargerBreast:
      image = testing::stretched(image, 1.0, 1.3);
      truth = testing::stretched(truth, 1.0, 1.3);
      break;
    case Change::EveryThirdSlice:
      image = every_third_slice(image);
      truth = every_third_slice(truth);
      break;
  }
  const Agreement a = agreement_of(GetParam().image, image, truth);
  EXPECT_GE(a.soft_dice, 0.95);
  EXPECT_GE(a.glandular_dice, 0.75);
  EXPECT_LE(std::abs(a.glandular_volume_percent), 12.0);
  EXPECT_LE(a.chest_wall.mean_mm, 2.5);
  EXPECT_LE(a.chest_wall.p95_mm, 7.0);
  EXPECT_LE(a.skin.mean_mm, 1.0);
}

// 10 s each.
INSTANTIATE_TEST_SUITE_P(
    Changes, WorseImage,
    ::testing::Values(Worse{"dev02/t2.nrrd", "dev02/labels_mri.nii.gz", Change::Noise},
                      Worse{"dev02/t2.nrrd", "dev02/labels_mri.nii.gz", Change::Shading},
                      Worse{"dev01/t2.nii.gz", "dev01/labels_mri.nii.gz", Change::Noise},
                      Worse{"dev01/t2.nii.gz", "dev01/labels_mri.nii.gz", Change::Shading},
                      Worse{"dev02/t2.nrrd", "dev02/labels_mri.nii.gz", Change::LargerBreast},
                      Worse{"dev02/t2.nrrd", "dev02/labels_mri.nii.gz", Change::EveryThirdSlice}));

/// What is wrong with an image, according to its own segmentation.
std::string defects_of(const AutomaticLabels& found) {
  std::string all;
  for (const std::string& defect : assess(found).defects) {
    all += defect + "; ";
  }
  return all;
}

// 10 s.
TEST(Refusal, OfABreastThatTheImageCutsOff) {
  SANATRIX_REQUIRE_SHARED("data/dev02/t2.nrrd");
  Image3<float> image = io::read_image(shared_file);
  const int rows = image.size[1] / 4;  // 42 mm, the tips of both breasts among them
  Image3<float> cut = image;
  cut.size[1] -= rows;
  cut.origin_mm = image.position_mm(0, rows, 0);
  cut.voxels.clear();
  for (int k = 0; k < cut.size[2]; ++k) {
    const auto slice = image.voxels.begin() + static_cast<long>(image.index(0, 0, k));
    cut.voxels.insert(cut.voxels.end(), slice + static_cast<long>(rows) * image.size[0],
                      slice + static_cast<long>(image.size[1]) * image.size[0]);
  }
  Silent silent;
  const std::string defects = defects_of(label_image(cut, Context("segment", silent)));
  EXPECT_NE(defects.find("RIGHT breast is cut off"), std::string::npos) << defects;
  EXPECT_NE(defects.find("LEFT breast is cut off"), std::string::npos) << defects;
  EXPECT_EQ(defects_of(label_image(image, Context("segment", silent))), "");
}

// Shading and noise doubled: the flanks are not in the image, and air seems to reach the lungs. 10
// s.
TEST(Refusal, OfASkinThatNoiseHides) {
  SANATRIX_REQUIRE_SHARED("data/real_prone_labels/Exam_25_detailed.nii.gz");
  Silent silent;
  const Image3<float> image =
      image_of(testing::real_anatomy(shared_file), true, {.coil = {.power = 2.0}, .noise = 14.4})
          .image;
  const std::string defects = defects_of(label_image(image, Context("segment", silent)));
  EXPECT_NE(defects.find("the skin at the side is lost in noise"), std::string::npos) << defects;
}

struct Trunk {
  const char* file;
  bool t2;
  testing::Back back;
};
void PrintTo(const Trunk& trunk, std::ostream* out) {
  *out << trunk.file << (trunk.t2 ? " T2, " : " T1, ")
       << (trunk.back == testing::Back::Round ? "round" : "as wide as the field");
}
class WholeTrunk : public ::testing::TestWithParam<Trunk> {};

// Her back, and the air behind it, are no front and no lost skin. 40 s each.
TEST_P(WholeTrunk, IsSegmentedAsWellAsItsFront) {
  SANATRIX_REQUIRE_SHARED(std::string("data/real_prone_labels/") + GetParam().file);
  const testing::Anatomy body =
      testing::with_back_of_trunk(testing::real_anatomy(shared_file), GetParam().back);
  const auto mri = image_of(body, GetParam().t2);
  Silent silent;
  const AutomaticLabels found = label_image(mri.image, Context("segment", silent));
  EXPECT_EQ(defects_of(found), "");
  const Agreement a = compare_labels(found.grid.labels, mri.truth);
  EXPECT_GE(a.soft_dice, 0.95);
  EXPECT_GE(a.glandular_dice, 0.75);
  EXPECT_LE(std::abs(a.glandular_volume_percent), 12.0);
  EXPECT_LE(a.chest_wall.mean_mm, 2.5);
  EXPECT_LE(a.chest_wall.p95_mm, 7.0);
  EXPECT_LE(a.skin.mean_mm, 1.0);
}

INSTANTIATE_TEST_SUITE_P(
    Backs, WholeTrunk,
    ::testing::Values(Trunk{"Exam_15_detailed.nii.gz", true, testing::Back::Round},
                      Trunk{"Exam_25_detailed.nii.gz", false, testing::Back::AsWideAsTheField}));

// In an image with noise and shading, not in labels. 15 s.
TEST(SternalNotch, IsFoundInAnImage) {
  testing::SyntheticTorso torso;
  torso.notch_z_mm = 90.0;
  testing::Anatomy body{torso.labels({280, 140, 249}, {1.0, 1.0, 1.0}), {}};
  body.water = image_like<float>(body.labels);
  std::ranges::transform(body.labels.voxels, body.water.voxels.begin(), [](unsigned char label) {
    return label == testing::code(Label::Fibroglandular) ? 1.0F : 0.0F;
  });
  Silent silent;
  const auto found =
      segment_image(image_of(body, false).image, 1.5, std::nullopt, Context("segment", silent));
  const auto marks = skin_landmarks(found.segmentation);
  const auto notch = std::ranges::find(marks, "sternal_notch", &SkinLandmark::name);
  ASSERT_TRUE(notch->at_mm) << notch->missing;
  // The turn is a corner that 3 mm of smoothing and slices round off.
  EXPECT_LT(norm(*notch->at_mm - Vec3{0.0, torso.layer_front(0.0, 90.0), 90.0}), 4.0);
  EXPECT_GT(notch->confidence, sure_landmark);
}

// The signal falls by e in 40 mm while noise is doubled: the wall lies below the noise. 10 s.
TEST(Refusal, OfAWallThatNoiseHides) {
  SANATRIX_REQUIRE_SHARED("data/real_prone_labels/Exam_25_detailed.nii.gz");
  Silent silent;
  const Image3<float> image =
      image_of(testing::real_anatomy(shared_file), true,
               {.coil = {.decay_mm = 40.0, .floor = 0.0, .side_tilt = 0.3}, .noise = 12.0})
          .image;
  const std::string defects = defects_of(label_image(image, Context("segment", silent)));
  EXPECT_NE(defects.find("the chest wall is seen on only"), std::string::npos) << defects;
}

}  // namespace
}  // namespace sanatrix::imaging
