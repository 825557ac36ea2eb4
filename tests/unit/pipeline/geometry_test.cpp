// The mesh focus that follows the plan lazily, and the level set drawn as the wound.
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/focus.hpp"
#include "pipeline/level_set.hpp"
#include "simple_meshes.hpp"

namespace sanatrix::pipeline {
namespace {

surgery::Plan plan_of(const Vec3& centre, double radius) {
  surgery::Plan plan;
  plan.tumour_centre = centre;
  plan.tumour_radius = radius - plan.margin;
  plan.axis = Vec3{0, -1, 0};
  return plan;
}

TEST(Focus, LeavesRoomAroundTheFirstPlan) {
  const FocusRule rule = follow({}, plan_of({0.1, 0, 0}, 0.0157));
  EXPECT_GE(rule.radius, 0.0167);
  EXPECT_LE(rule.radius, 0.0207);
}

TEST(Focus, StaysWhileTheNewPlanIsNear) {
  const FocusRule rule = follow({}, plan_of({0.1, 0, 0}, 0.0157));
  EXPECT_EQ(follow(rule, plan_of({0.1, 0, 0}, 0.0207)).radius, rule.radius);
  EXPECT_EQ(*follow(rule, plan_of({0.105, 0.02, 0}, 0.0157)).centre,
            *rule.centre);  // along the axis
}

TEST(Focus, MovesWhenThePlanGoesElsewhere) {
  const FocusRule rule = follow({}, plan_of({0.1, 0, 0}, 0.0157));
  EXPECT_EQ((*follow(rule, plan_of({0.06, 0, 0}, 0.0157)).centre)[0], 0.06);
  EXPECT_GT(follow(rule, plan_of({0.1, 0, 0}, 0.035)).radius, rule.radius);
}

TEST(Focus, RunsFromTheChestWallToTheSkin) {
  LabelImage labels;
  labels.size = {40, 60, 40};
  labels.spacing_mm = {2, 2, 2};
  labels.origin_mm = {0, -60, 0};
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 40; ++i) {
        labels.voxels.push_back(j < 10 ? 0 : j < 50 ? 1 : 4);  // skin at y = -40, wall at y = 40
      }
    }
  }
  FocusRule rule = follow({}, plan_of({0.04, 0.01, 0.04}, 0.0157));
  rule.axis.reset();  // then away from the wall
  const auto focus = place(rule, labels, 0.0);
  ASSERT_TRUE(focus.has_value());
  EXPECT_NEAR(focus->a[1], 0.040, 0.003);
  EXPECT_NEAR(focus->b[1], -0.040, 0.003);
  EXPECT_NEAR(focus->b[0], 0.04, 0.004);
}

TEST(LevelSet, OfADistanceIsASphereThatFacesOutwards) {
  const TetMesh mesh = testing::cube(12, 1.0);
  std::vector<double> inside;
  for (const Vec3& p : mesh.points) {
    inside.push_back(-norm(p - Vec3{0.5, 0.5, 0.5}));
  }
  const TriMesh sphere = level_set(mesh, mesh.points, inside, -0.4);
  double volume = 0.0;
  for (const auto& t : sphere.triangles) {
    volume += dot(sphere.points[static_cast<std::size_t>(t[0])],
                  cross(sphere.points[static_cast<std::size_t>(t[1])],
                        sphere.points[static_cast<std::size_t>(t[2])])) /
              6.0;
  }
  // Chords as long as a cell's diagonal, sqrt(3)/12, lie up to 0.0065 inside the radius of 0.4.
  EXPECT_NEAR(volume, 4.0 / 3.0 * std::numbers::pi * 0.064, 0.0065 * 2.0);
  EXPECT_NEAR(surface_area(sphere), 4.0 * std::numbers::pi * 0.16, 0.0065 * 10.0);
}

TEST(LevelSet, CellValuesKeepAConstantAtTheVertices) {
  TetMesh mesh = testing::cube(2, 1.0);
  check_and_orient(mesh, "cube");
  for (const double v :
       to_vertices(mesh, mesh.points, std::vector<double>(mesh.cells.size(), 0.3))) {
    EXPECT_NEAR(v, 0.3, 1e-15);
  }
}

}  // namespace
}  // namespace sanatrix::pipeline
