// Follows the edges between patches and measures how close they come to each other.
#include "meshing/patch_curves.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace sanatrix::meshing {
namespace {

class CurveFinder {
 public:
  explicit CurveFinder(const DomainSurface& surface) {
    std::map<std::pair<int, int>, std::set<Patch>> edges;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i) {
        edges[std::minmax(surface.triangles[t][i], surface.triangles[t][(i + 1) % 3])].insert(
            surface.patch[t]);
      }
    }
    for (const auto& [edge, patches] : edges) {
      if (patches.size() > 1) {
        patches_[edge] = patches;
        next_[edge.first].insert(edge.second);
        next_[edge.second].insert(edge.first);
      }
    }
    open_ = patches_;
  }

  std::vector<PatchCurve> find() {
    std::vector<PatchCurve> curves;
    for (const auto& [vertex, neighbours] : next_) {
      if (is_end(vertex)) {
        for (const int n : neighbours) {
          if (open_.contains(std::minmax(vertex, n))) {
            curves.push_back(follow(vertex, n));
          }
        }
      }
    }
    while (!open_.empty()) {  // what remains are closed loops
      const auto [a, b] = open_.begin()->first;
      curves.push_back(follow(a, b));
    }
    return curves;
  }

 private:
  /// Does a curve end here: three patches or more, or another pair of patches goes on?
  [[nodiscard]] bool is_end(int vertex) const {
    const auto& n = next_.at(vertex);
    return n.size() != 2 || patches_.at(std::minmax(vertex, *n.begin())) !=
                                patches_.at(std::minmax(vertex, *n.rbegin()));
  }
  PatchCurve follow(int from, int to) {
    PatchCurve curve{.vertices = {from}, .patches = patches_.at(std::minmax(from, to))};
    const int start = from;
    for (;;) {
      open_.erase(std::minmax(from, to));
      curve.vertices.push_back(to);
      if (is_end(to) || to == start) {
        return curve;
      }
      const auto& n = next_.at(to);
      const int on = *n.begin() == from ? *n.rbegin() : *n.begin();
      from = std::exchange(to, on);
    }
  }

  std::map<std::pair<int, int>, std::set<Patch>> patches_;
  std::map<std::pair<int, int>, std::set<Patch>> open_;  ///< not yet on a curve
  std::map<int, std::set<int>> next_;
};

std::vector<Vec3> points_of(const DomainSurface& surface, const PatchCurve& curve) {
  std::vector<Vec3> points;
  for (const int v : curve.vertices) {
    points.push_back(surface.points_mm[static_cast<std::size_t>(v)]);
  }
  return points;
}

double length(const std::vector<Vec3>& points) {
  double sum = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    sum += norm(points[i] - points[i - 1]);
  }
  return sum;
}

}  // namespace

std::vector<PatchCurve> find_curves(const DomainSurface& surface) {
  return CurveFinder(surface).find();
}

double clearance_mm(const DomainSurface& surface, const std::vector<PatchCurve>& curves,
                    const Deadline& deadline) {
  // Curves leave a common end at an angle, so they are compared beyond this distance from it.
  constexpr double around_end_mm = 6.0;
  double least = 1e9;
  std::vector<std::vector<Vec3>> points;
  for (const PatchCurve& curve : curves) {
    points.push_back(points_of(surface, curve));
    least = std::min(least, length(points.back()) / 3.0);
  }
  for (std::size_t i = 0; i < curves.size(); ++i) {
    deadline.check();
    for (std::size_t j = 0; j < i; ++j) {
      std::vector<Vec3> ends;
      for (const Vec3& p : {points[i].front(), points[i].back()}) {
        if (p == points[j].front() || p == points[j].back()) {
          ends.push_back(p);
        }
      }
      const auto at_end = [&](const Vec3& p) {
        return std::any_of(ends.begin(), ends.end(),
                           [&](const Vec3& e) { return norm(p - e) < around_end_mm; });
      };
      for (const Vec3& p : points[i]) {
        if (at_end(p)) {
          continue;
        }
        for (const Vec3& q : points[j]) {
          if (const Vec3 r = p - q; dot(r, r) < least * least && !at_end(q)) {
            least = norm(r);
          }
        }
      }
    }
  }
  return least;
}

}  // namespace sanatrix::meshing
