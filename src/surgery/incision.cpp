// Lines on the skin: snapping to vertices and shortest paths along edges (Dijkstra).
#include "surgery/incision.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

namespace sanatrix::surgery {
namespace {

using Neighbours = std::vector<std::vector<int>>;

int nearest_vertex(const TriMesh& surface, const Vec3& p) {
  const auto nearer = [&p](const Vec3& a, const Vec3& b) {
    return dot(a - p, a - p) < dot(b - p, b - p);
  };
  return static_cast<int>(std::ranges::min_element(surface.points, nearer) -
                          surface.points.begin());
}

/// Vertices from `start` (exclusive) to `end`; empty when they are not connected.
std::vector<int> shortest_path(const TriMesh& surface, const Neighbours& near, int start, int end) {
  std::vector<double> length(near.size(), std::numeric_limits<double>::infinity());
  std::vector<int> from(near.size(), -1);
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  length[start] = 0.0;
  queue.emplace(0.0, start);
  while (!queue.empty() && queue.top().second != end) {
    const auto [so_far, at] = queue.top();
    queue.pop();
    for (const int next : near[at]) {
      const double way = so_far + norm(surface.points[next] - surface.points[at]);
      if (way < length[next]) {
        length[next] = way;
        from[next] = at;
        queue.emplace(way, next);
      }
    }
  }
  std::vector<int> path;
  for (int at = end; at != start && at >= 0; at = from[at]) {
    path.push_back(at);
  }
  std::ranges::reverse(path);
  return path;
}

}  // namespace

std::vector<Vec3> default_incision(const Vec3& entry, const Vec3& axis_towards_skin,
                                   double half_length) {
  const Vec3 up{0, 0, 1};
  const Vec3 across = cross(up, axis_towards_skin);
  // An axis along z has no horizontal direction on the skin; left-right is as good as any.
  const Vec3 along = norm(across) > 1e-3 ? normalised(across) : Vec3{1, 0, 0};
  return {entry - half_length * along, entry, entry + half_length * along};
}

std::vector<Vec3> circumareolar_incision(const Vec3& nipple, const Vec3& entry, double radius) {
  // Seen from the front; the line is snapped to the skin later.
  const double middle = std::atan2(entry[2] - nipple[2], entry[0] - nipple[0]);
  constexpr double half = 75.0 * std::numbers::pi / 180.0;
  constexpr int pieces = 12;
  std::vector<Vec3> line;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = middle + half * (2.0 * i / pieces - 1.0);
    line.push_back(nipple + radius * Vec3{std::cos(angle), 0.0, std::sin(angle)});
  }
  return line;
}

std::vector<Vec3> radial_incision(const Vec3& nipple, const Vec3& entry, double areola_radius) {
  const Vec3 outwards = entry - nipple;
  const double length = norm(outwards);
  const double start = std::min(areola_radius / std::max(length, 1e-9), 0.9);
  return {nipple + start * outwards, entry, nipple + 1.5 * outwards};
}

std::vector<Vec3> inframammary_incision(std::span<const Vec3> breast_skin, const Vec3& entry,
                                        double width) {
  if (breast_skin.empty()) {
    return {};
  }
  const auto across = [](const Vec3& a, const Vec3& b) {
    return a[0] < b[0];
  };
  const auto [first, last] = std::ranges::minmax_element(breast_skin, across);
  const double half = std::min(0.5 * width, 0.5 * ((*last)[0] - (*first)[0]));
  const double middle = std::clamp(entry[0], (*first)[0] + half, (*last)[0] - half);
  constexpr int pieces = 8, smoothing_passes = 3;
  std::vector<Vec3> line;
  for (int i = 0; i < pieces; ++i) {
    const double from = middle + half * (2.0 * i / pieces - 1.0);
    const Vec3* lowest = nullptr;
    for (const Vec3& p : breast_skin) {
      if (p[0] >= from && p[0] < from + 2.0 * half / pieces &&
          (lowest == nullptr || p[2] < (*lowest)[2])) {
        lowest = &p;
      }
    }
    if (lowest != nullptr) {
      line.push_back(*lowest);
    }
  }
  // The border follows edges of the mesh; a scalpel does not.
  for (int pass = 0; pass < smoothing_passes; ++pass) {
    const std::vector<Vec3> old = line;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      line[i] = 0.25 * old[i - 1] + 0.5 * old[i] + 0.25 * old[i + 1];
    }
  }
  return line;
}

std::vector<int> path_on_skin(const Anatomy& anatomy, std::span<const Vec3> polyline) {
  const Surface& skin = anatomy.skin();
  const Neighbours& near = anatomy.skin_edges();
  constexpr double step = 2e-3;  // below the finest skin edges, so that the path follows the line
  std::vector<int> path;
  for (std::size_t i = 0; i < polyline.size(); ++i) {
    const Vec3 from = i == 0 ? polyline[0] : polyline[i - 1];
    const int pieces = std::max(1, static_cast<int>(norm(polyline[i] - from) / step));
    for (int k = 1; k <= pieces; ++k) {
      const Vec3 p = from + (static_cast<double>(k) / pieces) * (polyline[i] - from);
      const int vertex = nearest_vertex(skin.mesh, p);
      if (path.empty()) {
        path.push_back(vertex);
      } else if (vertex != path.back()) {
        const auto way = shortest_path(skin.mesh, near, path.back(), vertex);
        path.insert(path.end(), way.begin(), way.end());
      }
    }
  }
  // Going back to a vertex already passed is no part of a line: cut such loops out.
  std::vector<int> line;
  for (const int v : path) {
    line.erase(std::ranges::find(line, v), line.end());
    line.push_back(v);
  }
  for (int& v : line) {
    v = skin.vertex[v];
  }
  return line;
}

}  // namespace sanatrix::surgery
