// Tetrahedral meshes of bars, wedges and balls for the healing tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::testing {

/// A lattice of nx x ny x nz boxes, six tetrahedra each around the diagonal that leads away from
/// the origin, with its vertices moved by `place`.
inline TetMesh lattice(std::array<int, 3> n, const std::function<Vec3(int, int, int)>& place) {
  TetMesh mesh;
  const auto vertex = [&](std::array<int, 3> p) {
    return (p[2] * (n[1] + 1) + p[1]) * (n[0] + 1) + p[0];
  };
  for (int k = 0; k <= n[2]; ++k) {
    for (int j = 0; j <= n[1]; ++j) {
      for (int i = 0; i <= n[0]; ++i) {
        mesh.points.push_back(place(i, j, k));
      }
    }
  }
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        std::array<int, 3> axis{0, 1, 2};
        do {
          std::array<int, 3> corner{i, j, k};
          std::array<int, 4> cell{vertex(corner)};
          for (int step = 0; step < 3; ++step) {
            ++corner[axis[step]];
            cell[step + 1] = vertex(corner);
          }
          if (volume(mesh.points[cell[0]], mesh.points[cell[1]], mesh.points[cell[2]],
                     mesh.points[cell[3]]) < 0.0) {
            std::swap(cell[2], cell[3]);
          }
          mesh.cells.push_back(cell);
        } while (std::ranges::next_permutation(axis).found);
      }
    }
  }
  mesh.region.assign(mesh.cells.size(), 0);
  mesh.region_names = {"tissue"};
  return mesh;
}

/// One row of boxes along x.
inline TetMesh bar(int boxes, double length, double width) {
  return lattice({boxes, 1, 1}, [=](int i, int j, int k) {
    return Vec3{i * length / boxes, j * width, k * width};
  });
}

/// The octant x, y, z >= 0 of a ball; vertices lie on spheres of the given ascending radii, of
/// which the first is 0. Symmetry planes are where no flux passes, so it stands for the whole ball.
inline TetMesh ball_octant(const std::vector<double>& radii) {
  const int n = static_cast<int>(radii.size()) - 1;
  return lattice({n, n, n}, [&](int i, int j, int k) {
    const Vec3 direction{1.0 * i, 1.0 * j, 1.0 * k};
    const double r = norm(direction);
    return r == 0.0 ? direction : (radii[std::max({i, j, k})] / r) * direction;
  });
}

/// Radii with `layers` equal layers up to the wound's radius and growing ones up to the outer one.
inline std::vector<double> graded_radii(double wound, int layers, double outer, double growth) {
  std::vector<double> radii;
  for (int k = 0; k <= layers; ++k) {
    radii.push_back(k * wound / layers);
  }
  for (double h = wound / layers; radii.back() < outer;) {
    h *= growth;
    radii.push_back(radii.back() + h > outer - 0.5 * h ? outer : radii.back() + h);
  }
  return radii;
}

/// Centroid of a cell.
inline Vec3 centroid(const TetMesh& mesh, std::size_t c) {
  Vec3 sum{};
  for (const int v : mesh.cells[c]) {
    sum += 0.25 * mesh.points[v];
  }
  return sum;
}

/// 1 where inside(centroid), else 0.
inline std::vector<double> wound_where(const TetMesh& mesh,
                                       const std::function<bool(const Vec3&)>& inside) {
  std::vector<double> fraction;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    fraction.push_back(inside(centroid(mesh, c)) ? 1.0 : 0.0);
  }
  return fraction;
}

}  // namespace sanatrix::testing
