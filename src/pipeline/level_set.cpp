#include "pipeline/level_set.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace sanatrix::pipeline {
namespace {

class March {
 public:
  March(std::span<const Vec3> points, std::span<const double> field, double level)
      : points_(points), field_(field), level_(level) {}

  void visit(const std::array<int, 4>& cell) {
    const auto is_above = [this](int vertex) {
      return value(vertex) > 0;
    };
    if (std::ranges::all_of(cell, is_above) || std::ranges::none_of(cell, is_above)) {
      return;  // most cells
    }
    std::vector<int> above, below;
    for (const int vertex : cell) {
      (value(vertex) > 0 ? above : below).push_back(vertex);
    }
    if (above.size() == 1 || below.size() == 1) {
      const int tip = above.size() == 1 ? above[0] : below[0];
      const std::vector<int>& base = above.size() == 1 ? below : above;
      add({cut(tip, base[0]), cut(tip, base[1]), cut(tip, base[2])}, above[0]);
    } else if (above.size() == 2) {
      const int a = cut(above[0], below[0]), b = cut(above[0], below[1]);
      const int c = cut(above[1], below[1]), d = cut(above[1], below[0]);
      add({a, b, c}, above[0]);
      add({a, c, d}, above[0]);
    }
  }
  TriMesh take() { return std::move(surface_); }

 private:
  [[nodiscard]] double value(int vertex) const {
    return field_[static_cast<std::size_t>(vertex)] - level_;
  }
  [[nodiscard]] const Vec3& point(int vertex) const {
    return points_[static_cast<std::size_t>(vertex)];
  }
  [[nodiscard]] const Vec3& made(int number) const {
    return surface_.points[static_cast<std::size_t>(number)];
  }
  /// Number of the point where the edge meets the level.
  int cut(int i, int j) {
    const auto [entry, is_new] =
        cuts_.try_emplace(std::minmax(i, j), static_cast<int>(surface_.points.size()));
    if (is_new) {
      const double s = value(i) / (value(i) - value(j));
      surface_.points.push_back(point(i) + s * (point(j) - point(i)));
    }
    return entry->second;
  }
  /// Oriented away from a vertex above the level.
  void add(std::array<int, 3> t, int above) {
    const Vec3 normal = cross(made(t[1]) - made(t[0]), made(t[2]) - made(t[0]));
    if (dot(normal, point(above) - made(t[0])) > 0) {
      std::swap(t[1], t[2]);
    }
    surface_.triangles.push_back(t);
  }

  std::span<const Vec3> points_;
  std::span<const double> field_;
  double level_;
  std::map<std::pair<int, int>, int> cuts_;
  TriMesh surface_;
};

}  // namespace

TriMesh level_set(const TetMesh& mesh, std::span<const Vec3> points, std::span<const double> field,
                  double level) {
  March march(points, field, level);
  for (const auto& cell : mesh.cells) {
    march.visit(cell);
  }
  return march.take();
}

std::vector<double> to_vertices(const TetMesh& mesh, std::span<const Vec3> points,
                                std::span<const double> cell_values) {
  const std::vector<double> volume = cell_volumes(mesh, points);
  std::vector<double> sum(points.size(), 0.0), weight(points.size(), 0.0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const int vertex : mesh.cells[c]) {
      sum[static_cast<std::size_t>(vertex)] += volume[c] * cell_values[c];
      weight[static_cast<std::size_t>(vertex)] += volume[c];
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    sum[v] /= weight[v];
  }
  return sum;
}

}  // namespace sanatrix::pipeline
