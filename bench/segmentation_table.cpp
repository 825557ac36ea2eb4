// How well the automatic segmentation does over anatomies, contrasts and image faults: one row of a
// table per case, in Markdown on stdout: docs/theory/segmentation-table.md is what it prints.
// Seconds go to stderr. Needs the shared development data (SANATRIX_SHARED).
//   segmentation_table [--only PART-OF-NAME ...] [--save DIR]
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <sys/resource.h>

#include "geometry/image_filters.hpp"
#include "imaging/agreement.hpp"
#include "imaging/automatic.hpp"
#include "imaging/grids.hpp"
#include "imaging/landmarks.hpp"
#include "imaging/quality.hpp"
#include "imaging/segmentation.hpp"
#include "io/image_file.hpp"
#include "synthetic_mri.hpp"

namespace sanatrix {
namespace {

using testing::Anatomy;
using testing::Scanner;
using testing::SyntheticMri;

std::filesystem::path data() {
  const char* given = std::getenv("SANATRIX_SHARED");
  return std::filesystem::path(given != nullptr ? given : "../shared") / "data";
}

Anatomy solid_anatomy(const std::filesystem::path& file) {
  Image3<float> numbers = imaging::in_lps_order(io::read_image(file));
  Anatomy body{image_like<unsigned char>(numbers), image_like<float>(numbers)};
  for (std::size_t v = 0; v < numbers.voxels.size(); ++v) {
    body.labels.voxels[v] = static_cast<unsigned char>(numbers.voxels[v]);
    const auto label = static_cast<Label>(body.labels.voxels[v]);
    body.water.voxels[v] = label == Label::Fibroglandular || label == Label::Nipple ? 1.0F : 0.0F;
  }
  return body;
}

struct Case {
  std::string name;
  std::function<SyntheticMri()> make;
};

void multiply(Image3<float>& image, const testing::Coil& coil) {
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        image.at(i, j, k) *= static_cast<float>(testing::sensitivity(
            coil, {(i + 0.5) / image.size[0], (j + 0.5) / image.size[1], (k + 0.5) / image.size[2]},
            {i * image.spacing_mm[0], j * image.spacing_mm[1], k * image.spacing_mm[2]}, 0.0));
      }
    }
  }
}

/// The development patients' own images, as they are and made worse.
void add_given(std::vector<Case>& cases) {
  struct Given {
    const char *name, *image, *truth;
  };
  for (const Given& g : {Given{"dev01 T1", "dev01/t1.nii.gz", "dev01/labels_mri.nii.gz"},
                         Given{"dev01 T2", "dev01/t2.nii.gz", "dev01/labels_mri.nii.gz"},
                         Given{"dev02 T1", "dev02/t1.nii.gz", "dev02/labels_mri.nii.gz"},
                         Given{"dev02 T2", "dev02/t2.nrrd", "dev02/labels_mri.nii.gz"}}) {
    const auto add = [&](const char* change, const std::function<void(SyntheticMri&)>& apply) {
      cases.push_back(
          {fmt::format("{}, {}", g.name, change), [g, apply] {
             SyntheticMri mri{io::read_image(data() / g.image), io::read_labels(data() / g.truth)};
             apply(mri);
             return mri;
           }});
    };
    add("as given", [](SyntheticMri&) {});
    // sqrt(3) of noise on top doubles it: 260 / 42 in T1 and 260 / 36 in T2 are there.
    const double more = std::sqrt(3.0) * 260.0 / (std::string(g.name).ends_with("1") ? 42.0 : 36.0);
    add("noise doubled", [more](SyntheticMri& m) { testing::add_rician_noise(m.image, more); });
    add("shading doubled", [](SyntheticMri& m) {
      multiply(m.image, {.decay_mm = 110.0, .floor = 0.0, .side_tilt = 0.25, .hot_spots = 0.0});
    });
    add("left and right apart", [](SyntheticMri& m) {
      multiply(m.image, {.decay_mm = 1e6, .side_tilt = 0.5, .end_fall = 0.0, .hot_spots = 0.0});
    });
    add("one breast larger", [](SyntheticMri& m) {
      m.image = testing::stretched(m.image, 1.0, 1.3);
      m.truth = testing::stretched(m.truth, 1.0, 1.3);
      testing::add_rician_noise(m.image, 0.0);
    });
  }
}

using Change = std::function<void(Anatomy&, testing::Contrast&, Scanner&)>;

const std::vector<std::pair<std::string, Change>>& changes() {
  static const std::vector<std::pair<std::string, Change>> all{
      {"nominal",
       [](Anatomy&, testing::Contrast&, Scanner&) {
       }},
      {"noise doubled",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.noise *= 2.0;
       }},
      {"shading doubled",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.coil.power = 2.0;
       }},
      {"surface coil",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.coil.decay_mm = 45.0;
         s.coil.floor = 0.2;
       }},
      {"left and right apart",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.coil.side_tilt = 0.5;
       }},
      {"top and bottom apart",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.coil.end_tilt = 0.5;
       }},
      {"one breast larger",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         a.labels = testing::stretched(a.labels, 1.0, 1.3);
         a.water = testing::stretched(a.water, 1.0, 1.3);
       }},
      {"small breasts",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         a.labels = testing::stretched(a.labels, 0.75, 0.75);
         a.water = testing::stretched(a.water, 0.75, 0.75);
       }},
      {"0.55 mm pixels",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.pixel_mm = 0.55;
       }},
      {"1.4 x 4 mm voxels",
       [](Anatomy&, testing::Contrast&, Scanner& s) {
         s.pixel_mm = 1.4;
         s.slice = 4;
       }},
      {"pale muscle",
       [](Anatomy&, testing::Contrast& c, Scanner&) {
         c.muscle = 0.38;
       }},
      {"pressed flat",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         a = testing::pressed(a, 15.0);
       }},
      {"whole trunk",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         a = testing::with_back_of_trunk(a, testing::Back::Round);
       }},
      {"trunk as wide as the field",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         a = testing::with_back_of_trunk(a, testing::Back::AsWideAsTheField);
       }},
      {"fatty",
       [](Anatomy& a, testing::Contrast&, Scanner&) {
         testing::make_fatty(a);
       }},
      {"dense", [](Anatomy& a, testing::Contrast&, Scanner&) {
         testing::make_dense(a);
       }}};
  return all;
}

void add_synthetic(std::vector<Case>& cases) {
  for (const char* name : {"Exam_06", "Exam_15", "Exam_25", "dev02"}) {
    for (const bool t2 : {false, true}) {
      for (const auto& [change, apply] : changes()) {
        if (std::string(name) == "dev02" && (change == "fatty" || change == "dense")) {
          continue;
        }
        cases.push_back(
            {fmt::format("{} T{}, {}", name, t2 ? 2 : 1, change), [name, t2, apply] {
               Anatomy body = std::string(name) == "dev02"
                                  ? solid_anatomy(data() / "dev02/labels_1mm.nii.gz")
                                  : testing::real_anatomy(data() / "real_prone_labels" /
                                                          (std::string(name) + "_detailed.nii.gz"));
               testing::Contrast contrast = t2 ? testing::t2_contrast : testing::t1_contrast;
               Scanner scanner;
               scanner.noise = t2 ? 7.2 : 6.2;
               apply(body, contrast, scanner);
               return testing::synthetic_mri(body, contrast, scanner);
             }});
        if (std::string(name) == "dev02") {
          cases.back().name.insert(6, "labels ");
        }
      }
    }
  }
}

double user_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

double nipple_error_mm(const LabelImage& found, const LabelImage& truth) {
  const auto a = imaging::find_landmarks(found), b = imaging::find_landmarks(truth);
  return std::max(norm(a.nipple_mm[0] - b.nipple_mm[0]), norm(a.nipple_mm[1] - b.nipple_mm[1]));
}

void measure(const Case& one, const std::string& save) {
  const SyntheticMri mri = one.make();
  if (!save.empty()) {
    io::write_image(mri.image, std::filesystem::path(save) / (one.name + " image.nii.gz"));
    io::write_labels(mri.truth, std::filesystem::path(save) / (one.name + " truth.nii.gz"));
  }
  Silent silent;
  const double start = user_seconds();
  std::string row = fmt::format("| {} |", one.name);
  try {
    const imaging::AutomaticLabels found =
        imaging::label_image(mri.image, Context("segment", silent));
    fmt::print(stderr, "{}: {:.0f} user s\n", one.name, user_seconds() - start);
    const imaging::Agreement a = imaging::compare_labels(found.grid.labels, mri.truth);
    const imaging::Quality quality = imaging::assess(found);
    row += fmt::format(" {:.3f} | {:.3f} | {:+.0f} % | {:.1f}, {:.1f} | {:.2f} | {:.1f} | {} |",
                       a.soft_dice, a.glandular_dice, a.glandular_volume_percent,
                       a.chest_wall.mean_mm, a.chest_wall.p95_mm, a.skin.mean_mm,
                       nipple_error_mm(found.grid.labels, mri.truth),
                       !quality.defects.empty()  ? "refused: " + quality.defects.front()
                       : !quality.doubts.empty() ? "doubted: " + quality.doubts.front()
                                                 : "");
    if (!save.empty()) {
      io::write_labels(found.grid.labels,
                       std::filesystem::path(save) / (one.name + " found.nii.gz"));
      io::write_image(found.relative,
                      std::filesystem::path(save) / (one.name + " relative.nii.gz"));
    }
  } catch (const std::exception& error) {
    row += fmt::format(" refused: {} |", error.what());
  }
  fmt::print("{}\n", row);
  std::fflush(stdout);
}

}  // namespace
}  // namespace sanatrix

int main(int count, char** arguments) {
  std::vector<std::string> only;
  std::string save;
  for (int a = 1; a + 1 < count; a += 2) {
    (std::string(arguments[a]) == "--save" ? save : only.emplace_back()) = arguments[a + 1];
  }
  std::vector<sanatrix::Case> cases;
  sanatrix::add_given(cases);
  sanatrix::add_synthetic(cases);
  fmt::print(
      "| image | soft Dice | gland Dice | volume | wall mean, p95 (mm) | skin (mm) | nipple (mm) | "
      "quality |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const sanatrix::Case& one : cases) {
    const auto named = [&](const std::string& part) {
      return one.name.find(part) != std::string::npos;
    };
    if (only.empty() || std::ranges::any_of(only, named)) {
      sanatrix::measure(one, save);
    }
  }
  return 0;
}
