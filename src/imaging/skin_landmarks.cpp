// The front of the body as heights over a coronal plane: tips, the cleft, and the corner below.
#include "imaging/skin_landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "imaging/sternal_notch.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double sharp_tip_mm = 10.0;   ///< radius of the skin within 2 mm of a well-defined tip
constexpr double deep_cleft_mm = 40.0;  ///< a cleft this deep leaves no doubt of the midline
constexpr double deep_fold_mm = 12.0;   ///< of a clear inframammary fold, below its chord
constexpr double least_fold_mm = 2.0;   ///< less is an even slope

/// y of the most anterior body voxel of a column; nothing where there is no body.
std::optional<double> front_y(const LabelImage& labels, int i, int k) {
  for (int j = 0; j < labels.size[1]; ++j) {
    if (labels.at(i, j, k) != 0) {
      return labels.position_mm(i, j, k)[1];
    }
  }
  return std::nullopt;
}

std::array<int, 3> voxel_at(const LabelImage& labels, const Vec3& p_mm) {
  const Vec3 c = labels.continuous_index(p_mm);
  std::array<int, 3> at{};
  for (std::size_t a = 0; a < 3; ++a) {
    at[a] = std::clamp(static_cast<int>(std::lround(c[a])), 0, labels.size[a] - 1);
  }
  return at;
}

/// A flat tip may lie anywhere on it: the radius of the skin that is within 2 mm of it.
double confidence_of_tip(const LabelImage& labels, const Vec3& tip_mm) {
  constexpr double around_mm = 40.0;
  double area = 0.0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = 0; i < labels.size[0]; ++i) {
      const Vec3 p = labels.position_mm(i, 0, k);
      if (std::hypot(p[0] - tip_mm[0], p[2] - tip_mm[2]) < around_mm) {
        const auto y = front_y(labels, i, k);
        area += y && *y < tip_mm[1] + 2.0 ? labels.spacing_mm[0] * labels.spacing_mm[2] : 0.0;
      }
    }
  }
  return std::clamp(sharp_tip_mm / std::sqrt(std::max(area, 1.0) / std::numbers::pi), 0.0, 1.0);
}

/// Below the nipple the skin runs back and then down along the chest: the point that lies deepest
/// below the chord from the nipple to the chest well below the field, where the skin is taken to go
/// straight down. The field may end closely below the fold; if it ends above it the skin still runs
/// back there, and its end is the deepest point.
SkinLandmark fold_below(const LabelImage& labels, const Vec3& nipple_mm) {
  constexpr double beyond_mm =
      50.0;  ///< of the field: about as far as the nipple lies above a fold
  constexpr double sure_chest_mm = 12.0;  ///< of skin below the fold that leaves no doubt of it
  SkinLandmark fold;
  fold.missing = "the field ends above it, or the skin has no corner there";
  const auto at = voxel_at(labels, nipple_mm);
  int bottom = 0;
  while (bottom < at[2] && !front_y(labels, at[0], bottom)) {
    ++bottom;
  }
  const auto end = front_y(labels, at[0], bottom);
  const double end_z = labels.position_mm(at[0], 0, bottom)[2];
  if (!end || nipple_mm[2] - end_z < 20.0) {
    return fold;
  }
  const double slope = (*end - nipple_mm[1]) / (nipple_mm[2] - end_z + beyond_mm);
  const auto depth_at = [&](double y, double z) {
    return (y - nipple_mm[1] - slope * (nipple_mm[2] - z)) / std::hypot(1.0, slope);
  };
  double deepest = std::max(least_fold_mm, depth_at(*end, end_z));
  for (int k = bottom + 1; k < at[2]; ++k) {
    const auto y = front_y(labels, at[0], k);
    const Vec3 p = labels.position_mm(at[0], 0, k);
    if (y && depth_at(*y, p[2]) > deepest) {
      deepest = depth_at(*y, p[2]);
      fold.at_mm = {p[0], *y, p[2]};
    }
  }
  if (fold.at_mm) {
    fold.missing.clear();
    fold.confidence = std::min(1.0, deepest / deep_fold_mm) *
                      std::min(1.0, ((*fold.at_mm)[2] - end_z) / sure_chest_mm);
  }
  return fold;
}

}  // namespace

std::vector<SkinLandmark> skin_landmarks(const Segmentation& s) {
  std::vector<SkinLandmark> marks;
  constexpr std::array sides{"right", "left"};
  for (const std::size_t side : {0U, 1U}) {
    const double sure = s.nipples_from_label ? 1.0 : confidence_of_tip(s.labels, s.nipple_mm[side]);
    marks.push_back({std::string("nipple_") + sides[side], s.nipple_mm[side], sure, ""});
    SkinLandmark fold = fold_below(s.labels, s.nipple_mm[side]);
    fold.name = std::string("inframammary_fold_") + sides[side];
    marks.push_back(fold);
  }
  const double z = 0.5 * (s.nipple_mm[0][2] + s.nipple_mm[1][2]);
  const auto middle = voxel_at(s.labels, {s.midline_x_mm, s.nipple_mm[0][1], z});
  if (const auto y = front_y(s.labels, middle[0], middle[2])) {
    const double depth = *y - std::max(s.nipple_mm[0][1], s.nipple_mm[1][1]);
    marks.push_back(
        {"midline", Vec3{s.midline_x_mm, *y, z}, std::clamp(depth / deep_cleft_mm, 0.0, 1.0), ""});
  }
  marks.push_back(find_sternal_notch(s));
  return marks;
}

}  // namespace sanatrix::imaging
