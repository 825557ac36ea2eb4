// Step B for given labels: read, check, resample, and find the breasts.
#include "imaging/segmentation.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/image_filters.hpp"
#include "imaging/automatic.hpp"
#include "imaging/landmarks.hpp"
#include "imaging/presets.hpp"
#include "imaging/resample.hpp"
#include "imaging/skin_landmarks.hpp"
#include "io/image_file.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double sure_nipple = 0.4;         ///< confidence; 25 mm of flat skin around it
constexpr double most_slice_gap_mm = 12.0;  ///< of images; the import warns above 6

template <class T>
void check_grid(const Image3<T>& image, double spacing_mm, double most_mm = 6.0) {
  require(spacing_mm >= 0.5 && spacing_mm <= 4.0, "the grid spacing must be 0.5 to 4 mm, not {} mm",
          spacing_mm);
  for (std::size_t a = 0; a < 3; ++a) {
    const double h = image.spacing_mm[a];
    if (!(h >= 0.2 && h <= most_mm)) {
      throw Error(
          Fault::Input,
          fmt::format("voxel spacing {:g} x {:g} x {:g} mm is outside 0.2 to {:g} mm",
                      image.spacing_mm[0], image.spacing_mm[1], image.spacing_mm[2], most_mm),
          "the file's spacing must be in millimetres; correct its header");
    }
    const double extent = image.size[a] * h;
    if (extent < 60.0 || extent > 1000.0) {
      throw Error(Fault::Input,
                  fmt::format("the image is {:.0f} mm wide along its axis {}; both breasts and the "
                              "chest wall need 60 to 1000 mm",
                              extent, a + 1),
                  "check that the file's spacing is in millimetres");
    }
  }
  require(std::abs(std::abs(determinant(image.direction)) - 1.0) < 1e-2,
          "the axes of the image are not at right angles; resample it to a regular grid first");
}

void check_table(const LabelImage& image, const LabelTable& table) {
  const auto highest = *std::max_element(image.voxels.begin(), image.voxels.end());
  if (highest >= table.tissue.size()) {
    throw Error(Fault::Input,
                fmt::format("label {} is not in the table of preset '{}' (0 to {})", highest,
                            table.name, table.tissue.size() - 1),
                "choose the preset that made this file (sanatrix or pelicano)");
  }
}

double volume_cm3(const LabelImage& labels, bool (*belongs)(unsigned char)) {
  return static_cast<double>(std::count_if(labels.voxels.begin(), labels.voxels.end(), belongs)) *
         labels.voxel_volume_mm3() * 1e-3;
}

void check_tissues(const LabelImage& labels) {
  const double wall = volume_cm3(labels, is_wall);
  if (wall < 10.0) {
    throw Error(
        Fault::Input,
        fmt::format("no chest wall: muscle, bone, lung and organ labels fill only {:.1f} cm3",
                    wall),
        "label the chest wall (4 to 7 in the sanatrix table), or choose another preset");
  }
  const double soft = volume_cm3(labels, is_soft);
  if (soft < 100.0) {
    throw Error(Fault::Input,
                fmt::format("no breast: soft-tissue labels fill only {:.1f} cm3", soft),
                "label skin, adipose and fibroglandular tissue of both breasts");
  }
}

/// Keeps the largest part of the body; specks of noise in the air go.
void keep_one_body(TissueGrid& grid, std::vector<std::string>& warnings) {
  Mask body = image_like<unsigned char>(grid.labels);
  for (std::size_t i = 0; i < body.voxels.size(); ++i) {
    body.voxels[i] = grid.labels.voxels[i] != 0 ? 1 : 0;
  }
  const Parts parts = connected_parts(body);
  if (parts.voxels.size() > 1 && parts.voxels[1] > parts.voxels[0] / 10) {
    throw Error(Fault::Input,
                fmt::format("the body is in {} separate pieces, the second with {:.0f} % of the "
                            "first one's volume",
                            parts.voxels.size(),
                            100.0 * static_cast<double>(parts.voxels[1]) /
                                static_cast<double>(parts.voxels[0])),
                "both breasts must hang on one labelled chest; check the frames of the image");
  }
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < body.voxels.size(); ++i) {
    if (parts.part[i] > 0) {
      grid.labels.voxels[i] = 0;
      grid.fibroglandular.voxels[i] = 0.0F;
      ++dropped;
    }
  }
  const double cm3 = static_cast<double>(dropped) * grid.labels.voxel_volume_mm3() * 1e-3;
  if (cm3 > 1.0) {
    warnings.push_back(fmt::format("{:.1f} cm3 of labels apart from the body are ignored", cm3));
  }
}

/// Soft tissue must come before the wall where both are in one column. It may come again behind it:
/// labels of a whole trunk have a back.
void check_facing(const LabelImage& labels) {
  double in_front = 0.0;
  double columns = 0.0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = 0; i < labels.size[0]; ++i) {
      int soft = labels.size[1], wall = labels.size[1];
      for (int j = labels.size[1] - 1; j >= 0; --j) {
        if (labels.at(i, j, k) != 0) {
          (is_wall(labels.at(i, j, k)) ? wall : soft) = j;
        }
      }
      if (soft < labels.size[1] && wall < labels.size[1]) {
        columns += 1.0;
        in_front += soft < wall ? 1.0 : 0.0;
      }
    }
  }
  if (in_front < 0.5 * columns) {
    throw Error(
        Fault::Input,
        "anterior and posterior are swapped: the chest wall lies in front (-y) of the breasts",
        "correct the orientation in the file's header; breasts must hang towards anterior");
  }
}

/// Lungs lie above the liver. Only told when both are labelled well.
void check_upright(const LabelImage& labels) {
  std::array<double, 2> sum{};
  std::array<double, 2> count{};
  std::size_t voxel = 0;
  const auto slice =
      static_cast<std::size_t>(labels.size[0]) * static_cast<std::size_t>(labels.size[1]);
  for (; voxel < labels.voxels.size(); ++voxel) {
    const auto label = static_cast<Label>(labels.voxels[voxel]);
    if (label == Label::Lung || label == Label::Organ) {
      const std::size_t which = label == Label::Lung ? 0 : 1;
      const std::size_t k = voxel / slice;
      sum[which] += static_cast<double>(k);
      count[which] += 1.0;
    }
  }
  const double enough = 100e3 / labels.voxel_volume_mm3();
  if (count[0] < enough || count[1] < enough) {
    return;
  }
  const double lung_above_mm = (sum[0] / count[0] - sum[1] / count[1]) * labels.spacing_mm[2];
  // Heart and lung share their height, so only a clear inversion counts.
  if (lung_above_mm < -15.0) {
    throw Error(Fault::Input,
                fmt::format("superior and inferior are swapped: the lung lies {:.0f} mm below the "
                            "heart and liver",
                            -lung_above_mm),
                "correct the orientation in the file's header");
  }
}

/// Cuts a grid to the slices within half_height of z.
template <class T>
void crop_height(Image3<T>& image, double z_mm, double half_height_mm) {
  const double c = image.continuous_index({0, 0, z_mm})[2];
  const double reach = half_height_mm / image.spacing_mm[2];
  const int first = std::max(0, static_cast<int>(std::ceil(c - reach)));
  const int last = std::min(image.size[2] - 1, static_cast<int>(std::floor(c + reach)));
  const auto slice = static_cast<long>(image.size[0]) * image.size[1];
  image.voxels.erase(image.voxels.begin() + slice * (last + 1), image.voxels.end());
  image.voxels.erase(image.voxels.begin(), image.voxels.begin() + slice * first);
  image.origin_mm = image.position_mm(0, 0, first);
  image.size[2] = last - first + 1;
}

/// Behind the chest-wall sheet "background" means the inside of the thorax.
void fill_thorax(LabelImage& labels) {
  Mask wall = image_like<unsigned char>(labels);
  for (std::size_t i = 0; i < wall.voxels.size(); ++i) {
    wall.voxels[i] = is_wall(labels.voxels[i]) ? 1 : 0;
  }
  const Parts parts = connected_parts(wall);
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = 0; i < labels.size[0]; ++i) {
      bool behind = false;
      for (int j = 0; j < labels.size[1]; ++j) {
        const std::size_t voxel = labels.index(i, j, k);
        behind = behind || parts.part[voxel] == 0;
        if (behind && labels.voxels[voxel] == 0) {
          labels.voxels[voxel] = static_cast<unsigned char>(Label::Organ);
        }
      }
    }
  }
}

/// Checks resampled tissues and finds the landmarks.
Segmentation finish(TissueGrid grid, const LabelTable& table, const Context& ctx) {
  Segmentation result;
  check_tissues(grid.labels);
  keep_one_body(grid, result.warnings);
  check_facing(grid.labels);
  ctx.at(0.8, "landmarks");
  if (table.half_height_mm > 0.0) {
    const Landmarks marks = find_landmarks(grid.labels);
    const double z = 0.5 * (marks.nipple_mm[0][2] + marks.nipple_mm[1][2]);
    crop_height(grid.labels, z, table.half_height_mm);
    crop_height(grid.fibroglandular, z, table.half_height_mm);
  }
  if (table.sheet_only) {
    fill_thorax(grid.labels);
  } else {
    check_upright(grid.labels);
  }
  const Landmarks marks = find_landmarks(grid.labels);
  result.nipple_mm = marks.nipple_mm;
  result.nipples_from_label = marks.nipples_from_label;
  result.midline_x_mm = marks.midline_x_mm;
  if (!marks.nipples_from_label) {
    result.warnings.emplace_back("no nipple labels: the most anterior skin points are used");
  }
  result.labels = std::move(grid.labels);
  result.fibroglandular = std::move(grid.fibroglandular);
  return result;
}

Segmentation segment(const LabelImage& source, const LabelTable& table, double spacing_mm,
                     const Context& ctx) {
  check_grid(source, spacing_mm);
  check_table(source, table);
  return finish(resample_to_lps(source, table, spacing_mm, ctx.part(0.2, 0.8)), table, ctx);
}

void paint(const TumourSphere& tumour, LabelImage& labels) {
  const Vec3 at = labels.continuous_index(tumour.centre_mm);
  std::array<int, 3> c{};
  bool inside = true;
  for (std::size_t a = 0; a < 3; ++a) {
    c[a] = static_cast<int>(std::lround(at[a]));
    inside = inside && c[a] >= 0 && c[a] < labels.size[a];
  }
  if (!inside || !is_soft(labels.at(c[0], c[1], c[2]))) {
    throw Error(Fault::Input,
                fmt::format("the tumour at LPS {:.1f}, {:.1f}, {:.1f} mm does not lie in the soft "
                            "tissue of the image",
                            tumour.centre_mm[0], tumour.centre_mm[1], tumour.centre_mm[2]),
                "check that plan and image are of the same examination and frame of reference");
  }
  const int reach = static_cast<int>(std::ceil(tumour.radius_mm / labels.spacing_mm[0]));
  for (int k = std::max(0, c[2] - reach); k <= std::min(labels.size[2] - 1, c[2] + reach); ++k) {
    for (int j = std::max(0, c[1] - reach); j <= std::min(labels.size[1] - 1, c[1] + reach); ++j) {
      for (int i = std::max(0, c[0] - reach); i <= std::min(labels.size[0] - 1, c[0] + reach);
           ++i) {
        unsigned char& label = labels.at(i, j, k);
        if (is_soft(label) && label != static_cast<unsigned char>(Label::Skin) &&
            norm(labels.position_mm(i, j, k) - tumour.centre_mm) <= tumour.radius_mm) {
          label = static_cast<unsigned char>(Label::Tumour);
        }
      }
    }
  }
}

}  // namespace

ImageSegmentation segment_image(const Image3<float>& image, double spacing_mm,
                                const std::optional<TumourSphere>& tumour, const Context& ctx) {
  check_grid(image, spacing_mm, most_slice_gap_mm);
  AutomaticLabels found = label_image(image, ctx.part(0.0, 0.6));
  ImageSegmentation result;
  result.quality = assess(found);
  TissueGrid grid = resample_to_lps(found.grid, 0.0, spacing_mm, ctx.part(0.6, 0.9));
  result.segmentation = finish(std::move(grid), label_table(LabelPreset::Sanatrix), ctx);
  if (tumour) {
    paint(*tumour, result.segmentation.labels);
  }
  assess(result.segmentation.labels, result.segmentation.midline_x_mm, result.quality);
  for (const std::string& doubt : result.quality.doubts) {
    result.segmentation.warnings.push_back(doubt);
  }
  for (const SkinLandmark& mark : skin_landmarks(result.segmentation)) {
    if (mark.name.starts_with("nipple") && mark.confidence < sure_nipple) {
      result.segmentation.warnings.push_back(fmt::format(
          "{} is uncertain (confidence {:.2f}): the skin around its most anterior point "
          "is flat; lengths from it are, too; label it and give the labels with --labels",
          mark.name, mark.confidence));
    }
  }
  if (!result.quality.defects.empty()) {
    throw Error(Fault::Input, "not usable because " + result.quality.defects.front(),
                "look at the images; give labels with --labels if they are right");
  }
  return result;
}

Segmentation segment_given_labels(const std::filesystem::path& file, LabelPreset preset,
                                  double spacing_mm, const Context& ctx) {
  ctx.at(0.0, "reading labels");
  const LabelImage source = io::read_labels(file);
  return during(file.filename().string(),
                [&] { return segment(source, label_table(preset), spacing_mm, ctx); });
}

}  // namespace sanatrix::imaging
