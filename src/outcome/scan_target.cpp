#include "outcome/scan_target.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace sanatrix::outcome {

ScanTarget::ScanTarget(TriMesh surface)
    : surface_(std::move(surface)),
      tree_(surface_),
      normals_(vertex_normals(surface_)),
      border_(border_vertices(surface_)) {
  TriMesh rim{surface_.points, {}};
  for (const auto& t : surface_.triangles) {
    if (std::ranges::any_of(t, [&](int v) { return border_[static_cast<std::size_t>(v)]; })) {
      rim.triangles.push_back(t);
    }
  }
  if (!rim.triangles.empty()) {
    rim_.emplace(rim);
  }
}

bool ScanTarget::ends_near(const Vec3& p, const Hit& hit) const {
  // Teeth of a rim are some edges high; right at the skin a rim beside it does not matter.
  constexpr double nearly = 1.2, touching_m = 0.001;
  return hit.on_border ||
         (rim_ && hit.distance > touching_m && rim_->closest(p).distance < nearly * hit.distance);
}

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

namespace {

/// Of triangles that fell onto each other: those that look opposite ways are a fold and cancel, or
/// their edges would look like borders; what is left counts once.
void keep_net_triangles(std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::pair<std::array<int, 3>, int>> sides;
  for (std::array<int, 3> t : triangles) {
    std::ranges::rotate(t, std::ranges::min_element(t));
    const int side = t[1] < t[2] ? 1 : -1;
    std::ranges::sort(t);
    sides.emplace_back(t, side);
  }
  std::ranges::sort(sides);
  triangles.clear();
  for (auto first = sides.begin(); first != sides.end();) {
    int net = 0;
    auto last = first;
    for (; last != sides.end() && last->first == first->first; ++last) {
      net += last->second;
    }
    const auto& [a, b, c] = first->first;
    if (net != 0) {
      triangles.push_back(net > 0 ? std::array{a, b, c} : std::array{a, c, b});
    }
    first = last;
  }
}

}  // namespace

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
  keep_net_triangles(coarse.triangles);
  return coarse;
}

}  // namespace sanatrix::outcome
