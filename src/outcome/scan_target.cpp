#include "outcome/scan_target.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace sanatrix::outcome {

ScanTarget::ScanTarget(TriMesh surface)
    : surface_(std::move(surface)),
      tree_(surface_),
      normals_(vertex_normals(surface_)),
      border_(border_vertices(surface_)) {}

ScanTarget::Hit ScanTarget::closest(const Vec3& p) const {
  const SurfaceTree::Hit hit = tree_.closest(p);
  const auto& triangle = surface_.triangles[static_cast<std::size_t>(hit.triangle)];
  const std::array<double, 3> weights = weights_in(surface_, hit.triangle, hit.point);
  Vec3 normal{};
  double at_border = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(triangle[k]);
    normal += weights[k] * normals_[v];
    at_border += border_[v] ? weights[k] : 0.0;
  }
  const double length = norm(normal);
  return {hit.point, length > 0 ? (1 / length) * normal : normal, hit.distance, hit.triangle,
          at_border > 0.99};
}

std::vector<double> vertex_areas(const TriMesh& surface) {
  std::vector<double> areas(surface.points.size(), 0.0);
  for (const auto& triangle : surface.triangles) {
    const auto corner = [&](std::size_t i) {
      return surface.points[static_cast<std::size_t>(triangle[i])];
    };
    const double third = area(corner(0), corner(1), corner(2)) / 3.0;
    for (const int v : triangle) {
      areas[static_cast<std::size_t>(v)] += third;
    }
  }
  return areas;
}

std::vector<bool> border_vertices(const TriMesh& surface) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::uint64_t>(t[k]),
                 b = static_cast<std::uint64_t>(t[(k + 1) % 3]);
      edges.push_back(std::min(a, b) << 32 | std::max(a, b));
    }
  }
  std::ranges::sort(edges);
  std::vector<bool> border(surface.points.size(), false);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j] == edges[i]) {
      ++j;
    }
    if (j - i == 1) {
      border[edges[i] >> 32] = true;
      border[edges[i] & 0xffffffffU] = true;
    }
    i = j;
  }
  return border;
}

std::array<double, 3> weights_in(const TriMesh& surface, int triangle, const Vec3& p) {
  const auto& t = surface.triangles[static_cast<std::size_t>(triangle)];
  const Vec3& a = surface.points[static_cast<std::size_t>(t[0])];
  const Vec3& b = surface.points[static_cast<std::size_t>(t[1])];
  const Vec3& c = surface.points[static_cast<std::size_t>(t[2])];
  const Vec3 n = cross(b - a, c - a);
  const double whole = dot(n, n);
  if (!(whole > 0)) {
    return {1, 0, 0};
  }
  const double wb = std::clamp(dot(cross(p - a, c - a), n) / whole, 0.0, 1.0);
  const double wc = std::clamp(dot(cross(b - a, p - a), n) / whole, 0.0, 1.0 - wb);
  return {1 - wb - wc, wb, wc};
}

TriMesh coarsened(const TriMesh& surface, double edge_m) {
  struct Cube {
    Vec3 sum{};
    double count = 0;
    int number = -1;
  };
  std::unordered_map<std::uint64_t, Cube> cubes;
  const auto key = [&](const Vec3& p) {
    std::uint64_t k = 0;
    for (const double x : p) {
      k = k << 21 | (static_cast<std::uint64_t>(std::llround(x / edge_m) + (1 << 20)) & 0x1fffff);
    }
    return k;
  };
  for (const Vec3& p : surface.points) {
    Cube& cube = cubes[key(p)];
    cube.sum += p;
    cube.count += 1;
  }
  TriMesh coarse;
  for (const auto& t : surface.triangles) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      Cube& cube = cubes[key(surface.points[static_cast<std::size_t>(t[k])])];
      if (cube.number < 0) {
        cube.number = static_cast<int>(coarse.points.size());
        coarse.points.push_back((1 / cube.count) * cube.sum);
      }
      triangle[k] = cube.number;
    }
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[0] != triangle[2]) {
      coarse.triangles.push_back(triangle);
    }
  }
  // Triangles that fell onto each other count once, or edges would look like borders.
  std::ranges::sort(coarse.triangles, [](auto a, auto b) {
    std::ranges::sort(a);
    std::ranges::sort(b);
    return a < b;
  });
  const auto repeated = std::ranges::unique(coarse.triangles, [](auto a, auto b) {
    std::ranges::sort(a);
    std::ranges::sort(b);
    return a == b;
  });
  coarse.triangles.erase(repeated.begin(), repeated.end());
  return coarse;
}

}  // namespace sanatrix::outcome
