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

  static double chest(double x) { return 100 - 100 * std::sqrt(1 - x * x / (160 * 160)); }
  [[nodiscard]] double bump(double x, double z) const {
    const double across = (std::abs(x) - 85) / 36, along = z / (z > 0 ? 52 : 30);
    return rise_mm * std::exp(-0.5 * (across * across + along * along));
  }
  [[nodiscard]] TriMesh scan() const {
    TriMesh mesh;
    constexpr int nx = 75, nz = 81;
    for (int k = 0; k < nz; ++k) {
      for (int i = 0; i < nx; ++i) {
        const double x = 4.0 * (i - nx / 2), z = 4.0 * (k - nz / 2);
        mesh.points.push_back(1e-3 * Vec3{x, chest(x) - bump(x, z), z});
      }
    }
    for (int k = 0; k + 1 < nz; ++k) {
      for (int i = 0; i + 1 < nx; ++i) {
        const int a = k * nx + i;
        const Vec3& p = mesh.points[static_cast<std::size_t>(a)];
        if (std::hypot(1e3 * p[0] - hole_mm[0], 1e3 * p[2] - hole_mm[2]) > hole_radius_mm) {
          mesh.triangles.push_back({a, a + 1, a + nx});
          mesh.triangles.push_back({a + 1, a + nx + 1, a + nx});
        }
      }
    }
    return mesh;
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
