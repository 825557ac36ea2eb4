// Images keep their voxels and their place in the patient through every format.
#include "io/image_file.hpp"

#include <cstring>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "own_folder.hpp"
#include "shared_data.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ImageFile : public ::testing::Test {
 protected:
  ~ImageFile() override { fs::remove_all(folder_); }
  fs::path folder_ = testing::own_folder();
};

/// Oblique, anisotropic, off centre.
template <class T>
Image3<T> oblique_image() {
  Image3<T> image;
  image.size = {5, 4, 3};
  image.spacing_mm = {0.6, 0.7, 3.0};
  image.origin_mm = {-120.5, 33.25, -80.125};
  const double c = std::cos(0.2), s = std::sin(0.2);
  image.direction = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
  for (int i = 0; i < 60; ++i) {
    image.voxels.push_back(static_cast<T>(i % 11));
  }
  return image;
}

template <class T>
void expect_same(const Image3<T>& a, const Image3<T>& b) {
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.voxels, b.voxels);
  for (const Vec3& index : {Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{0, 3, 0}, Vec3{0, 0, 2}}) {
    // NIfTI stores its matrix in single precision: 120 mm to 1e-5 mm.
    EXPECT_NEAR(norm(a.position_mm(index[0], index[1], index[2]) -
                     b.position_mm(index[0], index[1], index[2])),
                0.0, 5e-5);
  }
}

std::string refusal(const fs::path& file) {
  try {
    read_image(file);
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Input);
    return e.one_line();
  }
  return "accepted";
}

TEST_F(ImageFile, EveryFormatGivesBackVoxelsAndPlace) {
  for (const char* extension : {".nii.gz", ".nii", ".nrrd", ".mha"}) {
    SCOPED_TRACE(extension);
    const fs::path file = folder_ / (std::string("a") + extension);
    write_labels(oblique_image<unsigned char>(), file);
    expect_same(read_labels(file), oblique_image<unsigned char>());
    write_image(oblique_image<float>(), file);
    expect_same(read_image(file), oblique_image<float>());
  }
}

TEST_F(ImageFile, LabelsThatAreNotLabelsAreRefused) {
  for (const float bad : {0.5F, -1.0F, 256.0F}) {
    Image3<float> image = oblique_image<float>();
    image.voxels[7] = bad;
    write_image(image, folder_ / "a.nrrd");
    try {
      read_labels(folder_ / "a.nrrd");
      ADD_FAILURE() << bad << " was accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::Input);
      EXPECT_THAT(e.what(), HasSubstr("a.nrrd is not a label image"));
    }
  }
}

TEST_F(ImageFile, MissingForeignAndTruncatedFilesAreNamed) {
  EXPECT_THAT(refusal(folder_ / "absent.nii.gz"), HasSubstr("absent.nii.gz does not exist"));
  write_text(folder_ / "text.nii.gz", "not an image");
  EXPECT_THAT(refusal(folder_ / "text.nii.gz"), HasSubstr("text.nii.gz"));
  Image3<float> image = oblique_image<float>();
  image.size = {50, 40, 30};
  image.voxels.resize(60000);
  for (std::size_t i = 0; i < image.voxels.size(); ++i) {
    image.voxels[i] = static_cast<float>((i * 7919) % 1009);
  }
  for (const char* name : {"a.nii.gz", "a.nrrd", "a.mha", "a.nii"}) {
    write_image(image, folder_ / name);
    const std::string all = read_text(folder_ / name);
    write_text(folder_ / name, all.substr(0, all.size() / 2));
    EXPECT_THAT(refusal(folder_ / name), HasSubstr(name));
  }
}

TEST_F(ImageFile, HeadersThatMeanNoPlaceAreRefusedOnOneLine) {
  // ITK aborts the process on a NIfTI affine that is not a number.
  write_image(oblique_image<float>(), folder_ / "a.nii");
  std::string bytes = read_text(folder_ / "a.nii");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t field : {80U, 256U, 268U, 280U, 324U}) {
    std::string changed = bytes;
    std::memcpy(changed.data() + field, &nan, sizeof nan);
    write_text(folder_ / "nan.nii", changed);
    EXPECT_THAT(refusal(folder_ / "nan.nii"), HasSubstr("not a finite number")) << field;
  }
  const auto nrrd = [&](const std::string& directions) {
    write_text(folder_ / "a.nrrd",
               "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\n"
               "sizes: 2 2 2\nspace directions: " +
                   directions +
                   "\nkinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n\n" +
                   std::string(8, '\1'));
    return refusal(folder_ / "a.nrrd");
  };
  EXPECT_EQ(nrrd("(1,0,0) (0,1,0) (0,0,1)"), "accepted");
  EXPECT_THAT(nrrd("(1,0.1,0) (0,1,0) (0,0,1)"), HasSubstr("not perpendicular"));
  EXPECT_THAT(nrrd("(0.001,0,0) (0,0.001,0) (0,0,0.003)"), HasSubstr("0.001 x 0.001 x 0.003 mm"));
  EXPECT_THAT(nrrd("(0,0,0) (0,1,0) (0,0,1)"), HasSubstr("a.nrrd"));
}

/// Bytes of `file` with numbers put at places of its NIfTI-1 header (nifti1.h).
template <class T>
void put(const fs::path& file, std::size_t at, T value) {
  std::string bytes = read_text(file);
  std::memcpy(bytes.data() + at, &value, sizeof value);
  write_text(file, bytes);
}

TEST_F(ImageFile, APlaceThatIsNotSaidOrSaidTwiceIsRefused) {
  const fs::path file = folder_ / "a.nii";
  const auto fresh = [&] {
    write_image(oblique_image<float>(), file);
  };
  fresh();
  put<std::int16_t>(file, 252, 0);  // qform_code
  EXPECT_EQ(refusal(file), "accepted");
  put<std::int16_t>(file, 254, 0);  // sform_code
  EXPECT_THAT(refusal(file), HasSubstr("which side is the patient's left"));
  fresh();
  put<float>(file, 268, 170.5F);  // qoffset_x: 120.5 in RAS
  EXPECT_THAT(refusal(file), HasSubstr("qform and sform) differ by 50 mm"));
  fresh();
  put<float>(file, 76, 1.0F);
  put<float>(file, 288, 1.0F);  // a sheared sform
  EXPECT_THAT(refusal(file), HasSubstr("not perpendicular"));
  fresh();
  put<std::int8_t>(file, 123, 1);
  EXPECT_THAT(refusal(file), HasSubstr("lengths are in metres"));
  const auto nrrd = [&](const std::string& place) {
    write_text(folder_ / "a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\n" + place +
                                       "sizes: 2 2 2\nencoding: raw\n\n" + std::string(8, '\1'));
    return refusal(folder_ / "a.nrrd");
  };
  const std::string directions = "space directions: (1,0,0) (0,1,0) (0,0,1)\n";
  EXPECT_EQ(nrrd("space: RAS\n" + directions), "accepted");
  EXPECT_THAT(nrrd("space dimension: 3\n" + directions), HasSubstr("patient's left"));
  EXPECT_THAT(nrrd("space: scanner-xyz\n" + directions), HasSubstr("patient's left"));
  EXPECT_THAT(nrrd(""), HasSubstr("patient's left"));
  EXPECT_THAT(nrrd("space: LPS\n" + directions + "space units: \"m\" \"m\" \"m\"\n"),
              HasSubstr("millimetres"));
}

// ITK calls a rescaled image of shorts one of doubles, of which the file seems to hold a quarter.
TEST_F(ImageFile, NiftiIsRescaled) {
  const fs::path file = folder_ / "a.nii";
  write_image(oblique_image<float>(), file);  // whole numbers: as shorts
  put<float>(file, 112, -2.0F);
  put<float>(file, 116, 500.0F);
  const Image3<float> image = read_image(file);
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    EXPECT_EQ(image.voxels[v], 500.0F - 2.0F * oblique_image<float>().voxels[v]);
  }
}

TEST_F(ImageFile, ReadsADevelopmentPatientInBothFormats) {
  SANATRIX_REQUIRE_SHARED("data/dev01/labels_mri.nrrd");
  const LabelImage nrrd = read_labels(shared_file);
  const LabelImage nifti = read_labels(shared_file.parent_path() / "labels_mri.nii.gz");
  EXPECT_EQ(nrrd.size, (std::array<int, 3>{574, 368, 58}));
  EXPECT_TRUE(nrrd.voxels == nifti.voxels);
  EXPECT_NEAR(norm(nrrd.position_mm(573, 367, 57) - nifti.position_mm(573, 367, 57)), 0.0, 1e-3);
  // DATA.md: the tumour of this patient lies here (LPS).
  const Vec3 at = nrrd.continuous_index({94.16, -30.93, 6.31});
  const auto nearest = [](double x) {
    return static_cast<int>(std::lround(x));
  };
  EXPECT_EQ(nrrd.at(nearest(at[0]), nearest(at[1]), nearest(at[2])),
            static_cast<unsigned char>(Label::Tumour));
}

}  // namespace
}  // namespace sanatrix::io
