// Two rises side by side on the front of a trunk that is the same on both sides.
#pragma once

#include <optional>

#include "geometry/vec3.hpp"
#include "standing/front_map.hpp"

namespace sanatrix::standing {

/// While it is not known which way is up, the same in all directions.
inline constexpr meshing::RollingBall search_ball{120.0, 120.0, 120.0};

struct BreastPair {
  std::array<Vec3, 2> tip_mm{};  ///< LPS of the map; [0] at lower x
  double score = 0.0;            ///< the larger, the more like two breasts
  /// Which way along the map the breasts' upper poles lie: in +n (above 0) or -n, n the frontal
  /// normal of the line from tip 0 to tip 1. The skin falls back slowly over them, and steeply to
  /// the fold below the breast.
  double upper_pole = 0.0;
};

/// Pairs on the front as it is held now, in any turn about y, the best first.
std::vector<BreastPair> find_pairs(const FrontMap& front, const meshing::ColumnMap& prominence);
/// The best with a line between its tips that is level; when the trunk's middle is known, the best
/// whose tips are mirror images, too: a breast and a rise beside a far smaller breast are not.
std::optional<BreastPair> find_level_pair(const FrontMap& front,
                                          const meshing::ColumnMap& prominence,
                                          std::optional<double> middle_x_mm = {});

}  // namespace sanatrix::standing
