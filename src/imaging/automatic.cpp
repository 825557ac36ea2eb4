#include "imaging/automatic.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "imaging/body_mask.hpp"
#include "imaging/fat_field.hpp"
#include "imaging/gland_label.hpp"
#include "imaging/grids.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double working_mm = 1.2;  ///< in-plane voxel size for field and chest wall
constexpr double wide_knots_mm = 70.0, fine_knots_mm = 45.0, finest_knots_mm = 25.0;
constexpr double skin_mm = 2.0;  ///< thickness; Huang et al., doi:10.1118/1.2841938: 1-2.5 mm
/// Half way between air and skin, relative to fat: skin has about a third of fat's signal.
constexpr float skin_edge = 0.17F;
constexpr double muscle_mm = 12.0;    ///< behind the fascia; pectorals and ribs
constexpr float lung_signal = 0.10F;  ///< relative to fat

Image3<float> in_plane_smoothed(const Image3<float>& image, double sigma_mm) {
  Image3<float> result = image;
  const double slices = result.spacing_mm[2];
  result.spacing_mm[2] = 1e3;  // slices stay apart
  smooth(result, sigma_mm);
  result.spacing_mm[2] = slices;
  return result;
}

Image3<float> divided(const Image3<float>& image, const Image3<float>& by) {
  Image3<float> result = image;
  for (std::size_t v = 0; v < result.voxels.size(); ++v) {
    result.voxels[v] = std::min(result.voxels[v] / std::max(by.voxels[v], 1e-6F), 4.0F);
  }
  return result;
}

/// What air reaches nowhere, per voxel: its mean and some deviations, of the noise of the place.
Image3<float> clear_of_air(const Image3<float>& grid, const AirSignal& air,
                           const Image3<float>& share, double deviations) {
  Image3<float> level = image_like<float>(grid);
  const auto most = static_cast<float>(air.mean + deviations * air.deviation);
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        level.voxels[v] = most * static_cast<float>(sample(share, grid.position_mm(i, j, k)));
      }
    }
  }
  return level;
}

/// Where air ends, per voxel: half the local skin's signal, but clear of the noise.
Image3<float> edge_of_skin(const Image3<float>& fat_signal, const AirSignal& air,
                           const Image3<float>& share) {
  Image3<float> edge = clear_of_air(fat_signal, air, share, 4.0);
  const auto half_air = static_cast<float>(0.5 * air.mean / (air.mean + 4.0 * air.deviation));
  for (std::size_t v = 0; v < edge.voxels.size(); ++v) {
    edge.voxels[v] =
        std::max(edge.voxels[v], skin_edge * fat_signal.voxels[v] + half_air * edge.voxels[v]);
  }
  return edge;
}

/// No threshold where tissue is known to be; it is too dim to tell gland from fat.
constexpr float known_tissue = -1.0F;
void add_dim_tissue(Image3<float>& edge, const Image3<float>& dim) {
  std::size_t v = 0;
  for (int k = 0; k < edge.size[2]; ++k) {
    for (int j = 0; j < edge.size[1]; ++j) {
      for (int i = 0; i < edge.size[0]; ++i, ++v) {
        if (sample(dim, edge.position_mm(i, j, k)) > 0.5) {
          edge.voxels[v] = known_tissue;
        }
      }
    }
  }
}

/// Skin between the breasts: where the front of the body lies deepest between two rises.
struct Cleft {
  double i_mm, j_mm;
};
Cleft find_cleft(const Mask& body) {
  const auto [nx, ny, nz] = body.size;
  // The front of the body per column, as the median over slices around the middle.
  std::vector<double> front(static_cast<std::size_t>(nx));
  std::vector<int> window;
  for (int i = 0; i < nx; ++i) {
    window.clear();
    for (int k = nz / 5; k < nz - nz / 5; ++k) {
      int j = 0;
      while (j < ny && body.at(i, j, k) == 0) {
        ++j;
      }
      window.push_back(j);
    }
    const auto middle = window.begin() + static_cast<long>(window.size() / 2);
    std::nth_element(window.begin(), middle, window.end());
    front[static_cast<std::size_t>(i)] = *middle * body.spacing_mm[1];
  }
  // The point that is deepest below the lower of the highest rises on its two sides.
  double best = -1.0;
  Cleft cleft{};
  std::vector<double> left(front), right(front);
  for (std::size_t i = 1; i < front.size(); ++i) {
    left[i] = std::min(left[i], left[i - 1]);
    right[front.size() - 1 - i] = std::min(right[front.size() - 1 - i], right[front.size() - i]);
  }
  std::size_t from = 0, to = 0;
  for (std::size_t i = 0; i < front.size(); ++i) {
    const double depth = front[i] - std::max(left[i], right[i]);
    if (depth > best + 1e-9) {
      best = depth;
      from = i;
    }
    if (depth > best - 1.0) {
      to = i;
    }
  }
  cleft.i_mm = 0.5 * static_cast<double>(from + std::max(from, to)) * body.spacing_mm[0];
  cleft.j_mm = front[from];
  if (best < 12.0) {
    throw Error(Fault::Input,
                fmt::format("not usable because no two breasts with a cleft between them were "
                            "found: the front of the body dips by only {:.0f} mm",
                            std::max(best, 0.0)),
                "use a prone MRI that shows both breasts hanging towards anterior, and the "
                "sternum; or give labels with --labels");
  }
  return cleft;
}

/// Voxels of the body that may be fat or gland: in front of the wall, below the skin.
Mask soft_interior(const Mask& body, const ChestWall& wall, double below_skin_mm,
                   double before_wall_mm) {
  Mask soft = body;
  const Image3<float> outside = signed_distance(body, {true, true, true}, 8.0);
  std::size_t v = 0;
  for (int k = 0; k < body.size[2]; ++k) {
    for (int j = 0; j < body.size[1]; ++j) {
      for (int i = 0; i < body.size[0]; ++i, ++v) {
        if (soft.voxels[v] != 0 &&
            (outside.voxels[v] > -below_skin_mm ||
             wall.behind_mm(i * body.spacing_mm[0], j * body.spacing_mm[1], k) > -before_wall_mm)) {
          soft.voxels[v] = 0;
        }
      }
    }
  }
  return soft;
}

/// Whether there may be gland: seen from the axis of the thorax no breast reaches the mid-axillary
/// line, and muscles of the back, which do, are as dark.
bool before_flank(const ChestWall& wall, double i_mm, double j_mm) {
  constexpr double widest = 75.0 * std::numbers::pi / 180.0;
  return std::abs(wall.angle_of(i_mm, j_mm)) < widest;
}

/// Behind the wall there is no fat that tells the shading, and a field that goes on from in front
/// may be anything: the signal of fat is taken from the place where the ray leaves the wall.
Image3<float> level_behind(const ChestWall& wall, Image3<float> fat_signal) {
  const Vec3 h = fat_signal.spacing_mm;
  const Image3<float> before = fat_signal;
  for (int k = 0; k < before.size[2]; ++k) {
    for (int j = 0; j < before.size[1]; ++j) {
      for (int i = 0; i < before.size[0]; ++i) {
        const double x = i * h[0] - wall.centre_i_mm, y = j * h[1] - wall.centre_j_mm;
        const double behind = wall.behind_mm(i * h[0], j * h[1], k), r = std::hypot(x, y);
        if (behind > 0.0 && r > h[0]) {
          const double out = (r + behind) / r;
          fat_signal.at(i, j, k) = static_cast<float>(
              sample(before, before.position_mm((wall.centre_i_mm + out * x) / h[0],
                                                (wall.centre_j_mm + out * y) / h[1], k)));
        }
      }
    }
  }
  return fat_signal;
}

/// A grid's first voxel, seen from another grid with the same axes [mm].
Vec3 offset_mm(const Image3<float>& grid, const Image3<float>& from) {
  return transpose(from.direction) * (grid.origin_mm - from.origin_mm);
}

/// The layer below the skin: fat nearly everywhere, and clear of heart and liver.
Mask below_skin(const Mask& body, double from_mm, double to_mm) {
  const Image3<float> outside = signed_distance(body, {true, true, true}, to_mm + 1.0);
  Mask layer = body;
  for (std::size_t v = 0; v < layer.voxels.size(); ++v) {
    const double depth = -static_cast<double>(outside.voxels[v]);
    layer.voxels[v] = depth > from_mm && depth < to_mm ? 1 : 0;
  }
  return layer;
}

struct Coarse {
  FatField field;
  ChestWall wall;
  Vec3 first_mm;  ///< the image's first voxel, seen from the working grid
  AirSignal air;
  Image3<float> noise;  ///< share of the air's
  Image3<float> dim;    ///< tissue that single voxels do not tell from air
  GlandularModel gland;
};

/// The image, the same on the working grid, and where in it the body is, before shading is known.
struct FirstLook {
  Image3<float> ordered;
  Image3<float> small;
  AirSignal air;
  Image3<float> noise;  ///< share of the air's
  Mask body;
};

FirstLook look(Image3<float> ordered) {
  FirstLook first;
  first.ordered = std::move(ordered);
  first.small = in_plane_smoothed(shrink_in_plane(first.ordered, working_mm), 0.6);
  first.air = measure_air(first.small);
  first.noise = noise_share(first.small, first.air);
  first.body = body_mask(first.small, clear_of_air(first.small, first.air, first.noise, 6.0));
  return first;
}

Image3<float> first_rows(const Image3<float>& image, int rows) {
  Image3<float> cut = image;
  cut.size[1] = rows;
  cut.voxels.clear();
  for (int k = 0; k < cut.size[2]; ++k) {
    const auto slice = image.voxels.begin() + static_cast<long>(image.index(0, 0, k));
    cut.voxels.insert(cut.voxels.end(), slice, slice + static_cast<long>(rows) * cut.size[0]);
  }
  return cut;
}

/// Of a whole trunk only what lies in front of its axis: its back, fat before air, looks like a
/// front as well, and muscle beside it like gland. An image that ends closer behind the axis than a
/// back could lie is taken whole.
FirstLook look_at_front(const Image3<float>& image) {
  constexpr double nearest_back_mm = 40.0;
  FirstLook first = look(in_lps_order(image));
  const double row_mm = first.ordered.spacing_mm[1];
  const double last_mm = find_cleft(first.body).j_mm + thorax_radius_mm;
  const bool has_back = first.ordered.size[1] * row_mm > last_mm + nearest_back_mm;
  const int rows = static_cast<int>(std::ceil(last_mm / row_mm));
  return has_back ? look(first_rows(first.ordered, rows)) : std::move(first);
}

Coarse find_on_working_grid(const FirstLook& first, const Context& ctx) {
  const auto& [ordered, small, air, noise, rough] = first;
  FatField field = estimate_fat_field(small, below_skin(rough, 3.0, 25.0), wide_knots_mm);
  Image3<float> signal = fat_signal_on(field, small);
  Image3<float> edge = edge_of_skin(signal, air, noise);
  Image3<float> dim = dim_tissue(small, edge, signal, noise);
  add_dim_tissue(edge, dim);
  const Mask body = body_mask(small, edge);
  const Cleft cleft = find_cleft(body);
  ctx.at(0.35, "chest wall");
  ChestWall wall = find_chest_wall(divided(small, signal), body, cleft.i_mm, cleft.j_mm);
  // Once more with the shading of what lies in front of the wall alone.
  ctx.at(0.55, "coil shading of the breasts");
  const Mask breasts = soft_interior(body, wall, 3.0, 2.0);
  field = estimate_fat_field(small, breasts, fine_knots_mm);
  field = refine_fat_field(small, breasts, field, finest_knots_mm);
  signal = fat_signal_on(field, small);
  ctx.at(0.75, "chest wall");
  wall = find_chest_wall(divided(small, level_behind(wall, signal)), body, cleft.i_mm, cleft.j_mm);
  Mask soft = soft_interior(body, wall, 4.0, 3.0);
  for (std::size_t v = 0; v < soft.voxels.size(); ++v) {
    const auto row = static_cast<std::size_t>(soft.size[0]),
               rows = static_cast<std::size_t>(soft.size[1]);
    const double i_mm = static_cast<double>(v % row) * soft.spacing_mm[0];
    const double j_mm = static_cast<double>(v / row % rows) * soft.spacing_mm[1];
    soft.voxels[v] = soft.voxels[v] != 0 && before_flank(wall, i_mm, j_mm) ? 1 : 0;
  }
  const GlandularModel gland = fit_glandular_model(divided(small, signal), soft);
  return {std::move(field),
          std::move(wall),
          offset_mm(ordered, small),
          air,
          noise,
          std::move(dim),
          gland};
}

Label behind_wall(double depth_mm, float relative) {
  if (depth_mm > 6.0 && relative < lung_signal) {
    return Label::Lung;
  }
  return depth_mm < muscle_mm ? Label::Muscle : Label::Organ;
}

/// Depths below the skin and in front of the wall of the whole thickness of a slice: the worst of
/// its middle and its two faces, half way to the neighbours.
class ThickSlice {
 public:
  ThickSlice(const Image3<float>& outside, const ChestWall& wall, const Image3<float>& grid,
             const Vec3& first_mm)
      : outside_(outside), wall_(wall), grid_(grid), first_mm_(first_mm) {}
  /// Whether the voxel's signal can be read as a mixture of fat and gland alone. Dark skin or
  /// muscle in a part of it would be taken for gland; close below the skin and in front of the
  /// fascia lie layers of fat.
  [[nodiscard]] bool holds_breast_only(int i, int j, int k) const {
    return skin_depth(i, j, k) > skin_mm + mixed_mm && wall_depth(i, j, k) > mixed_mm;
  }

 private:
  static constexpr double mixed_mm = 0.8;  ///< error of both surfaces and width of a voxel
  template <class Depth>
  [[nodiscard]] double least(int k, const Depth& depth) const {
    const double here = depth(k);
    const double below = k > 0 ? depth(k - 1) : here;
    const double above = k + 1 < grid_.size[2] ? depth(k + 1) : here;
    return std::min({here, 0.5 * (here + below), 0.5 * (here + above)});
  }
  [[nodiscard]] double skin_depth(int i, int j, int k) const {
    return least(k, [&](int c) { return -static_cast<double>(outside_.at(i, j, c)); });
  }
  [[nodiscard]] double wall_depth(int i, int j, int k) const {
    const double x = first_mm_[0] + i * grid_.spacing_mm[0];
    const double y = first_mm_[1] + j * grid_.spacing_mm[1];
    return least(k, [&](int c) { return -wall_.behind_mm(x, y, c); });
  }
  const Image3<float>& outside_;
  const ChestWall& wall_;
  const Image3<float>& grid_;
  Vec3 first_mm_;
};

}  // namespace

AutomaticLabels label_image(const Image3<float>& image, const Context& ctx) {
  const FirstLook look = look_at_front(image);
  const Image3<float>& ordered = look.ordered;
  ctx.at(0.1, "coil shading");
  Coarse coarse = find_on_working_grid(look, ctx.part(0.1, 0.7));
  ctx.at(0.7, "fibroglandular tissue");
  const Vec3 first = coarse.first_mm;
  const Image3<float> signal = fat_signal_on(coarse.field, ordered, first);
  const Image3<float> smoothed = in_plane_smoothed(ordered, 0.5);
  Image3<float> edge = edge_of_skin(signal, coarse.air, coarse.noise);
  add_dim_tissue(edge, coarse.dim);
  const Mask body = body_mask(smoothed, edge);
  const Image3<float> outside = signed_distance(body, {true, true, true}, 6.0);
  const ThickSlice thick(outside, coarse.wall, ordered, first);
  AutomaticLabels found;
  found.relative = divided(smoothed, signal);
  found.grid.labels = image_like<unsigned char>(ordered);
  found.grid.fibroglandular = image_like<float>(ordered);
  Mask clean = image_like<unsigned char>(ordered);
  std::size_t v = 0;
  for (int k = 0; k < ordered.size[2]; ++k) {
    for (int j = 0; j < ordered.size[1]; ++j) {
      for (int i = 0; i < ordered.size[0]; ++i, ++v) {
        if (body.voxels[v] == 0) {
          continue;
        }
        const double i_mm = first[0] + i * ordered.spacing_mm[0];
        const double j_mm = first[1] + j * ordered.spacing_mm[1];
        const double behind = coarse.wall.behind_mm(i_mm, j_mm, k);
        const float relative = found.relative.voxels[v];
        Label label = Label::Adipose;
        if (behind > 0.0) {
          label = behind_wall(behind, relative);
        } else if (outside.voxels[v] > -skin_mm) {
          label = Label::Skin;
        } else if (edge.voxels[v] != known_tissue && before_flank(coarse.wall, i_mm, j_mm) &&
                   thick.holds_breast_only(i, j, k)) {
          clean.voxels[v] = 1;
          found.grid.fibroglandular.voxels[v] = glandular_share(coarse.gland, relative);
        }
        found.grid.labels.voxels[v] = static_cast<unsigned char>(label);
      }
    }
  }
  label_gland(found.grid.labels, ordered, signal, coarse.gland, clean);
  found.wall = std::move(coarse.wall);
  found.gland = coarse.gland;
  found.noise = coarse.air.deviation;
  return found;
}

}  // namespace sanatrix::imaging
