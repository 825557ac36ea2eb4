// The P2 basis on the lattice points of cells and faces.
#include "phantom/quadratic_cells.hpp"

#include <algorithm>

namespace sanatrix::phantom {
namespace {

constexpr int parts = 3;  // of a cell's edge: chords of a curved edge then err by less than 0.1 mm

}  // namespace

QuadraticCells::QuadraticCells(const TetMesh& mesh, std::span<const std::array<int, 2>> edges)
    : mesh_(mesh), lattice_(parts) {
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [a, b] = std::minmax(edges[e][0], edges[e][1]);
    edge_node_[{a, b}] = mesh.points.size() + e;
  }
}

std::size_t QuadraticCells::middle(int a, int b) const {
  return edge_node_.at({std::min(a, b), std::max(a, b)});
}

std::vector<Vec3> QuadraticCells::lattice_points(std::size_t cell,
                                                 std::span<const Vec3> nodes) const {
  const auto& v = mesh_.cells[cell];
  std::vector<Vec3> points;
  for (const auto& w : lattice_.weights) {
    Vec3 x{};
    for (std::size_t i = 0; i < 4; ++i) {
      x += w[i] * (2.0 * w[i] - 1.0) * nodes[static_cast<std::size_t>(v[i])];
      for (std::size_t j = 0; j < i; ++j) {
        x += 4.0 * w[i] * w[j] * nodes[middle(v[i], v[j])];
      }
    }
    points.push_back(x);
  }
  return points;
}

TriMesh QuadraticCells::boundary(const std::string& name, std::span<const Vec3> nodes) const {
  TriMesh surface;
  const int index = boundary_index(mesh_, name);
  for (const BoundaryFace& face : mesh_.faces) {
    if (face.name == index) {
      add_face(face.vertex, nodes, surface);
    }
  }
  return surface;
}

void QuadraticCells::add_face(const std::array<int, 3>& face, std::span<const Vec3> nodes,
                              TriMesh& surface) const {
  std::map<std::array<int, 2>, int> number;
  for (int a = 0; a <= parts; ++a) {
    for (int b = 0; b + a <= parts; ++b) {
      const std::array<double, 3> w{1.0 - static_cast<double>(a + b) / parts,
                                    static_cast<double>(a) / parts, static_cast<double>(b) / parts};
      Vec3 x{};
      for (std::size_t i = 0; i < 3; ++i) {
        x += w[i] * (2.0 * w[i] - 1.0) * nodes[static_cast<std::size_t>(face[i])];
        x += 4.0 * w[i] * w[(i + 1) % 3] * nodes[middle(face[i], face[(i + 1) % 3])];
      }
      number[{a, b}] = static_cast<int>(surface.points.size());
      surface.points.push_back(x);
    }
  }
  for (const auto& [at, first] : number) {
    const auto [a, b] = at;
    if (a + b < parts) {
      surface.triangles.push_back({first, number[{a + 1, b}], number[{a, b + 1}]});
    }
    if (a + b + 1 < parts) {
      surface.triangles.push_back({number[{a + 1, b}], number[{a + 1, b + 1}], number[{a, b + 1}]});
    }
  }
}

}  // namespace sanatrix::phantom
