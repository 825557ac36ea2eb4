// The phantom's unloaded body in formulas: a thorax, a layer of soft tissue on it, two breasts.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix::phantom {

/// Place relative to the chest wall: arc length from the sternum (positive to the patient's left),
/// height z, distance in front of the wall (negative: behind it). [m]
struct ChestPlace {
  double s, z, t;
};

/// The front of the chest wall: an ellipse with a groove at the sternum, the same at every height
/// but for a smooth shift in y. Places are exact: volumes are integrals of (1 + curvature t).
class Thorax {
 public:
  explicit Thorax(double half_arc);  ///< from the sternum to the side [m]

  [[nodiscard]] Vec3 point(const ChestPlace& place) const;
  [[nodiscard]] ChestPlace locate(const Vec3& p) const;
  [[nodiscard]] Vec3 normal(double s) const;       ///< out of the chest, horizontal
  [[nodiscard]] double curvature(double s) const;  ///< [1/m]
  [[nodiscard]] double half_arc() const { return half_arc_; }

 private:
  struct Sample {
    double x, y, nx, ny, curvature;
  };
  [[nodiscard]] Sample at(double s) const;
  double half_arc_ = 0.0, step_ = 0.0;
  std::vector<Sample> samples_;
};

struct Breast {
  double side;        ///< +1 patient's left, -1 right
  double s, z;        ///< centre of the base
  double radius;      ///< of the base [m]
  double projection;  ///< of the dome above the layer around it [m]
  double volume;      ///< from chest wall to skin within the base [m3]
};

/// Everything random about the body's shape comes from here, and from the seed alone.
double uniform(std::mt19937_64& random, double low, double high);

class Anatomy {
 public:
  Anatomy(double volume_m3, std::uint64_t seed);

  [[nodiscard]] const Thorax& thorax() const { return thorax_; }
  [[nodiscard]] const std::array<Breast, 2>& breasts() const { return breasts_; }  ///< right, left
  [[nodiscard]] const Breast& breast_at(double s) const { return breasts_[s > 0.0 ? 1 : 0]; }
  /// Distance from the base's centre as a multiple of its radius in that direction.
  [[nodiscard]] double base_radius(const Breast& breast, double s, double z) const;
  /// Chest wall to skin [m].
  [[nodiscard]] double thickness(double s, double z) const;
  /// Depth below the skin, perpendicular to it as far as the skin is flat [m].
  [[nodiscard]] double depth(const ChestPlace& place) const;
  [[nodiscard]] double inferior() const { return low_; }
  [[nodiscard]] double superior() const { return high_; }

 private:
  [[nodiscard]] double volume_within(const Breast& breast) const;
  double layer_;
  std::array<Breast, 2> breasts_;
  Thorax thorax_;
  double low_ = 0.0, high_ = 0.0;
};

}  // namespace sanatrix::phantom
