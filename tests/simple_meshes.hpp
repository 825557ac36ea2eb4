// Small meshes whose measures are known in closed form.
#pragma once

#include <cmath>
#include <numbers>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::testing {

/// A box of n^3 cubes, each cut into six tetrahedra around its diagonal (Kuhn). Boundary "top" is
/// the face at the largest z.
inline TetMesh cube(int n, double size = 1.0) {
  TetMesh mesh;
  mesh.region_names = {"adipose"};
  mesh.boundary_names = {"top"};
  const auto id = [n](int i, int j, int k) {
    return (k * (n + 1) + j) * (n + 1) + i;
  };
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        mesh.points.push_back({size * i / n, size * j / n, size * k / n});
      }
    }
  }
  constexpr int paths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (const auto& path : paths) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> cell{id(i, j, k), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(path[step])];
            cell[step + 1] = id(at[0], at[1], at[2]);
          }
          mesh.cells.push_back(cell);
          mesh.region.push_back(0);
        }
      }
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh.faces.push_back({{id(i, j, n), id(i + 1, j, n), id(i + 1, j + 1, n)}, 0});
      mesh.faces.push_back({{id(i, j, n), id(i, j + 1, n), id(i + 1, j + 1, n)}, 0});
    }
  }
  return mesh;
}

/// A sphere of rings x 2*rings quadrilaterals, cut into triangles, outward.
inline TriMesh sphere(int rings, double radius, const Vec3& centre = {0, 0, 0}) {
  TriMesh mesh;
  const int around = 2 * rings;
  for (int r = 0; r <= rings; ++r) {
    for (int a = 0; a < around; ++a) {
      const double polar = std::numbers::pi * r / rings;
      const double azimuth = 2 * std::numbers::pi * a / around;
      mesh.points.push_back(centre + radius * Vec3{std::sin(polar) * std::cos(azimuth),
                                                   std::sin(polar) * std::sin(azimuth),
                                                   std::cos(polar)});
    }
  }
  for (int r = 0; r < rings; ++r) {
    for (int a = 0; a < around; ++a) {
      const int next = (a + 1) % around;
      if (r > 0) {
        mesh.triangles.push_back({r * around + a, (r + 1) * around + a, r * around + next});
      }
      if (r + 1 < rings) {
        mesh.triangles.push_back(
            {r * around + next, (r + 1) * around + a, (r + 1) * around + next});
      }
    }
  }
  return mesh;
}

/// A flat square of side `size` in the plane z = height, n x n cells, facing +z.
inline TriMesh square(int n, double size, double height) {
  TriMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      mesh.points.push_back({size * i / n, size * j / n, height});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return mesh;
}

}  // namespace sanatrix::testing
