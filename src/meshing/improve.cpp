// Pattern search for better vertex positions around flat tetrahedra.
#include "meshing/improve.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "geometry/distance.hpp"

namespace sanatrix::meshing {
namespace {

/// Cosine of the smallest dihedral angle, or 2 for an inverted cell: smaller is better.
double flatness(const std::array<Vec3, 4>& x) {
  if (volume(x[0], x[1], x[2], x[3]) <= 0.0) {
    return 2.0;
  }
  std::array<Vec3, 4> normal{};  // outwards, opposite to each vertex
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& a = x[(i + 1) % 4];
    normal[i] = cross(x[(i + 2) % 4] - a, x[(i + 3) % 4] - a);
    const double towards = dot(normal[i], x[i] - a);
    normal[i] = (towards > 0.0 ? -1.0 : 1.0) / norm(normal[i]) * normal[i];
  }
  double worst = -1.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      worst = std::max(worst, -dot(normal[i], normal[j]));
    }
  }
  return worst;
}

class Mover {
 public:
  Mover(Tetrahedra& mesh, const DomainSurface& surface, double bound_deg)
      : mesh_(mesh),
        patches_(mesh.points_mm.size()),
        star_(mesh.points_mm.size()),
        bound_(std::cos(bound_deg * std::numbers::pi / 180.0)) {
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      for (const int v : mesh.cells[c]) {
        star_[static_cast<std::size_t>(v)].push_back(c);
      }
    }
    for (const auto& face : mesh.faces) {
      for (const int v : face.vertex) {
        patches_[static_cast<std::size_t>(v)].insert(face.patch);
      }
    }
    std::map<Patch, TriMesh> part;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      TriMesh& tri = part[surface.patch[t]];
      const int n = static_cast<int>(tri.points.size());
      for (const int v : surface.triangles[t]) {
        tri.points.push_back(surface.points_mm[static_cast<std::size_t>(v)]);
      }
      tri.triangles.push_back({n, n + 1, n + 2});
    }
    for (const auto& [patch, tri] : part) {
      tree_.emplace(patch, SurfaceTree(tri));
    }
  }

  /// One pass over the flat cells; true when something moved.
  bool sweep() {
    bool moved = false;
    for (const auto& cell : mesh_.cells) {
      if (flatness(corners(cell)) > bound_) {
        for (const int v : cell) {
          moved = improve(static_cast<std::size_t>(v)) || moved;
        }
      }
    }
    return moved;
  }

 private:
  [[nodiscard]] std::array<Vec3, 4> corners(const std::array<int, 4>& cell) const {
    const auto& p = mesh_.points_mm;
    return {p[static_cast<std::size_t>(cell[0])], p[static_cast<std::size_t>(cell[1])],
            p[static_cast<std::size_t>(cell[2])], p[static_cast<std::size_t>(cell[3])]};
  }
  [[nodiscard]] double star_flatness(std::size_t v) const {
    double worst = -1.0;
    for (const std::size_t c : star_[v]) {
      worst = std::max(worst, flatness(corners(mesh_.cells[c])));
    }
    return worst;
  }
  [[nodiscard]] double shortest_edge(std::size_t v) const {
    double least = 1e9;
    for (const std::size_t c : star_[v]) {
      for (const int w : mesh_.cells[c]) {
        if (static_cast<std::size_t>(w) != v) {
          least = std::min(least, norm(mesh_.points_mm[static_cast<std::size_t>(w)] -
                                       mesh_.points_mm[v]));
        }
      }
    }
    return least;
  }
  /// Back onto the vertex's patch; nothing where patches meet.
  [[nodiscard]] std::optional<Vec3> allowed(std::size_t v, const Vec3& p) const {
    if (patches_[v].empty()) {
      return p;
    }
    if (patches_[v].size() > 1) {
      return std::nullopt;
    }
    return tree_.at(*patches_[v].begin()).closest(p).point;
  }

  bool improve(std::size_t v) {
    const double before = star_flatness(v);
    double best = before;
    double step = 0.3 * shortest_edge(v);
    // Below a fiftieth of the edge a move changes no angle noticeably.
    for (const double stop = step / 16.0; step > stop; step *= 0.5) {
      for (bool better = true; better;) {
        better = false;
        const Vec3 here = mesh_.points_mm[v];
        Vec3 best_place = here;
        for (const Vec3& d : directions) {
          const auto place = allowed(v, here + step * d);
          if (!place) {
            return false;
          }
          mesh_.points_mm[v] = *place;
          if (const double value = star_flatness(v); value < best - 1e-4) {
            best = value;
            best_place = *place;
            better = true;
          }
        }
        mesh_.points_mm[v] = best_place;
      }
    }
    return best < before;
  }

  static constexpr std::array<Vec3, 14> directions{
      {{1, 0, 0},
       {-1, 0, 0},
       {0, 1, 0},
       {0, -1, 0},
       {0, 0, 1},
       {0, 0, -1},
       {0.577, 0.577, 0.577},
       {0.577, 0.577, -0.577},
       {0.577, -0.577, 0.577},
       {0.577, -0.577, -0.577},
       {-0.577, 0.577, 0.577},
       {-0.577, 0.577, -0.577},
       {-0.577, -0.577, 0.577},
       {-0.577, -0.577, -0.577}}};

  Tetrahedra& mesh_;
  std::vector<std::set<Patch>> patches_;  ///< per vertex
  std::vector<std::vector<std::size_t>> star_;
  std::map<Patch, SurfaceTree> tree_;
  double bound_;
};

}  // namespace

void move_vertices_of_flat_cells(Tetrahedra& mesh, const DomainSurface& surface, double bound_deg) {
  Mover mover(mesh, surface, bound_deg);
  for (int sweep = 0; sweep < 10 && mover.sweep(); ++sweep) {
  }
}

}  // namespace sanatrix::meshing
