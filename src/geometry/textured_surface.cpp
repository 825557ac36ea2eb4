// Looking up colours, and giving every point one texture coordinate.
#include "geometry/textured_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>

namespace sanatrix {

std::array<double, 3> Photograph::at(double u, double v) const {
  const double x = std::clamp(u * width - 0.5, 0.0, width - 1.0);
  const double y = std::clamp((1.0 - v) * height - 0.5, 0.0, height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
  const double fx = x - x0, fy = y - y0;
  std::array<double, 3> colour{};
  const auto add = [&](int px, int py, double weight) {
    const std::size_t at = 3 * (static_cast<std::size_t>(py) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(px));
    for (std::size_t k = 0; k < 3; ++k) {
      colour[k] += weight * rgb[at + k];
    }
  };
  add(x0, y0, (1 - fx) * (1 - fy));
  add(x1, y0, fx * (1 - fy));
  add(x0, y1, (1 - fx) * fy);
  add(x1, y1, fx * fy);
  return colour;
}

double photograph_sense(const TexturedSurface& surface) {
  double sum = 0, total = 0;
  for (std::size_t t = 0; t < surface.corners.size(); ++t) {
    const auto& [a, b, c] = surface.corners[t];
    const double turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (std::isnan(turn) || turn == 0) {
      continue;
    }
    const auto& [i, j, k] = surface.mesh.triangles[t];
    const Vec3& p = surface.mesh.points[static_cast<std::size_t>(i)];
    const double area = norm(cross(surface.mesh.points[static_cast<std::size_t>(j)] - p,
                                   surface.mesh.points[static_cast<std::size_t>(k)] - p));
    sum += std::copysign(area, turn);
    total += area;
  }
  return total > 0 ? sum / total : 0.0;
}

SeamlessSurface split_at_seams(const TexturedSurface& surface) {
  SeamlessSurface result;
  const auto bits = [](float value) {
    std::uint32_t b = 0;
    std::memcpy(&b, &value, sizeof b);
    return b;
  };
  // Points with the texture coordinates under which they were met, as a chain per point.
  std::vector<int> first(surface.mesh.points.size(), -1), next;
  result.mesh.triangles.reserve(surface.mesh.triangles.size());
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const int point = surface.mesh.triangles[t][k];
      const TextureCorner corner =
          surface.corners.empty() ? TextureCorner{0, 0} : surface.corners[t][k];
      int copy = first[static_cast<std::size_t>(point)];
      while (copy >= 0 &&
             (bits(result.corner[static_cast<std::size_t>(copy)][0]) != bits(corner[0]) ||
              bits(result.corner[static_cast<std::size_t>(copy)][1]) != bits(corner[1]))) {
        copy = next[static_cast<std::size_t>(copy)];
      }
      if (copy < 0) {
        copy = static_cast<int>(result.corner.size());
        result.mesh.points.push_back(surface.mesh.points[static_cast<std::size_t>(point)]);
        result.corner.push_back(corner);
        result.origin.push_back(point);
        next.push_back(first[static_cast<std::size_t>(point)]);
        first[static_cast<std::size_t>(point)] = copy;
      }
      triangle[k] = copy;
    }
    result.mesh.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace sanatrix
