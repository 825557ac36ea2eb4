// Smooth skin and chest wall from labels, and the box that bounds the mesh.
#include "meshing/anatomy.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace sanatrix::meshing {
namespace {

constexpr double skin_sigma_mm = 2.2;   ///< removes voxel stairs, keeps nipples
constexpr double chest_sigma_mm = 3.5;  ///< the fascia bridges ribs and gaps of the sheet
constexpr double least_tissue_mm =
    5.0;  ///< between skin and chest; thinner sheets cannot be meshed
constexpr double thickness_limit_mm = 40.0;

void check(const LabelImage& labels) {
  const Vec3& h = labels.spacing_mm;
  require(
      labels.direction == identity3 && std::abs(h[0] - h[1]) < 1e-6 && std::abs(h[0] - h[2]) < 1e-6,
      "meshing needs an isotropic label grid that is aligned with LPS");
}

ColumnMap columns_of(const LabelImage& labels, double value) {
  ColumnMap map{.size = {labels.size[0], labels.size[2]},
                .spacing_mm = labels.spacing_mm[0],
                .origin_mm = {labels.origin_mm[0], labels.origin_mm[2]},
                .value = {}};
  map.value.assign(static_cast<std::size_t>(map.size[0]) * static_cast<std::size_t>(map.size[1]),
                   value);
  return map;
}

double y_of(const LabelImage& labels, int j) {
  return labels.origin_mm[1] + j * labels.spacing_mm[1];
}

/// y [mm] where each column enters the mask; `nowhere` where it does not.
ColumnMap front_of(const Mask& mask, double nowhere) {
  ColumnMap front = columns_of(mask, nowhere);
  for (int k = 0; k < mask.size[2]; ++k) {
    for (int i = 0; i < mask.size[0]; ++i) {
      for (int j = 0; j < mask.size[1]; ++j) {
        if (mask.at(i, j, k) != 0) {
          front.at(i, k) = y_of(mask, j) - 0.5 * mask.spacing_mm[1];
          break;
        }
      }
    }
  }
  return front;
}

Mask largest_wall(const LabelImage& labels) {
  Mask wall = image_like<unsigned char>(labels);
  for (std::size_t i = 0; i < wall.voxels.size(); ++i) {
    wall.voxels[i] = is_wall(labels.voxels[i]) ? 1 : 0;
  }
  const Parts parts = connected_parts(wall);
  if (parts.voxels.empty() ||
      static_cast<double>(parts.voxels[0]) * labels.voxel_volume_mm3() < 10e3) {
    throw Error(Fault::Input, "no chest wall: there is no connected muscle, bone or lung label",
                "label the chest wall behind the breasts (labels 4 to 7)");
  }
  for (std::size_t i = 0; i < wall.voxels.size(); ++i) {
    wall.voxels[i] = parts.part[i] == 0 ? 1 : 0;
  }
  return wall;
}

/// Columns without wall that are not open to a side of the image are gaps in the wall.
std::vector<std::size_t> gaps_in(const ColumnMap& chest_y, double nowhere) {
  Mask empty{.size = {chest_y.size[0], chest_y.size[1], 1}, .voxels = {}};
  for (const double y : chest_y.value) {
    empty.voxels.push_back(y == nowhere ? 1 : 0);
  }
  const Parts parts = connected_parts(empty);
  std::vector<bool> open(parts.voxels.size(), false);
  for (int k = 0; k < chest_y.size[1]; ++k) {
    for (const int i : {0, chest_y.size[0] - 1}) {
      if (const int p = parts.part[chest_y.index(i, k)]; p >= 0) {
        open[static_cast<std::size_t>(p)] = true;
      }
    }
  }
  std::vector<std::size_t> gaps;
  for (std::size_t c = 0; c < parts.part.size(); ++c) {
    if (parts.part[c] >= 0 && !open[static_cast<std::size_t>(parts.part[c])]) {
      gaps.push_back(c);
    }
  }
  return gaps;
}

/// Median over a square window: takes single spikes and pits of the labelling away, keeps the
/// steep sides of the chest.
void median_filter(ColumnMap& map, double radius_mm) {
  const int r = static_cast<int>(std::lround(radius_mm / map.spacing_mm));
  const ColumnMap source = map;
  std::vector<double> window;
  for (int k = 0; k < map.size[1]; ++k) {
    for (int i = 0; i < map.size[0]; ++i) {
      window.clear();
      for (int b = std::max(0, k - r); b <= std::min(map.size[1] - 1, k + r); ++b) {
        for (int a = std::max(0, i - r); a <= std::min(map.size[0] - 1, i + r); ++a) {
          window.push_back(source.at(a, b));
        }
      }
      const auto middle = window.begin() + static_cast<long>(window.size() / 2);
      std::nth_element(window.begin(), middle, window.end());
      map.at(i, k) = *middle;
    }
  }
}

/// y [mm] of the front of the chest wall; far behind the image beside the chest.
ColumnMap chest_front(const LabelImage& labels) {
  const double nowhere = y_of(labels, labels.size[1] + 20);
  ColumnMap chest_y = front_of(largest_wall(labels), nowhere);
  const std::vector<std::size_t> gaps = gaps_in(chest_y, nowhere);
  fill_smoothly(chest_y, gaps);
  median_filter(chest_y, 6.0);
  return chest_y;
}

/// Everything that is not air outside: tissue, chest, and air enclosed in them.
Mask whole_body(const LabelImage& labels, const ColumnMap& chest_y) {
  Mask air = image_like<unsigned char>(labels);
  std::size_t voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        air.voxels[voxel] = labels.voxels[voxel] == 0 && y_of(labels, j) < chest_y.at(i, k) ? 1 : 0;
      }
    }
  }
  const Parts outside = connected_parts(air);
  std::vector<bool> open(outside.voxels.size(), false);
  voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        const bool border = i == 0 || j == 0 || i == labels.size[0] - 1 || j == labels.size[1] - 1;
        if (border && outside.part[voxel] >= 0) {
          open[static_cast<std::size_t>(outside.part[voxel])] = true;
        }
      }
    }
  }
  Mask body = image_like<unsigned char>(labels);
  for (std::size_t v = 0; v < body.voxels.size(); ++v) {
    const int p = outside.part[v];
    body.voxels[v] = p >= 0 && open[static_cast<std::size_t>(p)] ? 0 : 1;
  }
  const Parts parts = connected_parts(body);
  for (std::size_t v = 0; v < body.voxels.size(); ++v) {
    body.voxels[v] = parts.part[v] == 0 ? 1 : 0;
  }
  return body;
}

/// From an indicator (1 inside) to about the distance [mm] near its smoothed boundary, positive
/// outside: the slope of a Gaussian edge is 1 / (sqrt(2 pi) sigma).
void indicator_to_distance(Image3<float>& image, double sigma_mm) {
  smooth(image, sigma_mm);
  const double scale = std::sqrt(2.0 * std::numbers::pi) * sigma_mm;
  for (float& v : image.voxels) {
    v = static_cast<float>((0.5 - v) * scale);
  }
}

/// The thorax as labelled, flanks that face sideways included.
Image3<float> labelled_thorax(const LabelImage& labels) {
  const Mask wall = largest_wall(labels);
  Image3<float> thorax = image_like<float>(labels);
  std::ranges::copy(wall.voxels, thorax.voxels.begin());
  return thorax;
}

/// The thorax behind a front without gaps, as an indicator, kept least_tissue_mm below the skin.
Image3<float> thorax_indicator(const LabelImage& labels, const ColumnMap& chest_y,
                               const Image3<float>& body_distance) {
  Image3<float> thorax = image_like<float>(labels);
  const double h = labels.spacing_mm[1];
  std::size_t voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        const double behind = (y_of(labels, j) - chest_y.at(i, k)) / h;
        const double deep = (-body_distance.voxels[voxel] - least_tissue_mm) / h;
        thorax.voxels[voxel] =
            static_cast<float>(std::clamp(std::min(behind, deep) + 0.5, 0.0, 1.0));
      }
    }
  }
  return thorax;
}

/// Margins between the breasts (where they stand forward clearly) and the planes that bound the
/// mesh, so that the planes do not disturb the breasts. "Reasonably far" in the paper.
constexpr double clear_prominence_mm = 20.0;
constexpr double clear_part = 0.6;  ///< of the nipple's, for small breasts
constexpr double margin_mm = 25.0;
constexpr double posterior_margin_mm = 30.0;
/// The outermost voxels are not trusted.
constexpr double border_mm = 3.0;

struct Extent {
  double low = 1e9, high = -1e9;
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
};

ClipBox choose_box(const LabelImage& labels, const BreastMap& breasts,
                   const AnatomyOptions& options) {
  Extent x;
  Extent z;
  Extent rim_y;
  const ColumnMap& map = breasts.base;
  double least = clear_prominence_mm;
  for (const Vec3& nipple : options.nipple_mm) {
    const double rise = breasts.prominence.value[map.nearest(nipple[0], nipple[2])];
    least = std::min(least, clear_part * std::max(0.0, rise));
  }
  for (int k = 0; k < map.size[1]; ++k) {
    for (int i = 0; i < map.size[0]; ++i) {
      if (breasts.side[map.index(i, k)] != 0 && breasts.prominence.at(i, k) > least) {
        x.add(map.origin_mm[0] + i * map.spacing_mm);
        z.add(map.origin_mm[1] + k * map.spacing_mm);
        rim_y.add(map.at(i, k));
      }
    }
  }
  if (options.slab_half_height_mm > 0.0) {
    const double centre = 0.5 * (options.nipple_mm[0][2] + options.nipple_mm[1][2]);
    z = {centre - options.slab_half_height_mm + margin_mm,
         centre + options.slab_half_height_mm - options.above_mm};
  }
  const Vec3 first = labels.origin_mm;
  const Vec3 last = labels.position_mm(labels.size[0] - 1, labels.size[1] - 1, labels.size[2] - 1);
  ClipBox box;
  box.low_mm = {std::max(x.low - margin_mm, first[0] + border_mm), first[1] - 100.0,
                std::max(z.low - margin_mm, first[2] + border_mm)};
  box.high_mm = {std::min(x.high + margin_mm, last[0] - border_mm),
                 std::min(rim_y.high + posterior_margin_mm, last[1] - border_mm),
                 std::min(z.high + options.above_mm, last[2] - border_mm)};
  return box;
}

}  // namespace

std::size_t ColumnMap::nearest(double x_mm, double z_mm) const {
  const auto column = [&](double at, std::size_t a) {
    return static_cast<int>(std::clamp(std::lround((at - origin_mm[a]) / spacing_mm), 0L,
                                       static_cast<long>(size[a]) - 1));
  };
  return index(column(x_mm, 0), column(z_mm, 1));
}

Anatomy find_anatomy(const LabelImage& labels, const AnatomyOptions& options, const Context& ctx) {
  check(labels);
  const ColumnMap chest_y = chest_front(labels);
  ctx.at(0.2);
  const Mask body = whole_body(labels, chest_y);
  const ColumnMap skin_y = front_of(body, y_of(labels, labels.size[1]));

  Anatomy anatomy;
  anatomy.breasts = map_breasts(skin_y, chest_y, options);
  anatomy.box = choose_box(labels, anatomy.breasts, options);
  ctx.at(0.4, "skin and chest wall");
  const Image3<float> body_distance = signed_distance(body, {true, true, true}, thickness_limit_mm);
  anatomy.behind_chest = options.wall_is_whole ? labelled_thorax(labels)
                                               : thorax_indicator(labels, chest_y, body_distance);
  ctx.at(0.6);

  Mask thorax = image_like<unsigned char>(labels);
  anatomy.outside_skin = image_like<float>(labels);
  for (std::size_t v = 0; v < thorax.voxels.size(); ++v) {
    thorax.voxels[v] = anatomy.behind_chest.voxels[v] > 0.5F ? 1 : 0;
    anatomy.outside_skin.voxels[v] = body.voxels[v];
  }
  anatomy.thickness = signed_distance(thorax, {true, true, true}, thickness_limit_mm);
  for (std::size_t v = 0; v < thorax.voxels.size(); ++v) {
    anatomy.thickness.voxels[v] -= body_distance.voxels[v];
  }
  ctx.at(0.8);
  indicator_to_distance(anatomy.outside_skin, skin_sigma_mm);
  indicator_to_distance(anatomy.behind_chest, chest_sigma_mm);
  for (float& v : anatomy.behind_chest.voxels) {
    v = -v;
  }
  return anatomy;
}

}  // namespace sanatrix::meshing
