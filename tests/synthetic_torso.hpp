// A prone torso of simple shapes, labelled voxel by voxel: a curved chest wall with tissue of even
// thickness and two ellipsoidal breasts. Its surfaces are known exactly.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/image.hpp"

namespace sanatrix::testing {

struct SyntheticTorso {
  double chest_y_mm = 20.0;  ///< front of the chest wall at the midline
  double chest_radius_mm = 180.0;
  double tissue_mm = 14.0;  ///< skin to chest wall beside the breasts
  double breast_x_mm = 62.0;
  Vec3 semi_axes_mm{46.0, 62.0, 50.0};
  bool right_breast = true, left_breast = true;
  /// Of a sternal notch; as given the breastbone goes on for ever. There the skin of the midline
  /// has fallen back by 12 mm over 14 mm; above, it stays there.
  double notch_z_mm = 1e9, notch_x_mm = 0.0;

  [[nodiscard]] double chest_front(double x) const {
    return chest_y_mm + chest_radius_mm - std::sqrt(chest_radius_mm * chest_radius_mm - x * x);
  }
  /// How far the hollow of the notch lies behind the skin around.
  [[nodiscard]] double hollow(double x, double z) const {
    const double depth = 12.0 * std::clamp((z - notch_z_mm) / 14.0 + 1.0, 0.0, 1.0);
    return depth * std::exp(-std::pow((x - notch_x_mm) / 9.0, 2));
  }
  /// y of the skin of the layer on the chest.
  [[nodiscard]] double layer_front(double x, double z) const {
    return chest_front(x) - tissue_mm + hollow(x, z);
  }
  /// 1 on the ellipsoid's surface.
  [[nodiscard]] double in_ellipsoid(const Vec3& p) const {
    const double sign = p[0] > 0.0 ? 1.0 : -1.0;
    const Vec3 r{(p[0] - sign * breast_x_mm) / semi_axes_mm[0],
                 (p[1] - chest_front(breast_x_mm) + tissue_mm) / semi_axes_mm[1],
                 p[2] / semi_axes_mm[2]};
    const bool there = p[0] > 0.0 ? left_breast : right_breast;
    return there ? norm(r) : 1e9;
  }
  /// About the distance [mm] outside the skin; negative inside.
  [[nodiscard]] double outside(const Vec3& p) const {
    const double layer = layer_front(p[0], p[2]) - p[1];
    const double smallest = std::min({semi_axes_mm[0], semi_axes_mm[1], semi_axes_mm[2]});
    return std::min(layer, (in_ellipsoid(p) - 1.0) * smallest);
  }
  [[nodiscard]] unsigned char label(const Vec3& p) const {
    if (outside(p) > 0.0) {
      return 0;
    }
    const double behind = p[1] - chest_front(p[0]);
    if (behind > 0.0) {
      return behind < 10.0 ? 4 : 6;
    }
    if (outside(p) > -2.0) {
      return 3;
    }
    return in_ellipsoid(p) < 0.5 ? 2 : 1;
  }
  /// The nipple: the most anterior point of a breast. side -1 right, +1 left.
  [[nodiscard]] Vec3 tip(int side) const {
    return {side * breast_x_mm, chest_front(breast_x_mm) - tissue_mm - semi_axes_mm[1], 0.0};
  }

  /// Labels on any grid: `direction` columns are the LPS directions of the voxel axes.
  [[nodiscard]] LabelImage labels(const std::array<int, 3>& size, const Vec3& spacing_mm,
                                  const Mat3& direction = identity3) const {
    LabelImage image{.size = size,
                     .spacing_mm = spacing_mm,
                     .origin_mm = {},
                     .direction = direction,
                     .voxels = {}};
    image.origin_mm = Vec3{0, -5, 0} - image.position_mm(0.5 * (size[0] - 1), 0.5 * (size[1] - 1),
                                                         0.5 * (size[2] - 1));
    image.voxels.reserve(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                         static_cast<std::size_t>(size[2]));
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          image.voxels.push_back(label(image.position_mm(i, j, k)));
        }
      }
    }
    return image;
  }
  /// 252 x 126 x 168 mm, aligned with LPS.
  [[nodiscard]] LabelImage isotropic(double spacing_mm) const {
    return labels({static_cast<int>(252 / spacing_mm), static_cast<int>(126 / spacing_mm),
                   static_cast<int>(168 / spacing_mm)},
                  {spacing_mm, spacing_mm, spacing_mm});
  }
};

}  // namespace sanatrix::testing
