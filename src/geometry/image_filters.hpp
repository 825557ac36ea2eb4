// Operations on voxel images that more than one layer needs: sampling, distances, smoothing, parts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "geometry/image.hpp"

namespace sanatrix {

/// 1 inside, 0 outside.
using Mask = Image3<unsigned char>;

/// An image of the same place and size as `grid`, filled with `value`.
template <class T, class U>
Image3<T> image_like(const Image3<U>& grid, T value = T{}) {
  return {grid.size, grid.spacing_mm, grid.origin_mm, grid.direction,
          std::vector<T>(grid.voxels.size(), value)};
}

/// The eight voxels around a continuous index and their trilinear weights. Outside, the border
/// voxels go on.
struct Neighbourhood {
  std::array<std::size_t, 8> voxel;
  std::array<double, 8> weight;
};
template <class T>
Neighbourhood neighbourhood(const Image3<T>& image, const Vec3& continuous_index) {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  Vec3 t{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double last = image.size[a] - 1;
    const double c = std::clamp(continuous_index[a], 0.0, last);
    low[a] = static_cast<int>(std::floor(c));
    high[a] = std::min(low[a] + 1, image.size[a] - 1);
    t[a] = c - low[a];
  }
  Neighbourhood n{};
  for (unsigned corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1U) != 0;
    const bool y = (corner & 2U) != 0;
    const bool z = (corner & 4U) != 0;
    n.voxel[corner] = image.index(x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
    n.weight[corner] = (x ? t[0] : 1 - t[0]) * (y ? t[1] : 1 - t[1]) * (z ? t[2] : 1 - t[2]);
  }
  return n;
}

/// Trilinear value at an LPS position [mm].
template <class T>
double sample(const Image3<T>& image, const Vec3& p_mm) {
  const Neighbourhood n = neighbourhood(image, image.continuous_index(p_mm));
  double value = 0.0;
  for (std::size_t c = 0; c < 8; ++c) {
    value += n.weight[c] * static_cast<double>(image.voxels[n.voxel[c]]);
  }
  return value;
}

/// Distance [mm] to the boundary of the mask, negative inside, limited to +-limit_mm. Distances are
/// measured along the given axes only: leave an axis of thick slices out, and interpolating the
/// result between slices gives a surface without stairs (shape-based interpolation, Raya and
/// Udupa, doi:10.1109/42.52980).
Image3<float> signed_distance(const Mask& mask, std::array<bool, 3> along, double limit_mm);

/// Gaussian smoothing; beyond the image the border voxels go on.
void smooth(Image3<float>& image, double sigma_mm);

/// Face-connected parts: numbers of voxels, largest first, and per voxel its part (-1: outside).
struct Parts {
  std::vector<int> part;
  std::vector<std::size_t> voxels;
};
Parts connected_parts(const Mask& mask);

}  // namespace sanatrix
