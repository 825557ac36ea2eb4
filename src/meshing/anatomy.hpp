// From labels to smooth shapes: the skin, the chest wall, where the breasts are, and what to mesh.
#pragma once

#include <array>
#include <vector>

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::meshing {

/// A value per column (x, z) of the grid.
struct ColumnMap {
  std::array<int, 2> size{};  ///< along x, z
  double spacing_mm = 0.0;
  std::array<double, 2> origin_mm{};  ///< x, z of column (0, 0)
  std::vector<double> value;

  [[nodiscard]] std::size_t index(int i, int k) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] double& at(int i, int k) { return value[index(i, k)]; }
  [[nodiscard]] double at(int i, int k) const { return value[index(i, k)]; }
  /// The column nearest to a position; the border columns go on outside.
  [[nodiscard]] std::size_t nearest(double x_mm, double z_mm) const;
};

/// Where the breasts stand forward of the torso, seen from the front.
struct BreastMap {
  ColumnMap prominence;           ///< [mm] in front of a ball that rolls over the chest
  ColumnMap base;                 ///< y [mm] of the torso's skin as if there were no breast
  std::vector<signed char> side;  ///< per column: -1 right breast, +1 left breast, 0 none
  double behind_base_mm = 0.0;    ///< tissue between that skin and the fascia
};

/// The part of space to mesh: between two heights, two lateral planes, in front of a third plane.
struct ClipBox {
  Vec3 low_mm{}, high_mm{};  ///< low y is in front of everything
};

struct Anatomy {
  Image3<float> outside_skin;  ///< about the distance [mm] to the smooth skin; negative inside
  Image3<float>
      behind_chest;         ///< about the distance [mm] to the smooth chest wall; positive behind
  Image3<float> thickness;  ///< [mm] of soft tissue between skin and chest wall around a point
  BreastMap breasts;
  ClipBox box;
};

/// Half axes [mm] along x, y, z of what rolls over the chest and the flanks but not over a breast.
struct RollingBall {
  double x_mm = 80.0, y_mm = 80.0, z_mm = 80.0;
  /// How often the ball may be made longer by a quarter, until both nipples stand clearly forward
  /// of it: the rise of a small breast is so gentle that a short ball rolls through it. Not wider,
  /// as the chest is round sideways.
  int lengthenings = 0;
};

/// A standing breast may be as round as the ball for the prone one; the trunk is long and straight.
extern const RollingBall standing_ball;
/// Farther from the nipple than this, seen from the front, no skin belongs to a standing breast.
extern const double standing_reach_mm;
/// Flanks lead over to arms beside a standing trunk.
inline constexpr double standing_least_saddle = 0.5;
/// A standing breast hangs from skin well above it, which must be free to follow.
extern const double standing_above_mm;

struct AnatomyOptions {
  double midline_x_mm = 0.0;
  std::array<Vec3, 2> nipple_mm{};
  double slab_half_height_mm = 0.0;  ///< 0: from the extent of the breasts
  RollingBall ball{};
  double breast_reach_mm = 1e3;  ///< from the nipple, seen from the front
  /// A rise beside a breast is its own where the skin between falls below this share of the lower
  /// top; 0: whatever is connected is breast.
  double least_saddle = 0.0;
  double above_mm = 25.0;      ///< of the model above what clearly stands forward
  bool wall_is_whole = false;  ///< labels show all of the chest wall, without gaps or noise
};

/// labels: isotropic, LPS. Throws Error{Input} without chest wall or breasts.
Anatomy find_anatomy(const LabelImage& labels, const AnatomyOptions& options, const Context& ctx);

/// Replaces the values of some columns by the smoothest ones between their neighbours.
void fill_smoothly(ColumnMap& map, const std::vector<std::size_t>& columns);

/// How far the skin stands [mm] in front of a ball that rolls over the torso from inside.
ColumnMap prominence_of(const ColumnMap& skin_y, const RollingBall& ball);

/// The breasts' footprint from the skin's height map; see breast_map.cpp.
BreastMap map_breasts(const ColumnMap& skin_y, const ColumnMap& chest_y,
                      const AnatomyOptions& options);

}  // namespace sanatrix::meshing
