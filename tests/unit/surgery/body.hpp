// Bodies with known geometry for surgery tests: grids of tetrahedra between a chest and a skin.
#pragma once

#include <cmath>
#include <functional>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::testing {

/// Tetrahedra over x, z in [-half_width, half_width] + centre between the chest at y = 0 and the
/// skin at y = -height(x, z); edges of about `edge`. [m]
inline TetMesh body_under(const std::function<double(double, double)>& height, double half_width,
                          double max_height, double edge) {
  const int n = static_cast<int>(std::ceil(2.0 * half_width / edge));
  const int layers = static_cast<int>(std::ceil(max_height / edge));
  TetMesh mesh;
  mesh.region_names = {"breast"};
  mesh.boundary_names = {"skin", "chest"};
  const auto vertex = [n, layers](int i, int j, int k) {
    return (i * (n + 1) + j) * (layers + 1) + k;
  };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double x = half_width * (2.0 * i / n - 1.0), z = half_width * (2.0 * j / n - 1.0);
      for (int k = 0; k <= layers; ++k) {
        mesh.points.push_back({x, -height(x, z) * k / layers, z});
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < layers; ++k) {
        // Kuhn's six tetrahedra of a box: one per order in which the three steps are taken.
        for (const std::array<int, 3>& order :
             {std::array{0, 1, 2}, std::array{0, 2, 1}, std::array{1, 0, 2}, std::array{1, 2, 0},
              std::array{2, 0, 1}, std::array{2, 1, 0}}) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> cell{vertex(i, j, k), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(order[step])];
            cell[step + 1] = vertex(at[0], at[1], at[2]);
          }
          mesh.cells.push_back(cell);
          mesh.region.push_back(0);
        }
      }
    }
  }
  check_and_orient(mesh, "test body");
  for (const auto& face : boundary_of(mesh)) {
    const auto all_in_layer = [&](int layer) {
      return face[0] % (layers + 1) == layer && face[1] % (layers + 1) == layer &&
             face[2] % (layers + 1) == layer;
    };
    if (all_in_layer(layers)) {
      mesh.faces.push_back({face, 0});
    } else if (all_in_layer(0)) {
      mesh.faces.push_back({face, 1});
    }
  }
  return mesh;
}

/// Moves the whole body.
inline TetMesh moved(TetMesh mesh, const Mat3& rotation, const Vec3& shift) {
  for (Vec3& p : mesh.points) {
    p = rotation * p + shift;
  }
  return mesh;
}

}  // namespace sanatrix::testing
