// Automatic segmentation against the truth of the development patients.
#include "imaging/automatic.hpp"

#include <chrono>
#include <cstdio>
#include <ostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "imaging/agreement.hpp"
#include "imaging/quality.hpp"
#include "io/image_file.hpp"
#include "shared_data.hpp"

namespace sanatrix::imaging {
namespace {

struct Patient {
  const char* image;
  const char* truth;
};

void PrintTo(const Patient& patient, std::ostream* out) {
  *out << patient.image;
}

class Automatic : public ::testing::TestWithParam<Patient> {};

TEST_P(Automatic, AgreesWithTheTruth) {
  SANATRIX_REQUIRE_SHARED(std::string("data/") + GetParam().image);
  const Image3<float> image = io::read_image(shared_file);
  const LabelImage truth = io::read_labels(testing::shared_folder() / "data" / GetParam().truth);
  Silent silent;
  const auto start = std::chrono::steady_clock::now();
  const AutomaticLabels found = label_image(image, Context("segment", silent));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Agreement a = compare_labels(found.grid.labels, truth);
  std::printf(
      "%-16s soft %.4f  fgt %.3f vol %+.1f%%  wall %.2f p95 %.2f  skin %.2f p95 %.2f | "
      "gland %.3f fat %.3f spread %.3f sep %.1f | %.1f s\n",
      GetParam().image, a.soft_dice, a.glandular_dice, a.glandular_volume_percent,
      a.chest_wall.mean_mm, a.chest_wall.p95_mm, a.skin.mean_mm, a.skin.p95_mm,
      found.gland.gland_signal, found.gland.fat_signal, found.gland.fat_spread,
      found.gland.separation, seconds);
  EXPECT_GE(a.soft_dice, 0.95);
  EXPECT_GE(a.glandular_dice, 0.75);
  EXPECT_LE(std::abs(a.glandular_volume_percent), 12.0);
  EXPECT_LE(a.chest_wall.mean_mm, 2.5);
  EXPECT_LE(a.chest_wall.p95_mm, 7.0);
  EXPECT_LE(a.skin.mean_mm, 1.0);
  EXPECT_THAT(assess(found).doubts, ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Patients, Automatic,
                         ::testing::Values(Patient{"dev01/t1.nii.gz", "dev01/labels_mri.nii.gz"},
                                           Patient{"dev01/t2.nii.gz", "dev01/labels_mri.nii.gz"},
                                           Patient{"dev02/t1.nii.gz", "dev02/labels_mri.nii.gz"},
                                           Patient{"dev02/t2.nrrd", "dev02/labels_mri.nii.gz"}));

}  // namespace
}  // namespace sanatrix::imaging
