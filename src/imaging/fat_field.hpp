// The signal that pure fat has at every place: coil shading and scanner scale in one smooth field.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// A smooth positive field as cubic B-splines of its logarithm.
class FatField {
 public:
  struct Sample {
    Vec3 at;  ///< continuous index in mm from the first voxel, along i, j, k
    double log_value;
  };
  FatField(const Vec3& extent_mm, double knot_mm);
  /// Weighted least squares with a penalty on second differences.
  void fit(const std::vector<Sample>& samples, const std::vector<double>& weights,
           double stiffness);
  [[nodiscard]] double log_at(const Vec3& at) const;

 private:
  struct Support {
    std::array<int, 3> first;
    std::array<std::array<double, 4>, 3> weight;
  };
  [[nodiscard]] Support support(const Vec3& at) const;
  [[nodiscard]] std::size_t index(int i, int j, int k) const;

  double knot_mm_;
  std::array<int, 3> size_{};
  std::vector<double> value_;
};

/// Fits the field to the upper envelope of the image within `where` (body, or soft tissue): fat is
/// the brightest tissue without fat suppression, and is found in most small neighbourhoods.
FatField estimate_fat_field(const Image3<float>& image, const Mask& where, double knot_mm);

/// The same with finer knots, from voxels that hold fat alone by their signal: expectation (which
/// they are, given the field) and maximisation (the field, given them) in turns, as Van Leemput et
/// al., doi:10.1109/42.811270, do for the brain.
FatField refine_fat_field(const Image3<float>& image, const Mask& where, const FatField& coarse,
                          double knot_mm);

/// The field on a grid with the axes of the image it was fitted to; the grid's first voxel lies
/// `first_mm` from that image's first voxel, along the axes.
Image3<float> fat_signal_on(const FatField& field, const Image3<float>& grid,
                            const Vec3& first_mm = {});

}  // namespace sanatrix::imaging
