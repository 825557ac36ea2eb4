#include "standing/front_map.hpp"

#include <algorithm>
#include <cmath>

namespace sanatrix::standing {
namespace {

using meshing::ColumnMap;

constexpr double nowhere = 1e9;

/// Lowers y of the columns whose centres lie in the triangle's projection.
void draw(const std::array<Vec3, 3>& mm, ColumnMap& map) {
  std::array<std::array<double, 2>, 3> at{};  // in columns
  for (std::size_t c = 0; c < 3; ++c) {
    at[c] = {(mm[c][0] - map.origin_mm[0]) / map.spacing_mm,
             (mm[c][2] - map.origin_mm[1]) / map.spacing_mm};
  }
  const auto a = at[0], b = at[1], c = at[2];
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  if (area < 1e-12) {
    return;  // looks away: the inside of the back, behind a hole or beyond the end of the scan
  }
  const auto range = [&](std::size_t axis) {
    const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
    return std::array<int, 2>{std::max(0, static_cast<int>(std::ceil(low))),
                              std::min(map.size[axis] - 1, static_cast<int>(std::floor(high)))};
  };
  const auto [i0, i1] = range(0);
  const auto [k0, k1] = range(1);
  constexpr double edge = -1e-9;  // columns on an edge belong to both triangles
  for (int k = k0; k <= k1; ++k) {
    for (int i = i0; i <= i1; ++i) {
      const double wb = ((i - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (k - a[1])) / area;
      const double wc = ((b[0] - a[0]) * (k - a[1]) - (i - a[0]) * (b[1] - a[1])) / area;
      if (wb >= edge && wc >= edge && wb + wc <= 1 - edge) {
        const double y = (1 - wb - wc) * mm[0][1] + wb * mm[1][1] + wc * mm[2][1];
        map.at(i, k) = std::min(map.at(i, k), y);
      }
    }
  }
}

}  // namespace

std::vector<bool> FrontMap::holes() const {
  Mask unseen{.size = {skin_y.size[0], skin_y.size[1], 1}, .voxels = {}};
  for (const bool s : seen) {
    unseen.voxels.push_back(s ? 0 : 1);
  }
  const Parts parts = connected_parts(unseen);
  std::vector<bool> open(parts.voxels.size(), false);
  for (int k = 0; k < skin_y.size[1]; ++k) {
    for (int i = 0; i < skin_y.size[0]; ++i) {
      const bool border = i == 0 || k == 0 || i == skin_y.size[0] - 1 || k == skin_y.size[1] - 1;
      if (const int part = parts.part[skin_y.index(i, k)]; border && part >= 0) {
        open[static_cast<std::size_t>(part)] = true;
      }
    }
  }
  std::vector<bool> hole;
  for (const int part : parts.part) {
    hole.push_back(part >= 0 && !open[static_cast<std::size_t>(part)]);
  }
  return hole;
}

FrontWindow window_of(const TriMesh& surface, double margin_mm) {
  FrontWindow window{{nowhere, nowhere}, {-nowhere, -nowhere}};
  for (const Vec3& p : surface.points) {
    for (const std::size_t a : {0U, 1U}) {
      window.low_mm[a] = std::min(window.low_mm[a], 1e3 * p[2 * a] - margin_mm);
      window.high_mm[a] = std::max(window.high_mm[a], 1e3 * p[2 * a] + margin_mm);
    }
  }
  return window;
}

FrontMap front_map(const TriMesh& surface, const FrontWindow& window, double spacing_mm) {
  FrontMap front;
  ColumnMap& map = front.skin_y;
  map.spacing_mm = spacing_mm;
  map.origin_mm = window.low_mm;
  for (const std::size_t a : {0U, 1U}) {
    map.size[a] = 1 + static_cast<int>((window.high_mm[a] - window.low_mm[a]) / spacing_mm);
  }
  map.value.assign(static_cast<std::size_t>(map.size[0]) * static_cast<std::size_t>(map.size[1]),
                   nowhere);
  for (const auto& triangle : surface.triangles) {
    std::array<Vec3, 3> mm{};
    for (std::size_t c = 0; c < 3; ++c) {
      mm[c] = 1e3 * surface.points[static_cast<std::size_t>(triangle[c])];
    }
    draw(mm, map);
  }
  std::vector<std::size_t> unseen;
  for (std::size_t c = 0; c < map.value.size(); ++c) {
    front.seen.push_back(map.value[c] < nowhere);
    if (!front.seen.back()) {
      unseen.push_back(c);
    }
  }
  if (unseen.size() < map.value.size()) {
    meshing::fill_smoothly(map, unseen);
  }
  return front;
}

std::vector<double> frontal_distance(const ColumnMap& grid, const std::vector<bool>& from) {
  // Two sweeps of the chamfer 1, sqrt(2); 8 % off at most.
  std::vector<double> distance;
  for (const bool f : from) {
    distance.push_back(f ? 0.0 : nowhere);
  }
  const auto lower = [&](int i, int k, int di, int dk) {
    const int a = i + di, b = k + dk;
    if (a >= 0 && b >= 0 && a < grid.size[0] && b < grid.size[1]) {
      const double step = grid.spacing_mm * std::sqrt(1.0 * (di * di + dk * dk));
      double& mine = distance[grid.index(i, k)];
      mine = std::min(mine, distance[grid.index(a, b)] + step);
    }
  };
  for (int k = 0; k < grid.size[1]; ++k) {
    for (int i = 0; i < grid.size[0]; ++i) {
      for (const auto& [di, dk] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) {
        lower(i, k, di, dk);
      }
    }
  }
  for (int k = grid.size[1] - 1; k >= 0; --k) {
    for (int i = grid.size[0] - 1; i >= 0; --i) {
      for (const auto& [di, dk] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) {
        lower(i, k, di, dk);
      }
    }
  }
  return distance;
}

}  // namespace sanatrix::standing
