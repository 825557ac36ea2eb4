// Coil shading from fat alone. N4 (doi:10.1109/TMI.2010.2046908) sharpens the histogram of all
// tissues; in a breast whose glandular share changes from place to place it takes anatomy for
// shading. Fat is everywhere, so its upper envelope is the safer reference; the field is the same
// kind of B-spline.
#include "imaging/fat_field.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "core/error.hpp"
#include "imaging/glandular.hpp"

namespace sanatrix::imaging {
namespace {

std::array<double, 4> cubic(double t) {
  const double s = 1.0 - t;
  return {s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
          (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0, t * t * t / 6.0};
}

constexpr double block_mm = 6.0;     ///< one sample per block of about this size
constexpr double envelope = 0.80;    ///< quantile of a block that stands for its fat
constexpr double least_share = 0.6;  ///< of a block inside the mask

/// Calls visit(first, after) for every block of whole voxels: index ranges along i, j, k.
template <class Visit>
void for_each_block(const Image3<float>& image, const Visit& visit) {
  std::array<int, 3> n{};
  for (std::size_t a = 0; a < 3; ++a) {
    n[a] = std::max(1, static_cast<int>(std::lround(block_mm / image.spacing_mm[a])));
  }
  for (int k = 0; k + n[2] <= image.size[2]; k += n[2]) {
    for (int j = 0; j + n[1] <= image.size[1]; j += n[1]) {
      for (int i = 0; i + n[0] <= image.size[0]; i += n[0]) {
        visit(std::array{i, j, k}, std::array{i + n[0], j + n[1], k + n[2]});
      }
    }
  }
}

/// Calls visit(voxel) for the voxels of a block that the mask has.
template <class Visit>
void for_each_voxel(const Mask& where, const std::array<int, 3>& first,
                    const std::array<int, 3>& after, const Visit& visit) {
  for (int k = first[2]; k < after[2]; ++k) {
    for (int j = first[1]; j < after[1]; ++j) {
      for (int i = first[0]; i < after[0]; ++i) {
        if (const std::size_t v = where.index(i, j, k); where.voxels[v] != 0) {
          visit(v);
        }
      }
    }
  }
}

Vec3 centre_mm(const Image3<float>& image, const std::array<int, 3>& first,
               const std::array<int, 3>& after) {
  Vec3 centre{};
  for (std::size_t a = 0; a < 3; ++a) {
    centre[a] = 0.5 * (first[a] + after[a] - 1) * image.spacing_mm[a];
  }
  return centre;
}

/// One sample per block: its envelope's logarithm.
std::vector<FatField::Sample> block_samples(const Image3<float>& image, const Mask& where) {
  std::vector<FatField::Sample> samples;
  std::vector<float> block;
  for_each_block(image, [&](const std::array<int, 3>& first, const std::array<int, 3>& after) {
    block.clear();
    for_each_voxel(where, first, after, [&](std::size_t v) { block.push_back(image.voxels[v]); });
    const int all = (after[0] - first[0]) * (after[1] - first[1]) * (after[2] - first[2]);
    if (static_cast<double>(block.size()) < least_share * all) {
      return;
    }
    const auto high =
        block.begin() + static_cast<long>(envelope * static_cast<double>(block.size() - 1));
    std::nth_element(block.begin(), high, block.end());
    if (*high > 0.0F) {
      samples.push_back({centre_mm(image, first, after), std::log(static_cast<double>(*high))});
    }
  });
  return samples;
}

Vec3 extent_mm(const Image3<float>& image) {
  Vec3 extent{};
  for (std::size_t a = 0; a < 3; ++a) {
    extent[a] = image.size[a] * image.spacing_mm[a];
  }
  return extent;
}

}  // namespace

FatField::FatField(const Vec3& extent_mm, double knot_mm) : knot_mm_(knot_mm) {
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    size_[a] = static_cast<int>(std::ceil(extent_mm[a] / knot_mm)) + 3;
    count *= static_cast<std::size_t>(size_[a]);
  }
  value_.assign(count, 0.0);
}

std::size_t FatField::index(int i, int j, int k) const {
  return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
          static_cast<std::size_t>(j)) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(i);
}

FatField::Support FatField::support(const Vec3& at) const {
  Support s{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = std::clamp(at[a] / knot_mm_, 0.0, size_[a] - 3.0 - 1e-9);
    s.first[a] = static_cast<int>(x);
    s.weight[a] = cubic(x - s.first[a]);
  }
  return s;
}

void FatField::fit(const std::vector<Sample>& samples, const std::vector<double>& weights,
                   double stiffness) {
  const auto n = static_cast<Eigen::Index>(value_.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  std::array<Eigen::Index, 64> at{};
  std::array<double, 64> w{};
  double total = 0.0;
  for (std::size_t p = 0; p < samples.size(); ++p) {
    if (weights[p] <= 0.0) {
      continue;
    }
    const Support s = support(samples[p].at);
    std::size_t c = 0;
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i, ++c) {
          at[c] = static_cast<Eigen::Index>(index(s.first[0] + i, s.first[1] + j, s.first[2] + k));
          w[c] = s.weight[0][static_cast<std::size_t>(i)] *
                 s.weight[1][static_cast<std::size_t>(j)] *
                 s.weight[2][static_cast<std::size_t>(k)];
        }
      }
    }
    total += weights[p];
    for (std::size_t a = 0; a < 64; ++a) {
      right[at[a]] += weights[p] * w[a] * samples[p].log_value;
      for (std::size_t b = 0; b < 64; ++b) {
        normal(at[a], at[b]) += weights[p] * w[a] * w[b];
      }
    }
  }
  // Second differences along every line of control values.
  const double penalty = stiffness * total / static_cast<double>(n);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < size_[2]; ++k) {
      for (int j = 0; j < size_[1]; ++j) {
        for (int i = 0; i < size_[0]; ++i) {
          std::array<int, 3> low{i, j, k}, mid = low, high = low;
          mid[axis] += 1;
          high[axis] += 2;
          if (high[axis] >= size_[axis]) {
            continue;
          }
          const std::array<Eigen::Index, 3> line{
              static_cast<Eigen::Index>(index(low[0], low[1], low[2])),
              static_cast<Eigen::Index>(index(mid[0], mid[1], mid[2])),
              static_cast<Eigen::Index>(index(high[0], high[1], high[2]))};
          constexpr std::array difference{1.0, -2.0, 1.0};
          for (std::size_t a = 0; a < 3; ++a) {
            for (std::size_t b = 0; b < 3; ++b) {
              normal(line[a], line[b]) += penalty * difference[a] * difference[b];
            }
          }
        }
      }
    }
  }
  // Where nothing pulls at a line of control values, as far from the body, it may have any slope.
  normal.diagonal().array() += 1e-9 * total / static_cast<double>(n);
  const Eigen::VectorXd solution = normal.llt().solve(right);
  for (Eigen::Index i = 0; i < n; ++i) {
    value_[static_cast<std::size_t>(i)] = solution[i];
  }
}

double FatField::log_at(const Vec3& at) const {
  const Support s = support(at);
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      double line = 0.0;
      for (int i = 0; i < 4; ++i) {
        line += s.weight[0][static_cast<std::size_t>(i)] *
                value_[index(s.first[0] + i, s.first[1] + j, s.first[2] + k)];
      }
      sum += s.weight[1][static_cast<std::size_t>(j)] * s.weight[2][static_cast<std::size_t>(k)] *
             line;
    }
  }
  return sum;
}

FatField estimate_fat_field(const Image3<float>& image, const Mask& where, double knot_mm) {
  const std::vector<FatField::Sample> samples = block_samples(image, where);
  require(samples.size() > 200, "the body in the image is too small for a breast MRI");
  FatField field(extent_mm(image), knot_mm);
  std::vector<double> weights(samples.size(), 1.0);
  // Asymmetric least squares (expectiles, doi:10.2307/1911031): what lies below the field hardly
  // counts, so that a wide region in which every voxel holds some gland is not taken for shading;
  // what lies far above (vessels, inflow) loses weight again.
  // Once the field has settled, gland far below it loses what weight it had: squared, many such
  // blocks would still drag the field down where there are few without gland.
  constexpr double below = 0.015, bright_outlier = 0.2, dark_outlier = 0.06;
  for (int round = 0; round < 14; ++round) {
    field.fit(samples, weights, round < 8 ? 0.3 : 0.03);
    for (std::size_t p = 0; p < samples.size(); ++p) {
      const double residual = samples[p].log_value - field.log_at(samples[p].at);
      const double outlier = residual > 0.0 ? bright_outlier : round < 8 ? 1e3 : dark_outlier;
      weights[p] = (residual > 0.0 ? 1.0 : below) / (1.0 + std::pow(residual / outlier, 2));
    }
  }
  return field;
}

FatField refine_fat_field(const Image3<float>& image, const Mask& where, const FatField& coarse,
                          double knot_mm) {
  constexpr int rounds = 4;
  // What looks like fat among much gland are mixtures with some gland: they say little.
  constexpr double stiffness = 0.01, least_fat = 0.3;
  FatField field = coarse;
  for (int round = 0; round < rounds; ++round) {
    Image3<float> relative = fat_signal_on(field, image);
    for (std::size_t v = 0; v < image.voxels.size(); ++v) {
      relative.voxels[v] = image.voxels[v] / std::max(relative.voxels[v], 1e-6F);
    }
    const GlandularModel model = fit_glandular_model(relative, where);
    std::vector<FatField::Sample> samples;
    std::vector<double> weights;
    for_each_block(image, [&](const std::array<int, 3>& first, const std::array<int, 3>& after) {
      double fat_voxels = 0.0, sum = 0.0, all = 0.0;
      for_each_voxel(where, first, after, [&](std::size_t v) {
        if (image.voxels[v] > 0.0F) {
          const double fat = pure_fat(model, static_cast<double>(relative.voxels[v]));
          all += 1.0;
          fat_voxels += fat;
          sum += fat * std::log(static_cast<double>(image.voxels[v]));
        }
      });
      if (all > 0.0 && fat_voxels > least_fat * all) {
        samples.push_back({centre_mm(image, first, after), sum / fat_voxels});
        weights.push_back(fat_voxels * std::pow(fat_voxels / all, 2));
      }
    });
    FatField next(extent_mm(image), knot_mm);
    next.fit(samples, weights, stiffness);
    field = std::move(next);
  }
  return field;
}

Image3<float> fat_signal_on(const FatField& field, const Image3<float>& grid,
                            const Vec3& first_mm) {
  Image3<float> signal = image_like<float>(grid);
  // The field is smooth: every fourth voxel is computed along i, those between interpolated.
  constexpr int step = 4;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      const double y = first_mm[1] + j * grid.spacing_mm[1],
                   z = first_mm[2] + k * grid.spacing_mm[2];
      for (int i = 0; i < grid.size[0]; i += step) {
        const double here = field.log_at({first_mm[0] + i * grid.spacing_mm[0], y, z});
        const double next = field.log_at({first_mm[0] + (i + step) * grid.spacing_mm[0], y, z});
        for (int a = i; a < std::min(i + step, grid.size[0]); ++a) {
          signal.at(a, j, k) = static_cast<float>(std::exp(here + (next - here) * (a - i) / step));
        }
      }
    }
  }
  return signal;
}

}  // namespace sanatrix::imaging
