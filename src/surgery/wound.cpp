// What the plan removes from a mesh: volume fraction per cell, volumes, clearances, incisions.
#include <algorithm>
#include <numbers>

#include "core/error.hpp"
#include "surgery/incision.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::surgery {
namespace {

constexpr double mm = 1e-3;

/// Directions spread evenly over the sphere (Fibonacci lattice).
std::vector<Vec3> directions(int count) {
  std::vector<Vec3> result;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    result.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return result;
}

/// Says it when the tumour or its margin is not removed completely, and by how much.
std::vector<std::string> margin_warnings(const Plan& plan, const Resection& resection,
                                         Detail detail) {
  const int count = detail == Detail::Full ? 400 : 100;  // 10 and 20 degrees apart
  const double tumour = plan.tumour_radius, planned = tumour + plan.margin;
  double reached = planned;
  for (const Vec3& d : directions(count)) {
    // Walk inwards from the planned margin until the point is removed.
    double r = planned;
    while (r > 0.0 && resection.signed_distance(plan.tumour_centre + r * d) > 0.05 * mm) {
      r -= 0.25 * mm;
    }
    reached = std::min(reached, std::max(r, 0.0));
  }
  if (reached < tumour) {
    return {
        fmt::format("the tumour is not removed completely: the excision ends {:.1f} mm inside "
                    "it, {:.1f} mm from skin or chest wall",
                    (tumour - reached) / mm, plan.clearance / mm)};
  }
  if (reached < planned) {
    return {
        fmt::format("the planned margin of {:.1f} mm is not reached everywhere: {:.1f} mm at "
                    "its thinnest",
                    plan.margin / mm, (reached - tumour) / mm)};
  }
  return {};
}

}  // namespace

Wound resect(const Plan& plan, const TetMesh& mesh, std::span<const Vec3> points,
             double midline_x_m, const Context& ctx, Detail detail) {
  ctx.at(0.0, "placing the resection");
  return resect(plan, std::make_shared<const Anatomy>(mesh, points, midline_x_m), ctx, detail);
}

Wound resect(const Plan& plan, std::shared_ptr<const Anatomy> anatomy, const Context& ctx,
             Detail detail) {
  const TetMesh& mesh = anatomy->mesh();
  const std::span<const Vec3> points = anatomy->points();
  const Resection resection(plan, anatomy, detail);
  ctx.at(0.3, "marking the removed tissue");
  Wound wound;
  wound.fraction.reserve(mesh.cells.size());
  for (const auto& [a, b, c, d] : mesh.cells) {
    const std::array<Vec3, 4> corners{points[a], points[b], points[c], points[d]};
    wound.fraction.push_back(resection.volume_fraction(corners));
    if (wound.fraction.back() > 0.0) {
      wound.excised_m3 +=
          wound.fraction.back() * volume(points[a], points[b], points[c], points[d]);
    }
  }
  ctx.at(0.7, "measuring the removed volume");
  const Resection::Measure exact = resection.measure();
  wound.exact_m3 = exact.volume_m3;
  wound.min_skin_distance_m = exact.min_skin_distance_m;
  wound.min_chest_distance_m = exact.min_chest_distance_m;
  wound.warnings = margin_warnings(plan, resection, detail);

  ctx.at(0.9, "placing the incision");
  auto lines = plan.incisions;
  if (lines.empty()) {
    lines.push_back(default_incision(resection.skin_point(), resection.axis_towards_skin(),
                                     resection.radius()));
  }
  for (const auto& line : lines) {
    wound.incision_vertices.push_back(path_on_skin(*anatomy, line));
  }
  ctx.at(1.0, fmt::format("{:.1f} cm3 removed", wound.excised_m3 * 1e6));
  return wound;
}

}  // namespace sanatrix::surgery
