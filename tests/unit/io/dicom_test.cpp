// DICOM: stacks from loose slices, and damaged files that never harm the program.
#include "io/dicom.hpp"

#include <cstdlib>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/series_words.hpp"
#include "own_folder.hpp"
#include "shared_data.hpp"

namespace sanatrix::io {
namespace {

using ::testing::HasSubstr;

/// Twenty slices, 4 mm apart, 150 x 90 voxels of 2 mm, turned about the x axis by `tilt`.
std::vector<DicomSlice> stack(double tilt = 0.0) {
  std::vector<DicomSlice> slices;
  for (int k = 0; k < 24; ++k) {
    DicomSlice s;
    s.file = k;
    s.instance_number = 24 - k;
    s.size = {150, 90};
    s.row = {1, 0, 0};
    s.column = {0, std::cos(tilt), std::sin(tilt)};
    s.position_mm = Vec3{-150, -60, 10} + (4.0 * k) * cross(s.row, s.column);
    s.pixel_mm = {2, 2};
    s.thickness_mm = 4.0;
    s.has_geometry = true;
    s.acquisition.modality.letters = {'M', 'R'};
    s.acquisition.weighting = Weighting::T1;
    slices.push_back(s);
  }
  return slices;
}

TEST(Dicom, SlicesInAnyOrderGiveTheSameVolumeAndObliqueOnesStayOblique) {
  const double tilt = 0.3;
  std::vector<DicomSlice> slices = stack(tilt);
  std::shuffle(slices.begin(), slices.end(), std::mt19937(3));
  const std::vector<DicomVolume> volumes = assemble_volumes(slices);
  ASSERT_EQ(volumes.size(), 1U);
  const DicomVolume& v = volumes[0];
  EXPECT_EQ(v.defect, "");
  EXPECT_EQ(v.unfit, "");
  EXPECT_EQ(v.plane(), "oblique axial");
  EXPECT_NEAR(v.spacing_mm[2], 4.0, 1e-9);
  EXPECT_EQ(v.origin_mm, (Vec3{-150, -60, 10}));
  EXPECT_NEAR(v.direction[1][2], -std::sin(tilt), 1e-12);  // third column: the normal
  EXPECT_NEAR(v.direction[2][2], std::cos(tilt), 1e-12);
  for (int k = 0; k < 24; ++k) {
    EXPECT_EQ(v.slices[static_cast<std::size_t>(k)].file, k);
  }
}

TEST(Dicom, WhatIsNoEvenStackSaysWhy) {
  std::vector<DicomSlice> missing = stack();
  missing.erase(missing.begin() + 7, missing.begin() + 9);
  EXPECT_THAT(assemble_volumes(missing)[0].defect, HasSubstr("2 slice(s) are missing"));
  std::vector<DicomSlice> twice = stack();
  twice.push_back(twice[5]);
  EXPECT_THAT(assemble_volumes(twice)[0].defect, HasSubstr("same position"));
  std::vector<DicomSlice> uneven = stack();
  uneven[5].position_mm[2] += 1.4;
  EXPECT_THAT(assemble_volumes(uneven)[0].defect, HasSubstr("not evenly spaced"));
  std::vector<DicomSlice> sheared = stack();
  for (std::size_t k = 0; k < sheared.size(); ++k) {
    sheared[k].position_mm[1] += 0.2 * static_cast<double>(k);
  }
  EXPECT_THAT(assemble_volumes(sheared)[0].defect, HasSubstr("sideways"));
  std::vector<DicomSlice> aside = stack();
  aside[5].position_mm[0] += 20.0;
  EXPECT_THAT(assemble_volumes(aside)[0].defect, HasSubstr("sideways"));
  std::vector<DicomSlice> skewed = stack();
  skewed[3].column = {0.5, 0.8, 0};
  EXPECT_THAT(assemble_volumes(skewed)[0].defect, HasSubstr("another orientation"));
}

TEST(Dicom, OnlyProneSeriesOfOnePatientAreChosen) {
  std::vector<DicomSlice> slices = stack();
  for (DicomSlice& s : slices) {
    s.acquisition.patient_position.letters = {'H', 'F', 'D', 'R'};
  }
  EXPECT_THAT(assemble_volumes(slices)[0].unfit, HasSubstr("position is HFDR"));
  DicomFolder folder{.files = {}, .volumes = assemble_volumes(stack())};
  EXPECT_EQ(choose_volume(folder, 0).index, 1);
  for (DicomSlice& s : slices) {
    s.patient = 1;  // not even as a series that would not be chosen
  }
  folder.volumes.push_back(assemble_volumes(slices)[0]);
  folder.volumes[1].index = 2;
  try {
    choose_volume(folder, 0);
    ADD_FAILURE() << "one of two patients was chosen";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("series 1 and 2 are of different patients"));
  }
  EXPECT_EQ(choose_volume(folder, 1).index, 1);
}

TEST(Dicom, NamesOfSeriesSayWhatTheyAre) {
  for (const char* name : {"T1 FAT-SAT", "AX T1 FatSupp", "t1_tse_tra_fs", "T1FS", "t2_tirm_tra",
                           "T2 STIR", "eTHRIVE", "ax SPAIR"}) {
    EXPECT_TRUE(names_fat_suppression(name)) << name;
  }
  for (const char* name : {"t1 fl3d tra non-fatsat", "T1 no fs", "t1_tse_nonfs", "t1 w/o fat sat",
                           "ax t1 without FS", "ax t1 tse", "T1 inspiration"}) {
    EXPECT_FALSE(names_fat_suppression(name)) << name;
  }
  for (const char* name : {"SUB_1", "subtraction 2-1", "MIP cor", "ep2d_diff_b50", "ADC",
                           "t1_dixon_tra_W", "t1 dixon opp"}) {
    EXPECT_TRUE(names_computed_image(name)) << name;
  }
  for (const char* name : {"ax t1 tse", "T1 DIXON in phase", "t1_fl3d_tra", "T2 TSE bilateral"}) {
    EXPECT_FALSE(names_computed_image(name)) << name;
  }
}

/// Bytes changed, lengths made huge, parts cut out, doubled or cut off.
std::string mutated(std::string data, unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random()) % n;
  };
  for (std::size_t n = 1 + below(8); n > 0; --n) {
    const std::size_t at = 132 + below(std::min<std::size_t>(data.size(), 2200) - 140);
    switch (below(4)) {
      case 0:
        data[at] = static_cast<char>(random());
        break;
      case 1:
        data.replace(at, 4, below(2) == 0 ? "\xff\xff\xff\x7f" : "\xff\xff\xff\xff");
        break;
      case 2:
        data.erase(at, 1 + below(40));
        break;
      default:
        data.insert(at, data.substr(at, 1 + below(200)));
    }
  }
  if (seed % 10 == 0) {
    data.resize(140 + below(data.size() - 140));
  }
  return data;
}

TEST(Dicom, DamagedFilesAreReadOrRefusedAndNeverHarmTheProgram) {
  SANATRIX_REQUIRE_SHARED("data/dev02/dicom");
  std::filesystem::path source;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_file)) {
    if (entry.is_regular_file() && entry.path().string().find("t2") != std::string::npos) {
      source = entry.path();
    }
  }
  const std::string whole = read_text(source);
  const std::filesystem::path file = testing::own_folder() / "slice.dcm";
  const char* count = std::getenv("SANATRIX_MUTATIONS");  // 1000 by hand, fewer in every run
  int read = 0, refused = 0;
  for (unsigned seed = 1; seed <= (count != nullptr ? std::stoul(count) : 60U); ++seed) {
    std::ofstream(file, std::ios::binary) << mutated(whole, seed);
    try {
      const DicomFolder folder = scan_dicom(file);
      read_dicom(folder, folder.volumes.front());
      ++read;
    } catch (const Error& e) {
      ++refused;
      EXPECT_TRUE(e.fault() == Fault::Input || e.fault() == Fault::Resource)
          << seed << ": " << e.one_line();
    }
  }
  std::printf("damaged files: %d read, %d refused\n", read, refused);
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace sanatrix::io
