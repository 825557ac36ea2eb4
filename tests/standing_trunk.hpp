// A trunk of formulas with two breasts, as a scanner sees it from the front.
#pragma once

#include <cmath>

#include "geometry/rigid.hpp"
#include "geometry/textured_surface.hpp"

namespace sanatrix::testing {

/// Front of an elliptic trunk with two breasts whose upper poles are longer than their lower ones.
struct Trunk {
  double rise_mm = 50.0;
  Vec3 hole_mm{1e3, 0, 0};
  double hole_radius_mm = 0.0;
  double left_share = 1.0;  ///< of the left breast's rise
  bool left_arm = false;    ///< hangs 20 mm beside the trunk
  bool back = false;

  static double chest(double x) { return 100 - 100 * std::sqrt(1 - x * x / (160 * 160)); }
  [[nodiscard]] double bump(double x, double z) const {
    const double across = (std::abs(x) - 85) / 36, along = z / (z > 0 ? 52 : 30);
    return (x > 0 ? left_share : 1.0) * rise_mm *
           std::exp(-0.5 * (across * across + along * along));
  }
  [[nodiscard]] TriMesh scan() const {
    TriMesh mesh;
    add_patch(mesh, 75, 81, [&](int i, int k) {
      const double x = 4.0 * (i - 37), z = 4.0 * (k - 40);
      return Vec3{x, chest(x) - bump(x, z), z};
    });
    std::erase_if(mesh.triangles, [&](const auto& t) {
      const Vec3& p = mesh.points[static_cast<std::size_t>(t[0])];
      return std::hypot(1e3 * p[0] - hole_mm[0], 1e3 * p[2] - hole_mm[2]) < hole_radius_mm;
    });
    if (left_arm) {
      add_patch(mesh, 31, 60, [](int i, int k) {
        const double turn = 0.1 * (i - 15);
        return Vec3{200 + 32 * std::sin(turn), 70 - 32 * std::cos(turn), 4.0 * (k - 24)};
      });
    }
    if (back) {
      add_patch(mesh, 75, 81, [](int i, int k) {
        const double x = 4.0 * (37 - i);
        return Vec3{x, 200 - chest(x), 4.0 * (k - 40)};
      });
    }
    return mesh;
  }

 private:
  /// Points [mm] of a grid; normals are first index x second index, backwards.
  template <class F>
  static void add_patch(TriMesh& mesh, int nx, int nz, F&& point_mm) {
    const int first = static_cast<int>(mesh.points.size());
    for (int k = 0; k < nz; ++k) {
      for (int i = 0; i < nx; ++i) {
        mesh.points.push_back(1e-3 * point_mm(i, k));
      }
    }
    for (int k = 0; k + 1 < nz; ++k) {
      for (int i = 0; i + 1 < nx; ++i) {
        const int a = first + k * nx + i;
        mesh.triangles.push_back({a, a + 1, a + nx});
        mesh.triangles.push_back({a + 1, a + nx + 1, a + nx});
      }
    }
  }
};

inline TexturedSurface plain(TriMesh mesh) {
  TexturedSurface surface;
  surface.mesh = std::move(mesh);
  return surface;
}

inline Rigid some_pose(double turn) {
  const double c = std::cos(turn), s = std::sin(turn);
  const Mat3 about_z{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}},
      about_x{{{1, 0, 0}, {0, c, -s}, {0, s, c}}};
  return {about_z * about_x, {0.3, -1.1, 0.7}};
}

}  // namespace sanatrix::testing
