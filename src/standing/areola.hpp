// The areola on the skin's colours: a round spot that is redder or darker than the skin around it.
// docs/theory/scan-only.md, section 1
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/textured_surface.hpp"

namespace sanatrix::standing {

/// The skin's mean colour in a small cube.
struct ColourSample {
  Vec3 place_mm{};
  double tint = 0.0;  ///< larger where the skin is redder and darker; logarithmic
};

/// Evenly spread over the surface, whatever its triangles; empty when the scan has no colours.
std::vector<ColourSample> skin_colours(const TexturedSurface& surface);

struct Areola {
  Vec3 centre_mm{};
  double radius_mm = 0.0;
  double contrast = 0.0;  ///< of the tint, in deviations of the skin around
};

/// The clearest spot near the place where the breast's shape puts the nipple, if one is clear.
std::optional<Areola> find_areola(std::span<const ColourSample> skin, const Vec3& guess_mm);

}  // namespace sanatrix::standing
