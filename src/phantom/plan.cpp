// Measures tumour, nipples and tissue volumes in the prone labels and lays the axis of the
// excision.
#include "phantom/plan.hpp"

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/error.hpp"

namespace sanatrix::phantom {
namespace {

using nlohmann::json;

constexpr double mm = 1e-3;
constexpr double margin_mm = 10.0;

struct Blob {
  Vec3 centre_mm{};
  std::size_t voxels = 0;
};

/// Centroid of a label on one side (or both, side 0).
Blob blob_of(const LabelImage& image, Label label, int side) {
  Blob blob;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        const Vec3 p = image.position_mm(i, j, k);
        if (image.at(i, j, k) == static_cast<unsigned char>(label) && side * p[0] >= 0.0) {
          blob.centre_mm += p;
          ++blob.voxels;
        }
      }
    }
  }
  ensure(blob.voxels > 0, "phantom: no voxel has label {}", static_cast<int>(label));
  blob.centre_mm = (1.0 / static_cast<double>(blob.voxels)) * blob.centre_mm;
  return blob;
}

double farthest_mm(const LabelImage& image, Label label, const Vec3& from_mm) {
  double farthest = 0.0;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        if (image.at(i, j, k) == static_cast<unsigned char>(label)) {
          farthest = std::max(farthest, norm(image.position_mm(i, j, k) - from_mm));
        }
      }
    }
  }
  return farthest;
}

bool is_air(const LabelImage& image, const Vec3& p_mm) {
  const Vec3 index = image.continuous_index(p_mm);
  std::array<int, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    at[i] = static_cast<int>(std::lround(index[i]));
    if (at[i] < 0 || at[i] >= image.size[i]) {
      return true;
    }
  }
  return image.at(at[0], at[1], at[2]) == 0;
}

/// With this many decimals, so that the file reads like a measurement.
double rounded(double x, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(x * scale) / scale;
}

json rounded(const Vec3& p, int decimals) {
  return {rounded(p[0], decimals), rounded(p[1], decimals), rounded(p[2], decimals)};
}

/// Soft tissue in front of the fascia, per side.
json tissue_volumes(const LabelImage& image) {
  json result;
  for (const int side : {1, -1}) {
    double soft = 0.0, gland = 0.0, fat = 0.0;
    const double voxel_cm3 = image.voxel_volume_mm3() * 1e-3;
    for (int i = 0; i < image.size[0]; ++i) {
      if (side * image.position_mm(i, 0, 0)[0] < 0.0) {
        continue;
      }
      for (int k = 0; k < image.size[2]; ++k) {
        for (int j = 0; j < image.size[1]; ++j) {
          const unsigned char label = image.at(i, j, k);
          soft += is_soft(label) ? voxel_cm3 : 0.0;
          gland += label == 2 ? voxel_cm3 : 0.0;
          fat += label == 1 ? voxel_cm3 : 0.0;
        }
      }
    }
    result[side > 0 ? "L" : "R"] = {{"soft_tissue_in_slab_cm3", rounded(soft, 1)},
                                    {"fgt_cm3", rounded(gland, 1)},
                                    {"adipose_front_cm3", rounded(fat, 1)}};
  }
  return result;
}

std::string quadrant(const Vec3& from_nipple_mm, int side) {
  return std::string(from_nipple_mm[2] > 0.0 ? "upper " : "lower ") +
         (side * from_nipple_mm[0] > 0.0 ? "outer" : "inner");
}

}  // namespace

std::string plan_json(const LabelImage& labels, const Anatomy& anatomy, const std::string& name) {
  const Blob tumour = blob_of(labels, Label::Tumour, 0);
  const int side = tumour.centre_mm[0] > 0.0 ? 1 : -1;
  const Vec3 nipple_r = blob_of(labels, Label::Nipple, -1).centre_mm;
  const Vec3 nipple_l = blob_of(labels, Label::Nipple, 1).centre_mm;
  const double volume_mm3 = static_cast<double>(tumour.voxels) * labels.voxel_volume_mm3();
  const double radius_mm = std::cbrt(volume_mm3 * 3.0 / (4.0 * std::numbers::pi));

  // The chest wall does not move, so its normal at the tumour's foot is that of the design.
  const ChestPlace place = anatomy.thorax().locate(mm * tumour.centre_mm);
  const Vec3 foot_mm = (1.0 / mm) * anatomy.thorax().point({place.s, place.z, 0.0});
  const Vec3 axis = anatomy.thorax().normal(place.s);
  double to_skin_mm = 0.0;
  while (!is_air(labels, tumour.centre_mm + to_skin_mm * axis)) {
    to_skin_mm += 0.1;
  }
  json plan;
  plan["patient"] = name;
  plan["coordinates"] = "LPS mm, DICOM patient frame, PRONE configuration";
  plan["frame"] = "prone";
  plan["anatomy_source"] = "built-in phantom of Sanatrix";
  plan["operated_side"] = side > 0 ? "L" : "R";
  plan["quadrant"] = quadrant(tumour.centre_mm - (side > 0 ? nipple_l : nipple_r), side);
  plan["tumour"] = {
      {"centre_lps_mm", rounded(tumour.centre_mm, 2)},
      {"equivalent_radius_mm", rounded(radius_mm, 2)},
      {"max_radius_mm", rounded(farthest_mm(labels, Label::Tumour, tumour.centre_mm), 2)},
      {"volume_cm3", rounded(volume_mm3 * 1e-3, 3)},
      {"label", 8}};
  plan["planned_margin_mm"] = margin_mm;
  plan["resection"] = {
      {"shape", "cylinder, axis = chest-wall normal through tumour centre, from skin to fascia"},
      {"axis_towards_skin_lps", rounded(axis, 4)},
      {"radius_mm", rounded(radius_mm + margin_mm, 1)},
      {"chest_wall_point_lps_mm", rounded(foot_mm, 1)},
      {"skin_entry_point_lps_mm", rounded(tumour.centre_mm + to_skin_mm * axis, 1)},
      {"distance_skin_mm", rounded(to_skin_mm, 1)},
      {"distance_chest_wall_mm", rounded(place.t / mm, 1)}};
  plan["nipple_lps_mm"] = {{"R", rounded(nipple_r, 1)}, {"L", rounded(nipple_l, 1)}};
  plan["midline_x_mm"] = 0.0;
  plan["nipple_note"] = "centroid of the nipple label";
  plan["tissue_volumes"] = tissue_volumes(labels);
  plan["gravity_prone_lps"] = {0, -1, 0};
  plan["gravity_supine_lps"] = {0, 1, 0};
  plan["gravity_upright_lps"] = {0, 0, -1};
  return plan.dump(1) + "\n";
}

}  // namespace sanatrix::phantom
