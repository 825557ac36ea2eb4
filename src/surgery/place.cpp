#include "surgery/place.hpp"

#include <cmath>
#include <numbers>

namespace sanatrix::surgery {

Place place_of(const Vec3& tumour_centre, const Vec3& nipple, Side side) {
  constexpr double mm = 1e-3;
  constexpr double central_mm = 20.0;  // half of a usual areola
  const Vec3 r = tumour_centre - nipple;
  const double outwards = (side == Side::Left ? 1.0 : -1.0) * r[0], up = r[2];
  Place place;
  place.from_nipple_mm = norm(r) / mm;
  place.quadrant =
      std::hypot(outwards, up) / mm < central_mm
          ? "central"
          : std::string(up > 0.0 ? "upper " : "lower ") + (outwards > 0.0 ? "outer" : "inner");
  const double hours = std::round(std::atan2(r[0], up) * 12.0 / std::numbers::pi) / 2.0;
  place.clock_hour = hours <= 0.0 ? hours + 12.0 : hours;
  return place;
}

}  // namespace sanatrix::surgery
