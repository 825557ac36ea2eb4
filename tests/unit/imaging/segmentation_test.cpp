// Given labels: both presets, any orientation, thick slices, landmarks, and refusals with their
// cause.
#include "imaging/segmentation.hpp"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "imaging/grids.hpp"
#include "imaging/landmarks.hpp"
#include "imaging/skin_landmarks.hpp"
#include "io/image_file.hpp"
#include "shared_data.hpp"
#include "synthetic_torso.hpp"

namespace {

using namespace sanatrix;
using imaging::LabelPreset;
using sanatrix::testing::SyntheticTorso;
using ::testing::HasSubstr;

class Segmentation : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  imaging::Segmentation run(const LabelImage& labels,
                            LabelPreset preset = LabelPreset::Sanatrix) const {
    io::write_labels(labels, file_);
    Silent nobody;
    return imaging::segment_given_labels(file_, preset, 1.5, Context("segment", nobody));
  }
  std::string refusal(const LabelImage& labels, LabelPreset preset = LabelPreset::Sanatrix) const {
    try {
      run(labels, preset);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::Input);
      EXPECT_FALSE(e.hint().empty()) << e.what();
      return e.what();
    }
    return "accepted";
  }

 private:
  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() /
      (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".nii.gz");
};

double count(const LabelImage& labels, bool (*belongs)(unsigned char)) {
  return static_cast<double>(std::count_if(labels.voxels.begin(), labels.voxels.end(), belongs));
}

/// Largest distance [mm] from the true skin of a voxel that is on the wrong side of it.
double worst_skin_error(const LabelImage& labels, const SyntheticTorso& torso) {
  double worst = 0.0;
  std::size_t voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        const Vec3 p = labels.position_mm(i, j, k);
        const double outside = torso.outside(p);
        // At the image's borders there is nothing to interpolate between.
        if (std::abs(p[0]) < 100 && std::abs(p[2]) < 75 && p[1] < 40 &&
            (outside > 0) != (labels.voxels[voxel] == 0)) {
          worst = std::max(worst, std::abs(outside));
        }
      }
    }
  }
  return worst;
}

TEST_F(Segmentation, resamples_thick_axial_slices_without_stairs) {
  const SyntheticTorso torso;
  const auto result = run(torso.labels({315, 158, 56}, {0.8, 0.8, 3.0}));
  EXPECT_EQ(result.labels.direction, identity3);
  EXPECT_EQ(result.labels.spacing_mm, (Vec3{1.5, 1.5, 1.5}));
  // Nearest slices would be wrong by up to 1.5 mm / sin(slope); in-plane voxels are 0.8 mm.
  EXPECT_LT(worst_skin_error(result.labels, torso), 1.3);
}

TEST_F(Segmentation, brings_sagittal_and_oblique_volumes_to_lps) {
  const SyntheticTorso torso;
  // Sagittal storage: i runs to inferior, j to posterior, k to the patient's left.
  const Mat3 sagittal{{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}};
  EXPECT_LT(worst_skin_error(run(torso.labels({168, 126, 84}, {1, 1, 3}, sagittal)).labels, torso),
            1.6);
  const double c = std::cos(0.15);
  const double s = std::sin(0.15);
  const Mat3 oblique{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
  EXPECT_LT(worst_skin_error(run(torso.labels({280, 170, 168}, {1, 1, 1}, oblique)).labels, torso),
            1.2);
}

TEST_F(Segmentation, finds_midline_nipples_and_tissue_volumes) {
  const SyntheticTorso torso;
  const auto result = run(torso.isotropic(1.2));
  EXPECT_NEAR(result.midline_x_mm, 0.0, 1.5);
  EXPECT_FALSE(result.nipples_from_label);
  EXPECT_LT(norm(result.nipple_mm[0] - torso.tip(-1)), 3.0);
  EXPECT_LT(norm(result.nipple_mm[1] - torso.tip(1)), 3.0);
  // The fold is where the ellipsoid meets the layer on the chest: all its z half-axis below.
  int folds = 0;
  for (const imaging::SkinLandmark& mark : imaging::skin_landmarks(result)) {
    if (mark.name == "sternal_notch") {
      EXPECT_FALSE(mark.at_mm);
      EXPECT_EQ(mark.confidence, 0.0);
      continue;
    }
    EXPECT_GT(mark.confidence, 0.3) << mark.name;
    ASSERT_TRUE(mark.at_mm) << mark.name << ": " << mark.missing;
    if (mark.name.starts_with("inframammary_fold")) {
      EXPECT_NEAR((*mark.at_mm)[2], -torso.semi_axes_mm[2], 4.0);
      ++folds;
    }
  }
  EXPECT_EQ(folds, 2);
  double glandular = 0.0;
  for (const float f : result.fibroglandular.voxels) {
    glandular += f;
  }
  const double expected =
      count(torso.isotropic(1.2), [](unsigned char l) { return l == 2; }) * 1.2 * 1.2 * 1.2;
  EXPECT_NEAR(glandular * result.labels.voxel_volume_mm3(), expected, 0.02 * expected);
}

imaging::SkinLandmark notch_of(const imaging::Segmentation& found) {
  const auto marks = imaging::skin_landmarks(found);
  return *std::ranges::find(marks, "sternal_notch", &imaging::SkinLandmark::name);
}

TEST_F(Segmentation, finds_the_sternal_notch_only_where_the_field_goes_on_above_it) {
  SyntheticTorso torso;
  torso.notch_z_mm = 90.0;
  torso.notch_x_mm = 4.0;
  const auto up_to = [&](double top_mm) {  // slices of 3 mm from -top to top
    const int slices = 2 * static_cast<int>(top_mm / 3.0) + 1;
    return notch_of(run(torso.labels({210, 105, slices}, {1.2, 1.2, 3.0})));
  };
  const imaging::SkinLandmark seen = up_to(123.0);
  ASSERT_TRUE(seen.at_mm) << seen.missing;
  const Vec3 truth{4.0, torso.layer_front(4.0, 90.0), 90.0};
  // The turn is a corner that 3 mm of smoothing and slices round off.
  EXPECT_LT(norm(*seen.at_mm - truth), 4.0);
  EXPECT_GT(seen.confidence, 0.9);

  const imaging::SkinLandmark close = up_to(99.0);
  EXPECT_LT(close.confidence, imaging::sure_landmark);
  const imaging::SkinLandmark below = up_to(84.0);
  EXPECT_FALSE(below.at_mm);
  EXPECT_THAT(below.missing, HasSubstr("in the hollow above the breastbone"));
  const imaging::SkinLandmark far_below = up_to(69.0);
  EXPECT_FALSE(far_below.at_mm);
  EXPECT_THAT(far_below.missing, HasSubstr("no hollow up to the end of the field"));

  // A neck that is turned: its side's groove is not the notch.
  torso.notch_x_mm = 24.0;
  EXPECT_FALSE(up_to(123.0).at_mm);
}

/// The same patient as Pelicano et al. would store it.
LabelImage as_pelicano(const LabelImage& labels, const SyntheticTorso& torso) {
  LabelImage pelicano = labels;
  std::size_t voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        const Vec3 p = labels.position_mm(i, j, k);
        const double behind = p[1] - torso.chest_front(p[0]);
        const unsigned char label = labels.voxels[voxel];
        pelicano.voxels[voxel] = label == 0 || behind > 4.0 ? 4
                                 : behind > 0.0             ? 3
                                 : label == 3               ? 2
                                 : label == 2               ? 6
                                                            : 11;
      }
    }
  }
  return pelicano;
}

TEST_F(Segmentation, reads_pelicano_maps_with_a_sheet_and_untrusted_ends) {
  const SyntheticTorso torso;
  const LabelImage given = torso.labels({126, 63, 150}, {2, 2, 2});
  const auto result = run(as_pelicano(given, torso), LabelPreset::Pelicano);
  // Cut to 90 mm above and below the nipples, and the thorax is not air.
  EXPECT_NEAR(result.labels.size[2] * 1.5, 180.0, 4.0);
  const Vec3 inside = result.labels.continuous_index({0, torso.chest_y_mm + 20, 0});
  EXPECT_EQ(result.labels.at(static_cast<int>(inside[0]), static_cast<int>(inside[1]),
                             static_cast<int>(inside[2])),
            static_cast<unsigned char>(Label::Organ));
  // Second level: 86 % water, of which adipose tissue would have 30 %.
  const Vec3 gland = {62, torso.tip(1)[1] + 55, 0};
  const Vec3 at = result.fibroglandular.continuous_index(gland);
  EXPECT_NEAR(result.fibroglandular.at(static_cast<int>(at[0]), static_cast<int>(at[1]),
                                       static_cast<int>(at[2])),
              0.8, 1e-6);
}

TEST_F(Segmentation, refuses_what_cannot_be_a_prone_breast_mri) {
  const SyntheticTorso torso;
  const LabelImage good = torso.isotropic(2.0);

  LabelImage no_wall = good;
  LabelImage only_wall = good;
  for (std::size_t i = 0; i < good.voxels.size(); ++i) {
    no_wall.voxels[i] = is_wall(good.voxels[i]) ? 1 : good.voxels[i];
    only_wall.voxels[i] = is_soft(good.voxels[i]) ? 0 : good.voxels[i];
  }
  EXPECT_THAT(refusal(no_wall), HasSubstr("no chest wall"));
  EXPECT_THAT(refusal(only_wall), HasSubstr("no breast"));

  LabelImage flipped = good;
  flipped.direction = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
  EXPECT_THAT(refusal(flipped), HasSubstr("anterior and posterior are swapped"));

  LabelImage metres = good;
  metres.spacing_mm = {0.002, 0.002, 0.002};
  EXPECT_THAT(refusal(metres), HasSubstr("0.002 x 0.002 x 0.002 mm"));

  LabelImage foreign = good;
  foreign.voxels[good.voxels.size() / 2] = 77;
  EXPECT_THAT(refusal(foreign), HasSubstr("label 77 is not in the table of preset 'sanatrix'"));

  SyntheticTorso one = torso;
  one.left_breast = false;
  EXPECT_THAT(refusal(one.isotropic(2.0)), HasSubstr("two breasts with a cleft"));
  SyntheticTorso none = one;
  none.right_breast = false;
  EXPECT_THAT(refusal(none.isotropic(2.0)), HasSubstr("two breasts with a cleft"));
}

TEST_F(Segmentation, takes_a_whole_trunk_with_a_thick_back) {
  const SyntheticTorso torso;
  LabelImage whole = torso.isotropic(2.0);
  std::size_t voxel = 0;
  for (int k = 0; k < whole.size[2]; ++k) {
    for (int j = 0; j < whole.size[1]; ++j) {
      for (int i = 0; i < whole.size[0]; ++i, ++voxel) {
        const double y = whole.position_mm(i, j, k)[1];
        if (y > torso.chest_y_mm + 14.0 && whole.voxels[voxel] != 0) {
          whole.voxels[voxel] = y > 54.0 ? 0 : 1;  // fat before the air behind her
        }
      }
    }
  }
  EXPECT_NEAR(run(whole).midline_x_mm, 0.0, 1.5);
}

TEST(LabelPresets, are_named) {
  EXPECT_EQ(imaging::parse_label_preset("pelicano"), LabelPreset::Pelicano);
  EXPECT_EQ(imaging::parse_label_preset("sanatrix"), LabelPreset::Sanatrix);
  EXPECT_THROW(imaging::parse_label_preset("dicom"), Error);
}

/// Whole label maps of real prone patients reach the neck. Where their notches are was read off
/// pictures of the skin's height: two are plain, the third does not show between the neck's
/// muscles.
TEST(SternalNotch, is_found_on_real_torsos_or_not_at_all) {
  struct Real {
    const char* name;
    std::optional<Vec3> notch_mm;
  };
  for (const Real& real : {Real{"Exam_06", Vec3{-10, 50, 90}}, Real{"Exam_15", Vec3{6, 51, 88}},
                           Real{"Exam_25", std::nullopt}}) {
    SANATRIX_REQUIRE_SHARED(
        (std::string("data/real_prone_labels/") + real.name + "_detailed.nii.gz").c_str());
    const Image3<float> given = imaging::in_lps_order(io::read_image(shared_file));
    imaging::Segmentation whole;
    whole.labels = image_like<unsigned char>(given);
    std::ranges::transform(given.voxels, whole.labels.voxels.begin(), [](float label) {
      return static_cast<unsigned char>(label == 4.0F ? 0 : 1);  // 4 is air
    });
    const imaging::Landmarks marks = imaging::find_landmarks(whole.labels);
    whole.nipple_mm = marks.nipple_mm;
    whole.midline_x_mm = marks.midline_x_mm;
    const imaging::SkinLandmark notch = notch_of(whole);
    ASSERT_EQ(notch.at_mm.has_value(), real.notch_mm.has_value()) << real.name;
    if (real.notch_mm) {
      // As far as two readers of such a picture differ.
      EXPECT_LT(norm(*notch.at_mm - *real.notch_mm), 8.0) << real.name;
      EXPECT_GT(notch.confidence, imaging::sure_landmark);
    }
  }
}

TEST(SegmentationOfPatients, dev01_has_the_planned_landmarks_and_gland) {
  SANATRIX_REQUIRE_SHARED("data/dev01/labels_mri.nii.gz");
  Silent nobody;
  const auto result = imaging::segment_given_labels(shared_file, LabelPreset::Sanatrix, 1.5,
                                                    Context("segment", nobody));
  // plan.json of dev01; its nipples are the most anterior skin points, as ours.
  EXPECT_NEAR(result.midline_x_mm, -2.5, 3.0);
  EXPECT_LT(norm(result.nipple_mm[0] - Vec3{-75.7, -99.8, -21.2}), 3.0);
  EXPECT_LT(norm(result.nipple_mm[1] - Vec3{65.5, -101.8, -27.7}), 3.0);
  double glandular = 0.0;
  for (const float f : result.fibroglandular.voxels) {
    glandular += f;
  }
  EXPECT_NEAR(glandular * result.labels.voxel_volume_mm3() * 1e-3, 165.8 + 179.6, 0.03 * 345.4);
}

}  // namespace
