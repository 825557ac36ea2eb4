// Measures, boundary and checks of tetrahedral meshes.
#include "geometry/tet_mesh.hpp"

#include <algorithm>
#include <numbers>

#include "core/error.hpp"

namespace sanatrix {
namespace {

/// Faces of a positive tetrahedron, each seen anticlockwise from outside; face i is opposite vertex
/// i.
constexpr std::array<std::array<std::size_t, 3>, 4> cell_faces{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A face by its vertices in ascending order, with the orientation one cell gives it.
struct CellFace {
  std::array<int, 3> key, oriented;
};

std::array<int, 3> ascending(std::array<int, 3> face) {
  std::sort(face.begin(), face.end());
  return face;
}

/// All faces of all cells, equal faces side by side.
std::vector<CellFace> sorted_cell_faces(const TetMesh& mesh) {
  std::vector<CellFace> faces;
  faces.reserve(4 * mesh.cells.size());
  for (const auto& cell : mesh.cells) {
    for (const auto& [a, b, c] : cell_faces) {
      const std::array<int, 3> face{cell[a], cell[b], cell[c]};
      faces.push_back({ascending(face), face});
    }
  }
  std::sort(faces.begin(), faces.end(),
            [](const CellFace& a, const CellFace& b) { return a.key < b.key; });
  return faces;
}

bool same_turn(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return a == b || a == std::array{b[1], b[2], b[0]} || a == std::array{b[2], b[0], b[1]};
}

/// Named faces must be faces of cells; those on the boundary are turned outwards.
void orient_faces(TetMesh& mesh, const std::string& where) {
  if (mesh.faces.empty()) {
    return;
  }
  const std::vector<CellFace> all = sorted_cell_faces(mesh);
  for (BoundaryFace& face : mesh.faces) {
    const auto [first, last] =
        std::equal_range(all.begin(), all.end(), CellFace{ascending(face.vertex), {}},
                         [](const CellFace& a, const CellFace& b) { return a.key < b.key; });
    require(first != last, "{}: boundary face ({}, {}, {}) is not a face of any tetrahedron", where,
            face.vertex[0], face.vertex[1], face.vertex[2]);
    if (last - first == 1 && !same_turn(face.vertex, first->oriented)) {
      std::swap(face.vertex[1], face.vertex[2]);
    }
  }
}

void check_indices(const TetMesh& mesh, const std::string& where) {
  require(!mesh.cells.empty(), "{}: the mesh has no tetrahedra", where);
  require(mesh.region.size() == mesh.cells.size(), "{}: {} cells but {} region numbers", where,
          mesh.cells.size(), mesh.region.size());
  const int point_count = static_cast<int>(mesh.points.size());
  const auto inside = [&](int v) {
    return v >= 0 && v < point_count;
  };
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    require(std::all_of(mesh.cells[c].begin(), mesh.cells[c].end(), inside),
            "{}: tetrahedron {} names a vertex out of range", where, c);
    require(mesh.region[c] >= 0 && mesh.region[c] < static_cast<int>(mesh.region_names.size()),
            "{}: tetrahedron {} has region number {}, out of range", where, c, mesh.region[c]);
  }
  for (const BoundaryFace& face : mesh.faces) {
    require(std::all_of(face.vertex.begin(), face.vertex.end(), inside) && face.name >= 0 &&
                face.name < static_cast<int>(mesh.boundary_names.size()),
            "{}: a boundary face names a vertex or a boundary out of range", where);
  }
  for (const auto& [name, vertex] : mesh.named_points) {
    require(inside(vertex), "{}: point '{}' is out of range", where, name);
  }
}

void check_points(const TetMesh& mesh, const std::string& where) {
  std::vector<bool> used(mesh.points.size(), false);
  for (const auto& cell : mesh.cells) {
    for (const int v : cell) {
      used[static_cast<std::size_t>(v)] = true;
    }
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    require(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]),
            "{}: vertex {} has no finite position", where, v);
    require(used[v], "{}: vertex {} belongs to no tetrahedron", where, v);
  }
}

std::array<Vec3, 4> corners(const std::array<int, 4>& cell, std::span<const Vec3> points) {
  const auto at = [&](std::size_t i) {
    return points[static_cast<std::size_t>(cell[i])];
  };
  return {at(0), at(1), at(2), at(3)};
}

double longest_edge(const std::array<Vec3, 4>& x) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      longest = std::max(longest, norm(x[i] - x[j]));
    }
  }
  return longest;
}

}  // namespace

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(b - a, cross(c - a, d - a)) / 6.0;
}

std::vector<double> cell_volumes(const TetMesh& mesh, std::span<const Vec3> points) {
  std::vector<double> volumes;
  volumes.reserve(mesh.cells.size());
  for (const auto& cell : mesh.cells) {
    const auto [a, b, c, d] = corners(cell, points);
    volumes.push_back(volume(a, b, c, d));
  }
  return volumes;
}

std::vector<double> min_dihedral_angles(const TetMesh& mesh, std::span<const Vec3> points) {
  std::vector<double> angles;
  angles.reserve(mesh.cells.size());
  for (const auto& cell : mesh.cells) {
    const std::array<Vec3, 4> x = corners(cell, points);
    std::array<Vec3, 4> normal;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& [a, b, c] = cell_faces[f];
      normal[f] = cross(x[b] - x[a], x[c] - x[a]);
    }
    double smallest = std::numbers::pi;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        // atan2 instead of acos: accurate for slivers too.
        const double angle =
            std::atan2(norm(cross(normal[i], normal[j])), -dot(normal[i], normal[j]));
        smallest = std::min(smallest, angle);
      }
    }
    angles.push_back(smallest * 180.0 / std::numbers::pi);
  }
  return angles;
}

std::vector<std::array<int, 3>> boundary_of(const TetMesh& mesh) {
  const std::vector<CellFace> all = sorted_cell_faces(mesh);
  std::vector<std::array<int, 3>> boundary;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t next = i + 1;
    while (next < all.size() && all[next].key == all[i].key) {
      ++next;
    }
    if (next == i + 1) {
      boundary.push_back(all[i].oriented);
    }
    i = next;
  }
  return boundary;
}

std::vector<int> vertices_on(const TetMesh& mesh, const std::string& boundary_name) {
  const int wanted = boundary_index(mesh, boundary_name);
  std::vector<int> vertices;
  for (const BoundaryFace& face : mesh.faces) {
    if (face.name == wanted) {
      vertices.insert(vertices.end(), face.vertex.begin(), face.vertex.end());
    }
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

int boundary_index(const TetMesh& mesh, const std::string& boundary_name) {
  const auto found =
      std::find(mesh.boundary_names.begin(), mesh.boundary_names.end(), boundary_name);
  return found == mesh.boundary_names.end() ? -1
                                            : static_cast<int>(found - mesh.boundary_names.begin());
}

void check_and_orient(TetMesh& mesh, const std::string& where) {
  check_indices(mesh, where);
  check_points(mesh, where);
  for (std::size_t i = 0; i < mesh.cells.size(); ++i) {
    auto& cell = mesh.cells[i];
    const std::array<Vec3, 4> x = corners(cell, mesh.points);
    const double v = volume(x[0], x[1], x[2], x[3]);
    const double size = longest_edge(x);
    // A regular tetrahedron has 0.118 of its edge cubed; at 1e-9 of it rounding decides the sign.
    require(std::abs(v) > 1e-10 * size * size * size,
            "{}: tetrahedron {} is flat (volume {:.3g} m3)", where, i, v);
    if (v < 0) {
      std::swap(cell[2], cell[3]);
    }
  }
  orient_faces(mesh, where);
}

}  // namespace sanatrix
