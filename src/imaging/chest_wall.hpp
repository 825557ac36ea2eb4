// The front of the chest wall (pectoral fascia) as one smooth, complete surface around the thorax.
#pragma once

#include <vector>

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// From the skin between the breasts to the axis of the thorax: half an adult thorax.
constexpr double thorax_radius_mm = 100.0;

/// In every slice k a radius per angle around an axis inside the thorax. Lengths in mm along the
/// image's own axes i and j, from its first voxel.
class ChestWall {
 public:
  double centre_i_mm = 0.0, centre_j_mm = 0.0;
  std::vector<double> radius_mm;  ///< angle fastest; angles from first_angle on
  std::vector<float> contrast;    ///< per radius: fat in front against dark behind, about 0..1
  int angles = 0, slices = 0;
  double first_angle = 0.0, angle_step = 0.0;  ///< 0: straight to anterior; positive: to the left

  [[nodiscard]] std::size_t index(int a, int k) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(angles) +
           static_cast<std::size_t>(a);
  }
  /// Of the ray through a point, from straight to anterior; positive to the left.
  [[nodiscard]] double angle_of(double i_mm, double j_mm) const;
  /// How far a point of slice k lies behind the wall [mm], along the ray; negative in front.
  [[nodiscard]] double behind_mm(double i_mm, double j_mm, int k) const;
};

/// relative: signal relative to that of fat, LPS order. Fat in front of the wall is bright (about
/// 1), muscle dark. `cleft_i_mm` and `cleft_j_mm`: skin between the breasts.
ChestWall find_chest_wall(const Image3<float>& relative, const Mask& body, double cleft_i_mm,
                          double cleft_j_mm);

}  // namespace sanatrix::imaging
