// A ball with a hole or with faces turned inside out: what is inside is known.
#include "standing/closed_body.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "geometry/image_filters.hpp"

namespace sanatrix::standing {
namespace {

constexpr double radius_mm = 60.0;
constexpr int rings = 48, segments = 96;

Vec3 on_ball(double polar, double turn) {
  return radius_mm *
         Vec3{std::sin(polar) * std::cos(turn), -std::cos(polar), std::sin(polar) * std::sin(turn)};
}

/// Faces of 4 mm, normals outwards; polar angle from the front. `keep(ring, segment)` leaves faces
/// out, `turned(ring, segment)` turns them inside out.
template <class Keep, class Turned>
TriMesh ball(Keep&& keep, Turned&& turned) {
  TriMesh mesh;
  for (int r = 0; r <= rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      mesh.points.push_back(1e-3 * on_ball(std::numbers::pi * (r + 0.01) / (rings + 0.02),
                                           2 * std::numbers::pi * s / segments));
    }
  }
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const int a = r * segments + s, b = r * segments + (s + 1) % segments;
      if (keep(r, s)) {
        const bool flip = turned(r, s);
        const auto add = [&](int p, int q, int t) {
          mesh.triangles.push_back(flip ? std::array{p, t, q} : std::array{p, q, t});
        };
        add(a, a + segments, b);
        add(b, a + segments, b + segments);
      }
    }
  }
  return mesh;
}

Image3<float> measured(const TriMesh& skin) {
  constexpr double h = 2.0;
  Image3<float> body{.size = {71, 71, 71},
                     .spacing_mm = {h, h, h},
                     .origin_mm = {-70, -70, -70},
                     .voxels = std::vector<float>(71 * 71 * 71)};
  measure_body(skin, body);
  return body;
}

constexpr auto all = [](int, int) {
  return true;
};
constexpr auto none = [](int, int) {
  return false;
};

TEST(ClosedBody, AHoleWithTeethIsClosedAsRoundAsTheSkinAround) {
  // 19 mm across to the middle, teeth of 4 mm.
  const Image3<float> body = measured(ball([](int r, int s) { return r > 4 + s % 2; }, none));
  double most = 0;
  for (int r = 0; r < 5; ++r) {
    for (int s = 0; s < segments; s += 8) {
      const Vec3 p = on_ball(std::numbers::pi * r / rings, 2 * std::numbers::pi * s / segments);
      most = std::max(most, std::abs(1.0 * sample(body, p)));
    }
  }
  // Flat from rim to rim would be 3 mm.
  EXPECT_LT(most, 1.5);
}

TEST(ClosedBody, FacesTurnedInsideOutLeaveTheBodyBehindThemWhole) {
  // As where a fold passes through itself.
  const Image3<float> body =
      measured(ball(all, [](int r, int s) { return r == 9 && s > 4 && s < 30; }));
  for (int k = 0; k < body.size[2]; ++k) {
    for (int j = 0; j < body.size[1]; ++j) {
      for (int i = 0; i < body.size[0]; ++i) {
        const double deep = radius_mm - norm(body.position_mm(i, j, k));
        if (std::abs(deep) > 12.0) {  // beyond the reach of the faces themselves
          ASSERT_EQ(body.voxels[body.index(i, j, k)]<0, deep> 0) << i << " " << j << " " << k;
        }
      }
    }
  }
}

}  // namespace
}  // namespace sanatrix::standing
