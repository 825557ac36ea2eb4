// Peels flat cells off smooth patches and searches better vertex positions around the others.
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
  bool sweep(const Deadline& deadline) {
    bool moved = false;
    for (const auto& cell : mesh_.cells) {
      if (flatness(corners(cell)) > bound_) {
        deadline.check();
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
          least = std::min(least,
                           norm(mesh_.points_mm[static_cast<std::size_t>(w)] - mesh_.points_mm[v]));
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

  static constexpr std::array<Vec3, 14> directions{{{1, 0, 0},
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

/// Three sorted vertices.
std::array<int, 3> key_of(std::array<int, 3> face) {
  std::sort(face.begin(), face.end());
  return face;
}

/// Cells that lie flat on a patch with two faces on it: without them the patch is as good.
class Peeler {
 public:
  Peeler(Tetrahedra& mesh, double bound_deg)
      : mesh_(mesh), bound_(std::cos(bound_deg * std::numbers::pi / 180.0)) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      faces_[key_of(mesh.faces[f].vertex)] = f;
      for (std::size_t i = 0; i < 3; ++i) {
        edges_.insert(std::minmax(mesh.faces[f].vertex[i], mesh.faces[f].vertex[(i + 1) % 3]));
      }
    }
  }

  void peel() {
    std::vector<std::array<int, 4>> kept;
    for (const auto& cell : mesh_.cells) {
      if (!peel(cell)) {
        kept.push_back(cell);
      }
    }
    mesh_.cells.swap(kept);
  }

 private:
  bool peel(const std::array<int, 4>& cell) {
    std::array<Vec3, 4> x{};
    std::vector<std::size_t> inner;     // vertices opposite to faces inside
    std::vector<std::size_t> boundary;  // numbers of the faces on the boundary
    for (std::size_t i = 0; i < 4; ++i) {
      x[i] = mesh_.points_mm[static_cast<std::size_t>(cell[i])];
      const auto face =
          faces_.find(key_of({cell[(i + 1) % 4], cell[(i + 2) % 4], cell[(i + 3) % 4]}));
      if (face == faces_.end()) {
        inner.push_back(i);
      } else {
        boundary.push_back(face->second);
      }
    }
    if (boundary.size() != 2 || flatness(x) < bound_ ||
        mesh_.faces[boundary[0]].patch != mesh_.faces[boundary[1]].patch) {
      return false;
    }
    // The two inner faces share the edge between the vertices opposite to the boundary faces.
    std::array<int, 2> fresh{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (std::find(inner.begin(), inner.end(), i) == inner.end()) {
        fresh[n++] = cell[i];
      }
    }
    if (!edges_.insert(std::minmax(fresh[0], fresh[1])).second) {
      return false;  // the edge is on the boundary already: it would be pinched
    }
    const int a = cell[inner[0]];
    const int b = cell[inner[1]];
    edges_.erase(std::minmax(a, b));
    replace(boundary[0], {a, fresh[0], fresh[1]}, b);
    replace(boundary[1], {b, fresh[0], fresh[1]}, a);
    return true;
  }

  /// Puts another face in the place of one, oriented away from the rest of the mesh: towards the
  /// cell's fourth vertex, which is outside now.
  void replace(std::size_t f, std::array<int, 3> vertex, int outside) {
    const auto& p = mesh_.points_mm;
    const auto at = [&](int v) {
      return p[static_cast<std::size_t>(v)];
    };
    if (volume(at(vertex[0]), at(vertex[1]), at(vertex[2]), at(outside)) < 0.0) {
      std::swap(vertex[1], vertex[2]);
    }
    faces_.erase(key_of(mesh_.faces[f].vertex));
    mesh_.faces[f].vertex = vertex;
    faces_[key_of(vertex)] = f;
  }

  Tetrahedra& mesh_;
  std::map<std::array<int, 3>, std::size_t> faces_;  ///< by sorted vertices
  std::set<std::pair<int, int>> edges_;              ///< of the boundary
  double bound_;
};

}  // namespace

void peel_flat_cells(Tetrahedra& mesh, double bound_deg) {
  Peeler(mesh, bound_deg).peel();
}

void move_vertices_of_flat_cells(Tetrahedra& mesh, const DomainSurface& surface, double bound_deg,
                                 const Deadline& deadline) {
  Mover mover(mesh, surface, bound_deg);
  for (int sweep = 0; sweep < 10 && mover.sweep(deadline); ++sweep) {
  }
}

}  // namespace sanatrix::meshing
