// Meshes of one eighth of a ball by Gmsh, for tests whose solution is spherically symmetric.
#pragma once

#include <cmath>
#include <vector>

#include <gmsh.h>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::testing {

/// Octant x, y, z >= 0 of concentric spheres with the given radii [m], innermost first. Region i is
/// "shell<i>", boundaries "x0", "y0", "z0" (symmetry planes) and "outer". Edge lengths [m]: `near`
/// up to the first radius, growing to `far` at the last.
inline TetMesh octant_mesh(const std::vector<double>& radii, double near, double far) {
  gmsh::initialize();
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::model::add("octant");
  std::vector<std::pair<int, int>> balls;
  for (const double r : radii) {
    balls.emplace_back(3, gmsh::model::occ::addSphere(0, 0, 0, r, -1, 0, 0.5 * M_PI, 0.5 * M_PI));
  }
  std::vector<std::pair<int, int>> parts{balls.front()};
  if (balls.size() > 1) {
    std::vector<std::vector<std::pair<int, int>>> map;
    gmsh::model::occ::fragment({balls.back()}, {balls.begin(), balls.end() - 1}, parts, map);
  }
  gmsh::model::occ::synchronize();
  const int size = gmsh::model::mesh::field::add("MathEval");
  const double slope = radii.size() > 1 ? (far - near) / (radii.back() - radii.front()) : 0.0;
  gmsh::model::mesh::field::setString(size, "F",
                                      std::to_string(near) + "+" + std::to_string(slope) +
                                          "*max(0,sqrt(x*x+y*y+z*z)-" +
                                          std::to_string(1.05 * radii.front()) + ")");
  gmsh::model::mesh::field::setAsBackgroundMesh(size);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  gmsh::model::mesh::generate(3);

  TetMesh mesh;
  std::vector<std::size_t> tags;
  std::vector<double> coordinates;
  std::vector<double> parametric;
  gmsh::model::mesh::getNodes(tags, coordinates, parametric);
  std::vector<int> index(*std::max_element(tags.begin(), tags.end()) + 1, -1);
  std::vector<std::size_t> cell_tags;
  std::vector<std::size_t> cell_nodes;
  gmsh::model::mesh::getElementsByType(4, cell_tags, cell_nodes);
  std::vector<bool> used(index.size(), false);
  for (const std::size_t n : cell_nodes) {
    used[n] = true;
  }
  for (std::size_t i = 0; i < tags.size(); ++i) {
    if (used[tags[i]]) {
      index[tags[i]] = static_cast<int>(mesh.points.size());
      mesh.points.push_back({coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]});
    }
  }
  for (std::size_t s = 0; s < radii.size(); ++s) {
    mesh.region_names.push_back("shell" + std::to_string(s));
  }
  for (std::size_t c = 0; c < cell_tags.size(); ++c) {
    std::array<int, 4> cell{};
    double r = 0.0;
    Vec3 centre{};
    for (std::size_t v = 0; v < 4; ++v) {
      cell[v] = index[cell_nodes[4 * c + v]];
      centre += 0.25 * mesh.points[static_cast<std::size_t>(cell[v])];
    }
    r = norm(centre);
    int region = 0;
    while (region + 1 < static_cast<int>(radii.size()) &&
           r > radii[static_cast<std::size_t>(region)]) {
      ++region;
    }
    mesh.cells.push_back(cell);
    mesh.region.push_back(region);
  }
  gmsh::finalize();

  check_and_orient(mesh, "octant");
  mesh.boundary_names = {"x0", "y0", "z0", "outer"};
  for (const auto& face : boundary_of(mesh)) {
    int name = 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bool on_plane = true;
      for (const int v : face) {
        on_plane = on_plane && std::abs(mesh.points[static_cast<std::size_t>(v)][axis]) < 1e-9;
      }
      name = on_plane ? static_cast<int>(axis) : name;
    }
    mesh.faces.push_back({face, name});
  }
  return mesh;
}

/// Supports of the symmetry planes: bit i where the plane of axis i passes.
inline std::vector<std::uint8_t> symmetry_supports(const TetMesh& mesh) {
  std::vector<std::uint8_t> fixed(mesh.points.size(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int v : vertices_on(mesh, mesh.boundary_names[static_cast<std::size_t>(axis)])) {
      fixed[static_cast<std::size_t>(v)] |= static_cast<std::uint8_t>(1 << axis);
    }
  }
  return fixed;
}

}  // namespace sanatrix::testing
