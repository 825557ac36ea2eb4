// Resections in bodies whose answer is known: slab, dome, two domes; rotated and mirrored.
#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "body.hpp"
#include "core/error.hpp"
#include "surgery/place.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::surgery {
namespace {

using sanatrix::testing::body_under;
using sanatrix::testing::moved;
using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi, mm = 1e-3, midline = -0.1;

Plan plan_at(const Vec3& centre, double tumour_radius = 6 * mm) {
  Plan plan;
  plan.tumour_centre = centre;
  plan.tumour_radius = tumour_radius;
  return plan;
}

Wound removed(const Plan& plan, const TetMesh& mesh, double midline_x = midline) {
  Silent silent;
  return resect(plan, mesh, mesh.points, midline_x, Context("surgery", silent));
}

const TetMesh& slab() {  // 60 mm thick
  static const TetMesh mesh =
      body_under([](double, double) { return 60 * mm; }, 40 * mm, 60 * mm, 3 * mm);
  return mesh;
}

const TetMesh& dome() {  // skin: sphere of 80 mm, apex 60 mm above the chest
  static const TetMesh mesh = body_under(
      [](double x, double z) { return std::sqrt(80 * mm * 80 * mm - x * x - z * z) - 20 * mm; },
      52 * mm, 60 * mm, 3 * mm);
  return mesh;
}

std::string refusal(const Plan& plan, const TetMesh& mesh, double midline_x = midline) {
  try {
    removed(plan, mesh, midline_x);
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Input);
    return e.one_line();
  }
  return "accepted";
}

TEST(AResection, BetweenParallelPlanesIsACylinderWithRoundedEdges) {
  const Wound wound = removed(plan_at({0, -30 * mm, 0}), slab());
  // Steiner's formula for a cylinder (a, l) grown by the rounding k.
  const double k = 4 * mm, a = 16 * mm - k, l = 50 * mm - 2 * k;
  const double expected = pi * a * a * l + 2 * pi * a * (a + l) * k + pi * (l + pi * a) * k * k +
                          4.0 / 3.0 * pi * k * k * k;
  EXPECT_NEAR(wound.exact_m3, expected, 0.002 * expected);
  EXPECT_NEAR(wound.excised_m3, expected, 0.005 * expected);
  // Sampling points lie up to 0.25 mm below the surface.
  EXPECT_NEAR(wound.min_skin_distance_m, 5 * mm, 0.3 * mm);
  EXPECT_NEAR(wound.min_chest_distance_m, 5 * mm, 0.3 * mm);
  EXPECT_GE(std::min(wound.min_skin_distance_m, wound.min_chest_distance_m), 5 * mm);
  EXPECT_TRUE(wound.warnings.empty());
  for (const double f : wound.fraction) {
    ASSERT_TRUE(f >= 0.0 && f <= 1.0 + 1e-12);
  }
}

/// Nipple 30 mm to the patient's left of the tumour, on the skin.
Plan segment_plan() {
  Plan plan = plan_at({0, -30 * mm, 0});
  plan.segment = Segment{.apex = {30 * mm, -60 * mm, 0}, .angle = {}, .from = {}, .to = {}};
  return plan;
}

TEST(ASegment, BetweenParallelPlanesIsASectorWithRoundedEdges) {
  Plan plan = segment_plan();
  plan.segment->angle = 80 * pi / 180;
  plan.segment->from = 12 * mm;
  plan.segment->to = 46 * mm;
  const Wound wound = removed(plan, slab());
  const double r = 12 * mm, R = 46 * mm, angle = 80 * pi / 180, k = 4 * mm;
  const double area = 0.5 * angle * (R * R - r * r), edge = angle * (R + r) + 2 * (R - r);
  // At both caps a quarter circle of radius k is all that is left of a square at every edge.
  const double expected = area * 50 * mm - 2 * (1 - pi / 4) * k * k * edge;
  EXPECT_NEAR(wound.exact_m3, expected, 0.01 * expected);  // corners: some k^3 each
  EXPECT_NEAR(wound.excised_m3, expected, 0.012 * expected);
}

TEST(ASegment, KeepsTheMarginAtAllSidesByItself) {
  const Resection resection(segment_plan(), slab(), slab().points, midline);
  const Vec3 apex{30 * mm, -30 * mm, 0};
  // 16 mm = tumour and margin: along the middle line towards and away from the nipple, and square
  // to both sides.
  const double half = std::asin(16.0 / 30.0);
  for (const Vec3& out : {Vec3{-1, 0, 0}, Vec3{1, 0, 0}, Vec3{std::sin(half), 0, std::cos(half)},
                          Vec3{std::sin(half), 0, -std::cos(half)}}) {
    EXPECT_NEAR(resection.signed_distance({16 * mm * out[0], -30 * mm, 16 * mm * out[2]}), 0.0,
                0.1 * mm);
  }
  EXPECT_GT(resection.signed_distance(apex), 10 * mm);  // the nipple stays
}

TEST(ASegment, ThatCannotBeIsRefused) {
  Plan behind = segment_plan();
  behind.segment->apex = {10 * mm, -60 * mm, 0};
  EXPECT_THAT(refusal(behind, slab()), HasSubstr("too near for a segment"));
  Plan beside = segment_plan();
  beside.segment->to = 25 * mm;
  EXPECT_THAT(refusal(beside, slab()), HasSubstr("not inside the segment"));
}

TEST(AResection, KeepsItsRadiusBetweenTheCapsAndItsClearanceUnderASphere) {
  const Plan plan = plan_at({10 * mm, -25 * mm, 5 * mm});
  const Resection resection(plan, dome(), dome().points, midline);
  EXPECT_NEAR(resection.axis_towards_skin()[1], -1.0, 1e-9);
  for (int i = 0; i < 24; ++i) {
    const double angle = i * pi / 12;
    const Vec3 out{std::cos(angle), 0, std::sin(angle)};
    EXPECT_NEAR(resection.signed_distance(plan.tumour_centre + 16 * mm * out), 0.0, 1e-6);
    EXPECT_NEAR(resection.signed_distance(plan.tumour_centre + 14 * mm * out), -2 * mm, 1e-6);
  }
  const auto measure = resection.measure();
  EXPECT_GE(measure.min_skin_distance_m, 5 * mm);
  EXPECT_GE(measure.min_chest_distance_m, 5 * mm);
  const Wound wound = removed(plan, dome());
  EXPECT_NEAR(wound.excised_m3, wound.exact_m3, 0.005 * wound.exact_m3);
}

TEST(AResection, DoesNotDependOnWhereTheAxesOfThePatientPoint) {
  const Plan plan = plan_at({10 * mm, -25 * mm, 5 * mm});
  const double angle = 0.4, c = std::cos(angle), s = std::sin(angle);
  const Mat3 turn =
      Mat3{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}} * Mat3{{{1, 0, 0}, {0, c, -s}, {0, s, c}}};
  const Vec3 shift{0.1, -0.05, 0.3};
  Plan turned_plan = plan;
  turned_plan.tumour_centre = turn * plan.tumour_centre + shift;
  const Wound straight = removed(plan, dome());
  const Wound turned = removed(turned_plan, moved(dome(), turn, shift));
  EXPECT_NEAR(turned.excised_m3, straight.excised_m3, 1e-4 * straight.excised_m3);
  EXPECT_NEAR(turned.exact_m3, straight.exact_m3, 1e-3 * straight.exact_m3);

  TetMesh mirrored = moved(dome(), {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {});
  for (auto& cell : mirrored.cells) {
    std::swap(cell[2], cell[3]);
  }
  for (auto& face : mirrored.faces) {
    std::swap(face.vertex[1], face.vertex[2]);
  }
  Plan right = plan;
  right.side = Side::Right;
  right.tumour_centre[0] = -plan.tumour_centre[0];
  const Wound other = removed(right, mirrored, -midline);
  EXPECT_NEAR(other.excised_m3, straight.excised_m3, 1e-3 * straight.excised_m3);
  EXPECT_THAT(refusal(right, mirrored, midline), HasSubstr("operated_side is R"));
  EXPECT_THAT(refusal(plan, mirrored, -midline), HasSubstr("operated_side is L"));
}

TEST(AResection, IsOnePieceEvenWhenItsAxisRunsIntoTheOtherBreast) {
  const TetMesh breasts = body_under(
      [](double x, double z) {
        const double r2 = (std::abs(x) - 45 * mm) * (std::abs(x) - 45 * mm) + z * z;
        return 12 * mm + 50 * mm * std::exp(-r2 / (2 * 15 * mm * 15 * mm));
      },
      75 * mm, 60 * mm, 5 * mm);
  Plan plan = plan_at({45 * mm, -38 * mm, 0}, 3 * mm);
  plan.margin = 5 * mm;
  plan.axis = normalised({-1.0, -0.05, 0.0});
  const Resection resection(plan, breasts, breasts.points, 0.0);
  EXPECT_LT(resection.signed_distance(plan.tumour_centre), 0.0);
  EXPECT_GT(resection.signed_distance({-45 * mm, -38 * mm, 0}), 0.0);
  const Wound wound = removed(plan, breasts, 0.0);
  for (std::size_t c = 0; c < breasts.cells.size(); ++c) {
    if (breasts.points[breasts.cells[c][0]][0] < 0.0) {
      ASSERT_EQ(wound.fraction[c], 0.0);
    }
  }
}

TEST(AResection, NearTheSkinSaysWhichMarginIsLeft) {
  const Wound wound = removed(plan_at({0, -48 * mm, 0}), slab());  // 12 mm below the skin
  ASSERT_EQ(wound.warnings.size(), 1u);
  EXPECT_THAT(wound.warnings[0], HasSubstr("margin of 10.0 mm is not reached"));
  const Wound deeper = removed(plan_at({0, -52 * mm, 0}), slab());  // 8 mm: cut by the clearance
  EXPECT_THAT(deeper.warnings.at(0), HasSubstr("not removed completely"));
}

TEST(AResection, ThatCannotBeIsRefused) {
  EXPECT_THAT(refusal(plan_at({0, 10 * mm, 0}), slab()), HasSubstr("outside the breast model"));
  Plan wrong_way = plan_at({0, -30 * mm, 0});
  wrong_way.axis = Vec3{0, 1, 0};
  EXPECT_THAT(refusal(wrong_way, slab()), HasSubstr("does not meet the skin"));
  Plan thin = plan_at({0, -30 * mm, 0});
  thin.clearance = 30 * mm;
  EXPECT_THAT(refusal(thin, slab()), HasSubstr("nothing is left"));
}

TEST(AnAnatomy, ServesOnePlanAfterAnotherWithTheSameAnswers) {
  Silent silent;
  const Context ctx("surgery", silent);
  const auto anatomy = std::make_shared<const Anatomy>(dome(), dome().points, midline);
  Plan plan = plan_at({10 * mm, -25 * mm, 5 * mm});
  for (const double margin : {5 * mm, 12 * mm, 5 * mm}) {
    plan.margin = margin;
    const Wound kept = resect(plan, anatomy, ctx), fresh = removed(plan, dome());
    EXPECT_EQ(kept.fraction, fresh.fraction);
    EXPECT_EQ(kept.exact_m3, fresh.exact_m3);
    EXPECT_EQ(kept.incision_vertices, fresh.incision_vertices);
  }
}

TEST(AnAnatomy, AnswersWhileSomebodyDragsWithinAPercent) {
  Silent silent;
  const Context ctx("surgery", silent);
  for (const TetMesh* mesh : {&slab(), &dome()}) {
    const auto anatomy = std::make_shared<const Anatomy>(*mesh, mesh->points, midline);
    Plan plan = plan_at({5 * mm, -25 * mm, 5 * mm});
    for (const double margin : {6 * mm, 10 * mm}) {
      plan.margin = margin;
      const Wound live = resect(plan, anatomy, ctx, Detail::Live),
                  full = resect(plan, anatomy, ctx);
      EXPECT_NEAR(live.excised_m3 / full.excised_m3, 1.0, 0.01);
      EXPECT_NEAR(live.exact_m3 / full.exact_m3, 1.0, 0.01);
      EXPECT_NEAR(live.min_skin_distance_m, full.min_skin_distance_m, 0.3 * mm);
      EXPECT_NEAR(live.min_chest_distance_m, full.min_chest_distance_m, 0.3 * mm);
    }
    // The field against what it stands for, a clearance and more away from the skin.
    for (int i = 0; i < 200; ++i) {
      const Vec3 p{(i % 10 - 5) * 3.1 * mm, (-45 + i / 10 % 5 * 7.3) * mm, (i / 50 - 2) * 5.7 * mm};
      const double d = anatomy->skin_tree().closest(p).distance;
      if (d > 2 * DistanceField::step) {
        EXPECT_NEAR(anatomy->to_skin()(p), d, 0.1 * mm);
      }
    }
  }
}

TEST(APlace, IsToldAsSeenByWhoFacesThePatient) {
  const Vec3 nipple{80 * mm, -60 * mm, 10 * mm};
  const Place left = place_of(nipple + Vec3{30 * mm, 20 * mm, 30 * mm}, nipple, Side::Left);
  EXPECT_EQ(left.quadrant, "upper outer");
  EXPECT_DOUBLE_EQ(left.clock_hour, 1.5);
  EXPECT_NEAR(left.from_nipple_mm, std::sqrt(2200.0), 1e-9);
  // The same direction is inner on the other side; the clock does not know sides.
  const Place right = place_of(nipple + Vec3{30 * mm, 20 * mm, 30 * mm}, nipple, Side::Right);
  EXPECT_EQ(right.quadrant, "upper inner");
  EXPECT_DOUBLE_EQ(right.clock_hour, 1.5);
  EXPECT_EQ(place_of(nipple + Vec3{-25 * mm, 0, -1 * mm}, nipple, Side::Right).quadrant,
            "lower outer");
  EXPECT_DOUBLE_EQ(place_of(nipple + Vec3{0, 0, 40 * mm}, nipple, Side::Left).clock_hour, 12.0);
  EXPECT_DOUBLE_EQ(place_of(nipple + Vec3{-1 * mm, 0, 40 * mm}, nipple, Side::Left).clock_hour,
                   12.0);
  EXPECT_EQ(place_of(nipple + Vec3{5 * mm, 50 * mm, 5 * mm}, nipple, Side::Left).quadrant,
            "central");
}

TEST(AnIncision, IsAPathAlongSkinEdgesOverTheResection) {
  const Wound wound = removed(plan_at({10 * mm, -25 * mm, 5 * mm}), dome());
  ASSERT_EQ(wound.incision_vertices.size(), 1u);
  const auto& line = wound.incision_vertices[0];
  std::set<std::pair<int, int>> edges;
  for (const auto& face : dome().faces) {
    if (face.name == 0) {
      for (std::size_t i = 0; i < 3; ++i) {
        edges.emplace(face.vertex[i], face.vertex[(i + 1) % 3]);
        edges.emplace(face.vertex[(i + 1) % 3], face.vertex[i]);
      }
    }
  }
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    EXPECT_TRUE(edges.contains({line[i - 1], line[i]}));
    length += norm(dome().points[line[i]] - dome().points[line[i - 1]]);
  }
  // As long as the resection is wide, plus what slanting skin and stepping along edges add.
  EXPECT_GT(length, 28 * mm);
  EXPECT_LT(length, 48 * mm);
}

}  // namespace
}  // namespace sanatrix::surgery
