// A box of tetrahedra (six per brick), for tests.
#pragma once

#include <array>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::testing {

/// [0, size_i] with n_i bricks along axis i. Boundaries "x0", "x1", "y0", "y1", "z0", "z1".
inline TetMesh block_mesh(const Vec3& size, const std::array<int, 3>& n) {
  TetMesh mesh;
  const auto id = [&](int i, int j, int k) {
    return (k * (n[1] + 1) + j) * (n[0] + 1) + i;
  };
  for (int k = 0; k <= n[2]; ++k) {
    for (int j = 0; j <= n[1]; ++j) {
      for (int i = 0; i <= n[0]; ++i) {
        mesh.points.push_back({size[0] * i / n[0], size[1] * j / n[1], size[2] * k / n[2]});
      }
    }
  }
  // Kuhn's subdivision: one tetrahedron per path along the axes from corner 000 to corner 111.
  constexpr std::array<std::array<int, 3>, 6> paths{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        for (const auto& path : paths) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> cell{id(i, j, k), 0, 0, 0};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[static_cast<std::size_t>(path[s])];
            cell[s + 1] = id(at[0], at[1], at[2]);
          }
          mesh.cells.push_back(cell);
          mesh.region.push_back(0);
        }
      }
    }
  }
  mesh.region_names = {"block"};
  check_and_orient(mesh, "block");
  mesh.boundary_names = {"x0", "x1", "y0", "y1", "z0", "z1"};
  for (const auto& face : boundary_of(mesh)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int end = 0; end < 2; ++end) {
        bool on_it = true;
        for (const int v : face) {
          const double target = end == 0 ? 0.0 : size[axis];
          on_it =
              on_it && std::abs(mesh.points[static_cast<std::size_t>(v)][axis] - target) < 1e-12;
        }
        if (on_it) {
          mesh.faces.push_back({face, static_cast<int>(2 * axis) + end});
        }
      }
    }
  }
  return mesh;
}

}  // namespace sanatrix::testing
