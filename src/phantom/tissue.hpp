// What the phantom consists of at a place of its unloaded body: fat, gland, tumour, nipple.
#pragma once

#include <span>
#include <vector>

#include "geometry/image.hpp"
#include "phantom/anatomy.hpp"
#include "phantom/phantom.hpp"

namespace sanatrix::phantom {

struct Tumour {
  ChestPlace centre;
  double radius;  ///< of the sphere of about equal volume [m]
};

/// The share of gland that a density class stands for, of the breast's volume.
double gland_share(Density density);

class TissueMap {
 public:
  TissueMap(const Anatomy& anatomy, Density density, std::uint64_t seed);
  /// Adipose, Fibroglandular, Tumour or Nipple; skin is the voxeliser's business because it lies
  /// at the surface of the deformed body. `depth`: below the skin [m].
  [[nodiscard]] Label at(const ChestPlace& place, double depth) const;
  [[nodiscard]] bool is_nipple(const ChestPlace& place, double depth) const;
  [[nodiscard]] const Tumour& tumour() const { return tumour_; }

 private:
  /// A lobe of the gland: a cone from below the nipple towards the base.
  struct Lobe {
    Vec3 from, along;  ///< in (s - centre, z - centre, t) of its breast [m]
    double thin, thick;
  };
  [[nodiscard]] double gland(const Breast& breast, std::span<const Lobe> lobes,
                             const ChestPlace& place, double depth) const;
  [[nodiscard]] double threshold_for(const Breast& breast, std::span<const Lobe> lobes,
                                     double share) const;
  [[nodiscard]] bool in_tumour(const ChestPlace& place) const;

  const Anatomy& anatomy_;
  std::uint64_t seed_;
  std::array<std::vector<Lobe>, 2> lobes_;
  std::array<double, 2> threshold_{};
  Tumour tumour_{};
};

}  // namespace sanatrix::phantom
