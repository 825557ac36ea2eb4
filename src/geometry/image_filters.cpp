// Exact distance transform, separable Gaussian and connected parts of voxel images.
#include "geometry/image_filters.hpp"

#include <limits>
#include <numeric>

namespace sanatrix {
namespace {

/// Calls work(first voxel, stride, count) for every line of voxels along an axis.
template <class Work>
void for_each_line(const std::array<int, 3>& size, std::size_t axis, Work&& work) {
  const std::array<std::size_t, 3> n{static_cast<std::size_t>(size[0]),
                                     static_cast<std::size_t>(size[1]),
                                     static_cast<std::size_t>(size[2])};
  const std::array<std::size_t, 3> stride{1, n[0], n[0] * n[1]};
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  for (std::size_t b = 0; b < n[v]; ++b) {
    for (std::size_t a = 0; a < n[u]; ++a) {
      work(a * stride[u] + b * stride[v], stride[axis], n[axis]);
    }
  }
}

constexpr float far_away = 1e12F;

/// Lower envelope of parabolas: Felzenszwalb and Huttenlocher, doi:10.4086/toc.2012.v008a019.
class ParabolaEnvelope {
 public:
  void transform(std::vector<float>& f, double spacing) {
    const std::size_t n = f.size();
    apex_.assign(n, 0);
    from_.assign(n + 1, 0.0);
    std::size_t k = 0;
    from_[0] = -std::numeric_limits<double>::infinity();
    from_[1] = std::numeric_limits<double>::infinity();
    for (std::size_t q = 1; q < n; ++q) {
      double s = meeting(f, q, apex_[k], spacing);
      while (s <= from_[k]) {
        s = meeting(f, q, apex_[--k], spacing);
      }
      apex_[++k] = q;
      from_[k] = s;
      from_[k + 1] = std::numeric_limits<double>::infinity();
    }
    result_.resize(n);
    k = 0;
    for (std::size_t q = 0; q < n; ++q) {
      while (from_[k + 1] < static_cast<double>(q) * spacing) {
        ++k;
      }
      const double d = (static_cast<double>(q) - static_cast<double>(apex_[k])) * spacing;
      result_[q] = static_cast<float>(std::min(d * d + f[apex_[k]], 1e12));
    }
    f.swap(result_);
  }

 private:
  static double meeting(const std::vector<float>& f, std::size_t q, std::size_t p, double h) {
    const double x = static_cast<double>(q) * h;
    const double y = static_cast<double>(p) * h;
    return ((f[q] + x * x) - (f[p] + y * y)) / (2.0 * (x - y));
  }
  std::vector<std::size_t> apex_;
  std::vector<double> from_;
  std::vector<float> result_;
};

/// Squared distance [mm2] to the nearest voxel centre whose mask value is `target`.
std::vector<float> squared_distance(const Mask& mask, unsigned char target,
                                    const std::array<bool, 3>& along) {
  std::vector<float> d(mask.voxels.size());
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = (mask.voxels[i] != 0) == (target != 0) ? 0.0F : far_away;
  }
  ParabolaEnvelope envelope;
  std::vector<float> line;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!along[axis]) {
      continue;
    }
    for_each_line(mask.size, axis, [&](std::size_t first, std::size_t stride, std::size_t n) {
      line.resize(n);
      for (std::size_t i = 0; i < n; ++i) {
        line[i] = d[first + i * stride];
      }
      envelope.transform(line, mask.spacing_mm[axis]);
      for (std::size_t i = 0; i < n; ++i) {
        d[first + i * stride] = line[i];
      }
    });
  }
  return d;
}

}  // namespace

Image3<float> signed_distance(const Mask& mask, std::array<bool, 3> along, double limit_mm) {
  const std::vector<float> to_inside = squared_distance(mask, 1, along);
  const std::vector<float> to_outside = squared_distance(mask, 0, along);
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    if (along[a]) {
      step = std::min(step, mask.spacing_mm[a]);
    }
  }
  // Both distances end at voxel centres; the boundary lies half a voxel before them.
  const auto half = static_cast<float>(0.5 * step);
  const auto limit = static_cast<float>(limit_mm);
  Image3<float> distance = image_like<float>(mask);
  for (std::size_t i = 0; i < distance.voxels.size(); ++i) {
    const float d =
        mask.voxels[i] != 0 ? half - std::sqrt(to_outside[i]) : std::sqrt(to_inside[i]) - half;
    distance.voxels[i] = std::clamp(d, -limit, limit);
  }
  return distance;
}

void smooth(Image3<float>& image, double sigma_mm) {
  std::vector<float> line;
  std::vector<float> kernel;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sigma = sigma_mm / image.spacing_mm[axis];
    const int reach = static_cast<int>(std::ceil(3.0 * sigma));
    if (reach == 0) {
      continue;
    }
    kernel.assign(static_cast<std::size_t>(2 * reach + 1), 0.0F);
    for (int i = -reach; i <= reach; ++i) {
      kernel[static_cast<std::size_t>(i + reach)] =
          static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)));
    }
    const float sum = std::accumulate(kernel.begin(), kernel.end(), 0.0F);
    const auto pad = static_cast<std::size_t>(reach);
    for_each_line(image.size, axis, [&](std::size_t first, std::size_t stride, std::size_t n) {
      line.resize(n + 2 * pad);
      for (std::size_t i = 0; i < line.size(); ++i) {
        const std::size_t source = i < pad ? 0 : std::min(i - pad, n - 1);
        line[i] = image.voxels[first + source * stride];
      }
      for (std::size_t i = 0; i < n; ++i) {
        float value = 0.0F;
        for (std::size_t j = 0; j < kernel.size(); ++j) {
          value += kernel[j] * line[i + j];
        }
        image.voxels[first + i * stride] = value / sum;
      }
    });
  }
}

Parts connected_parts(const Mask& mask) {
  std::vector<int> part(mask.voxels.size(), -1);
  std::vector<std::size_t> count;
  std::vector<std::size_t> front;
  const std::array<std::size_t, 3> stride{
      1, static_cast<std::size_t>(mask.size[0]),
      static_cast<std::size_t>(mask.size[0]) * static_cast<std::size_t>(mask.size[1])};
  for (std::size_t seed = 0; seed < part.size(); ++seed) {
    if (mask.voxels[seed] == 0 || part[seed] >= 0) {
      continue;
    }
    const int id = static_cast<int>(count.size());
    count.push_back(0);
    front.assign(1, seed);
    part[seed] = id;
    while (!front.empty()) {
      const std::size_t here = front.back();
      front.pop_back();
      ++count.back();
      for (std::size_t a = 0; a < 3; ++a) {
        const auto n = static_cast<std::size_t>(mask.size[a]);
        const std::size_t position = here / stride[a] % n;
        const auto visit = [&](std::size_t there) {
          if (mask.voxels[there] != 0 && part[there] < 0) {
            part[there] = id;
            front.push_back(there);
          }
        };
        if (position > 0) {
          visit(here - stride[a]);
        }
        if (position + 1 < n) {
          visit(here + stride[a]);
        }
      }
    }
  }
  std::vector<int> order(count.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return count[static_cast<std::size_t>(a)] > count[static_cast<std::size_t>(b)];
  });
  std::vector<int> rank(count.size());
  Parts parts;
  for (std::size_t r = 0; r < order.size(); ++r) {
    rank[static_cast<std::size_t>(order[r])] = static_cast<int>(r);
    parts.voxels.push_back(count[static_cast<std::size_t>(order[r])]);
  }
  for (int& p : part) {
    p = p < 0 ? -1 : rank[static_cast<std::size_t>(p)];
  }
  parts.part = std::move(part);
  return parts;
}

}  // namespace sanatrix
