#include "imaging/denoise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace sanatrix::imaging {
namespace {

/// One slice, or the rows of it that hold something.
struct Rows {
  std::size_t width, height;
  std::vector<float> noisy;
  std::vector<float> weight;  ///< pull of the data against the total variation
};

constexpr float step_size = 0.35F;  ///< of both variables: its square is below 1/8, for convergence

/// Dual step: the field follows the gradient of `ahead`, no longer than 1.
void follow_gradient(const Rows& rows, const std::vector<float>& ahead,
                     std::vector<std::array<float, 2>>& field) {
  std::size_t v = 0;
  for (std::size_t j = 0; j < rows.height; ++j) {
    for (std::size_t i = 0; i < rows.width; ++i, ++v) {
      const float right = i + 1 < rows.width ? ahead[v + 1] - ahead[v] : 0.0F;
      const float down = j + 1 < rows.height ? ahead[v + rows.width] - ahead[v] : 0.0F;
      const float x = field[v][0] + step_size * right, y = field[v][1] + step_size * down;
      const float length = std::max(1.0F, std::sqrt(x * x + y * y));
      field[v] = {x / length, y / length};
    }
  }
}

/// Primal step, and its extrapolation `ahead`.
void follow_field(const Rows& rows, const std::vector<std::array<float, 2>>& field,
                  std::vector<float>& u, std::vector<float>& ahead) {
  std::size_t v = 0;
  for (std::size_t j = 0; j < rows.height; ++j) {
    for (std::size_t i = 0; i < rows.width; ++i, ++v) {
      const float divergence = field[v][0] - (i > 0 ? field[v - 1][0] : 0.0F) + field[v][1] -
                               (j > 0 ? field[v - rows.width][1] : 0.0F);
      const float pull = step_size * rows.weight[v];
      const float next = (u[v] + step_size * divergence + pull * rows.noisy[v]) / (1.0F + pull);
      ahead[v] = 2.0F * next - u[v];
      u[v] = next;
    }
  }
}

std::vector<float> smoothed(const Rows& rows) {
  constexpr int iterations = 40;
  std::vector<float> u = rows.noisy, ahead = rows.noisy;
  std::vector<std::array<float, 2>> field(u.size(), {0.0F, 0.0F});
  for (int n = 0; n < iterations; ++n) {
    follow_gradient(rows, ahead, field);
    follow_field(rows, field, u, ahead);
  }
  return u;
}

}  // namespace

double noise_deviation(const Image3<float>& image, const Mask& where) {
  std::vector<float> differences;
  for (std::size_t v = 2; v < image.voxels.size(); ++v) {
    if (where.voxels[v] != 0 && where.voxels[v - 2] != 0) {
      differences.push_back(std::abs(image.voxels[v] - image.voxels[v - 2]));
    }
  }
  if (differences.empty()) {
    return 0.0;
  }
  const auto quarter = differences.begin() + static_cast<long>((differences.size() + 3) / 4);
  std::nth_element(differences.begin(), quarter - 1, differences.end());
  const double mean = std::accumulate(differences.begin(), quarter, 0.0) /
                      static_cast<double>(quarter - differences.begin());
  return mean / 0.22335;  // of normal noise: 0.15793 * sqrt(2) deviations
}

Image3<float> without_noise(const Image3<float>& image, const Image3<float>& deviation,
                            const Mask& where) {
  constexpr float pinned = 1e6F, least_deviation = 1e-3F;
  Image3<float> result = image;
  const auto width = static_cast<std::size_t>(image.size[0]);
  const std::size_t slice = width * static_cast<std::size_t>(image.size[1]);
  for (std::size_t first = 0; first < image.voxels.size(); first += slice) {
    const auto begin = where.voxels.begin() + static_cast<long>(first);
    const auto inside = [](unsigned char w) {
      return w != 0;
    };
    const auto low = std::find_if(begin, begin + static_cast<long>(slice), inside) - begin;
    const std::size_t from = first + static_cast<std::size_t>(low) / width * width;
    std::size_t to = first + slice;
    while (to > from && std::none_of(where.voxels.begin() + static_cast<long>(to - width),
                                     where.voxels.begin() + static_cast<long>(to), inside)) {
      to -= width;
    }
    Rows rows{width, (to - from) / width, {}, {}};
    rows.noisy.assign(image.voxels.begin() + static_cast<long>(from),
                      image.voxels.begin() + static_cast<long>(to));
    for (std::size_t v = from; v < to; ++v) {
      rows.weight.push_back(
          where.voxels[v] == 0 ? pinned : 1.0F / std::max(deviation.voxels[v], least_deviation));
    }
    const std::vector<float> u = smoothed(rows);
    std::copy(u.begin(), u.end(), result.voxels.begin() + static_cast<long>(from));
  }
  return result;
}

}  // namespace sanatrix::imaging
