#include "imaging/grids.hpp"

namespace sanatrix::imaging {

Image3<float> in_lps_order(const Image3<float>& image) {
  // The array axis that runs along each LPS axis best, the clearest first.
  std::array<std::size_t, 3> source{3, 3, 3};
  std::array<bool, 3> taken{};
  for (int round = 0; round < 3; ++round) {
    std::size_t best_lps = 0, best_axis = 0;
    double best = -1.0;
    for (std::size_t lps = 0; lps < 3; ++lps) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double along = std::abs(image.direction[lps][axis]);
        if (source[lps] == 3 && !taken[axis] && along > best) {
          best = along;
          best_lps = lps;
          best_axis = axis;
        }
      }
    }
    source[best_lps] = best_axis;
    taken[best_axis] = true;
  }
  Image3<float> ordered;
  std::array<int, 3> first{};  // source index of the new first voxel
  std::array<bool, 3> flip{};
  for (std::size_t a = 0; a < 3; ++a) {
    ordered.size[a] = image.size[source[a]];
    ordered.spacing_mm[a] = image.spacing_mm[source[a]];
    flip[a] = image.direction[a][source[a]] < 0.0;
    first[source[a]] = flip[a] ? ordered.size[a] - 1 : 0;
    for (std::size_t row = 0; row < 3; ++row) {
      ordered.direction[row][a] = (flip[a] ? -1.0 : 1.0) * image.direction[row][source[a]];
    }
  }
  ordered.origin_mm = image.position_mm(first[0], first[1], first[2]);
  ordered.voxels.reserve(image.voxels.size());
  std::array<int, 3> at{};
  for (int k = 0; k < ordered.size[2]; ++k) {
    at[source[2]] = flip[2] ? ordered.size[2] - 1 - k : k;
    for (int j = 0; j < ordered.size[1]; ++j) {
      at[source[1]] = flip[1] ? ordered.size[1] - 1 - j : j;
      for (int i = 0; i < ordered.size[0]; ++i) {
        at[source[0]] = flip[0] ? ordered.size[0] - 1 - i : i;
        ordered.voxels.push_back(image.at(at[0], at[1], at[2]));
      }
    }
  }
  return ordered;
}

Image3<float> shrink_in_plane(const Image3<float>& image, double size_mm) {
  const int bi = std::max(1, static_cast<int>(std::lround(size_mm / image.spacing_mm[0])));
  const int bj = std::max(1, static_cast<int>(std::lround(size_mm / image.spacing_mm[1])));
  Image3<float> small = image;
  small.size = {image.size[0] / bi, image.size[1] / bj, image.size[2]};
  small.spacing_mm = {bi * image.spacing_mm[0], bj * image.spacing_mm[1], image.spacing_mm[2]};
  small.origin_mm = image.position_mm(0.5 * (bi - 1), 0.5 * (bj - 1), 0);
  small.voxels.clear();
  const float per_voxel = 1.0F / static_cast<float>(bi * bj);
  for (int k = 0; k < small.size[2]; ++k) {
    for (int j = 0; j < small.size[1]; ++j) {
      for (int i = 0; i < small.size[0]; ++i) {
        float sum = 0.0F;
        for (int b = 0; b < bj; ++b) {
          for (int a = 0; a < bi; ++a) {
            sum += image.at(i * bi + a, j * bj + b, k);
          }
        }
        small.voxels.push_back(sum * per_voxel);
      }
    }
  }
  return small;
}

}  // namespace sanatrix::imaging
