#include "imaging/agreement.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {
namespace {

bool is_gland(unsigned char label) {
  return label == static_cast<unsigned char>(Label::Fibroglandular) ||
         label == static_cast<unsigned char>(Label::Tumour) ||
         label == static_cast<unsigned char>(Label::Nipple);
}
bool is_body(unsigned char label) {
  return label != 0;
}

/// The nearest voxel of `image` for every voxel of `grid`; air outside.
LabelImage on_grid(const LabelImage& image, const LabelImage& grid, Mask& covered) {
  LabelImage result = image_like<unsigned char>(grid);
  covered = image_like<unsigned char>(grid);
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const Vec3 c = image.continuous_index(grid.position_mm(i, j, k));
        std::array<int, 3> at{};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) {
          at[a] = static_cast<int>(std::lround(c[a]));
          inside = inside && at[a] >= 0 && at[a] < image.size[a];
        }
        if (inside) {
          covered.voxels[v] = 1;
          result.voxels[v] = image.at(at[0], at[1], at[2]);
        }
      }
    }
  }
  return result;
}

double dice(const LabelImage& a, const LabelImage& b, const Mask& where,
            bool (*is)(unsigned char)) {
  double both = 0.0, sum = 0.0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    if (where.voxels[v] != 0) {
      const bool in_a = is(a.voxels[v]), in_b = is(b.voxels[v]);
      both += in_a && in_b ? 1.0 : 0.0;
      sum += (in_a ? 1.0 : 0.0) + (in_b ? 1.0 : 0.0);
    }
  }
  return sum > 0.0 ? 2.0 * both / sum : 1.0;
}

Mask mask_where(const LabelImage& labels, bool (*is)(unsigned char)) {
  Mask mask = image_like<unsigned char>(labels);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    mask.voxels[v] = is(labels.voxels[v]) ? 1 : 0;
  }
  return mask;
}

/// Everything behind the first wall of a column is wall: fat between muscles, marrow, armpit
/// filling.
void close_wall(LabelImage& labels) {
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = 0; i < labels.size[0]; ++i) {
      bool behind = false;
      for (int j = 0; j < labels.size[1]; ++j) {
        behind = behind || is_wall(labels.at(i, j, k));
        if (behind && !is_wall(labels.at(i, j, k))) {
          labels.at(i, j, k) = static_cast<unsigned char>(Label::Muscle);
        }
      }
    }
  }
}

/// How far `other` and `own` boundaries are apart at the voxel faces between `inner` and `outer`
/// labels of `labels`, measured a few voxels away from the borders of the image. The difference of
/// two distances, since between thick slices the distance to a surface's own faces is not zero.
void collect(const LabelImage& labels, bool (*inner)(unsigned char), bool (*outer)(unsigned char),
             const Image3<float>& own, const Image3<float>& other, const Mask& where,
             std::vector<double>& all) {
  constexpr int border = 4;
  for (int k = border; k < labels.size[2] - border; ++k) {
    for (int j = border; j < labels.size[1] - border; ++j) {
      for (int i = border; i < labels.size[0] - border; ++i) {
        const std::size_t here = labels.index(i, j, k);
        if (!inner(labels.voxels[here]) || where.voxels[here] == 0) {
          continue;
        }
        for (const std::size_t there :
             {labels.index(i - 1, j, k), labels.index(i + 1, j, k), labels.index(i, j - 1, k),
              labels.index(i, j + 1, k), labels.index(i, j, k - 1), labels.index(i, j, k + 1)}) {
          if (outer(labels.voxels[there]) && where.voxels[there] != 0) {
            all.push_back(0.5 *
                          std::abs(static_cast<double>(other.voxels[here] - own.voxels[here] +
                                                       other.voxels[there] - own.voxels[there])));
            break;
          }
        }
      }
    }
  }
}

SurfaceError surface_error(const LabelImage& a, const LabelImage& b, const Mask& where,
                           bool (*inner)(unsigned char), bool (*outer)(unsigned char)) {
  constexpr double limit_mm = 60.0;
  std::vector<double> all;
  const auto to_a = signed_distance(mask_where(a, inner), {true, true, true}, limit_mm);
  const auto to_b = signed_distance(mask_where(b, inner), {true, true, true}, limit_mm);
  collect(a, inner, outer, to_a, to_b, where, all);
  collect(b, inner, outer, to_b, to_a, where, all);
  if (all.empty()) {
    return {limit_mm, limit_mm};
  }
  SurfaceError error;
  for (const double d : all) {
    error.mean_mm += d / static_cast<double>(all.size());
  }
  const auto p95 = all.begin() + static_cast<long>(0.95 * static_cast<double>(all.size()));
  std::nth_element(all.begin(), p95, all.end());
  error.p95_mm = *p95;
  return error;
}

}  // namespace

Agreement compare_labels(const LabelImage& found, const LabelImage& reference) {
  Mask where;
  LabelImage a = on_grid(found, reference, where);
  LabelImage truth = reference;
  close_wall(a);
  close_wall(truth);
  Agreement agreement;
  agreement.soft_dice = dice(a, truth, where, is_soft);
  agreement.glandular_dice = dice(a, truth, where, is_gland);
  double volume_found = 0.0, volume_true = 0.0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    if (where.voxels[v] != 0) {
      volume_found += is_gland(a.voxels[v]) ? 1.0 : 0.0;
      volume_true += is_gland(truth.voxels[v]) ? 1.0 : 0.0;
    }
  }
  agreement.glandular_volume_percent =
      volume_true > 0.0 ? 100.0 * (volume_found / volume_true - 1.0) : 0.0;
  agreement.chest_wall = surface_error(a, truth, where, is_wall, is_soft);
  agreement.skin =
      surface_error(a, truth, where, is_body, [](unsigned char label) { return label == 0; });
  return agreement;
}

}  // namespace sanatrix::imaging
