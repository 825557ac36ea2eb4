// The paper's results as intervals (VALIDATION.md A) and the clinical cavity curve (B1).
#include <cmath>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "mechanics/problem.hpp"
#include "verification/cases.hpp"
#include "verification/healing_sphere.hpp"

namespace sanatrix::verification {
namespace {

Findings as_the_paper_says(const Context& ctx) {
  const TetMesh mesh = wounded_ball(0.022, 11);
  const SphereHealing h = heal_body("vavourakis2016", mesh, 0.022, 90.0, ctx);
  Findings found;
  const double end = h.volume.value.back();
  const auto gained = [&](double day) {
    return (1.0 - h.volume.at(day)) / (1.0 - end);
  };
  const auto add = [&](const char* name, double low, double high, double value, const char* unit,
                       const char* reason) {
    found.checks.push_back(within(name, low, high, value, unit, reason));
  };
  add("A1: final V/V0", 0.91, 0.93, end, "", "as printed for all four patients");
  add("A2: share of the contraction at day 8", 0.0, 0.30, gained(8.0), "", "slow start, Fig 6");
  add("A2: share gained from day 8 to 16", 0.45, 1.0, gained(16.0) - gained(8.0), "",
      "pronounced in the second week");
  add("A2: share at day 24", 0.95, 1.01, gained(24.0), "", "plateau");
  add("A2: share at day 30", 0.98, 1.01, gained(30.0), "", "final shape after about 30 d");
  add("A3: day of 90 % capillaries at the centre", 45.0, 55.0, h.centre_nu.time_of(0.9), "d",
      "about 50 d, S2 Video; six-day record");
  add("A4: mean cells at day 30", 0.95, 1.01, h.eta.at(30.0), "", "S3 Video: one month");
  add("A5: mean cells at day 90", 0.98, 1.02, h.eta.at(90.0), "", "healthy state");
  add("A5: mean capillaries at day 90", 0.98, 1.02, h.nu.at(90.0), "", "healthy state");
  add("A5: mean oxygen at day 90", 0.98, 1.02, h.xi.at(90.0), "", "healthy state");
  const SphereHealing inhibitor = heal_body("vavourakis2016_inhibitor", mesh, 0.022, 90.0, ctx);
  double most = 0.0;
  for (double day = 0.0; day <= 90.0; day += 0.5) {
    most = std::max(most, std::abs(h.volume.at(day) - inhibitor.volume.at(day)));
  }
  add("A6: largest difference activator - inhibitor in V/V0", 0.0, 0.01, most, "",
      "\"very similar\"");
  found.plots.push_back({"Volume of the wound, Fig 6 of the paper",
                         "day",
                         "V / V0",
                         {{"activator", h.volume.day, h.volume.value},
                          {"inhibitor", inhibitor.volume.day, inhibitor.volume.value}}});
  return found;
}

/// Contraction of an oblate wound (a, a, a/2) where its wall is flat (pole) and where it is sharply
/// curved (rim): inward displacement over the half axis.
Findings curvature(const Context& ctx) {
  const double a = 0.022;
  TetMesh mesh = ball_octant(graded_radii(a, 10, 3.0 * a, 1.35));
  const std::vector<double> wound = cells_where(mesh, [=](const Vec3& p) { return norm(p) < a; });
  std::size_t pole = 0;
  std::size_t rim = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    pole =
        norm(mesh.points[v] - Vec3{0, 0, a}) < norm(mesh.points[pole] - Vec3{0, 0, a}) ? v : pole;
    rim = norm(mesh.points[v] - Vec3{a, 0, 0}) < norm(mesh.points[rim] - Vec3{a, 0, 0}) ? v : rim;
  }
  for (Vec3& p : mesh.points) {  // oblate inside, a ball again far away
    const double r = norm(p) / a;
    p[2] *= 1.0 - 0.5 * (r < 1.0 ? 1.0 : (3.0 - r) / 2.0);
  }
  mechanics::Body body;
  body.mesh = &mesh;
  body.fixed = symmetry_supports(mesh);
  for (const double w : wound) {
    body.tissue.push_back(w > 0.0 ? mechanics::Tissue{200.0, 200.0, 1e4, 1000.0, 1.0, 830.0}
                                  : healthy_tissue);
  }
  mechanics::Solver solver(body);
  const auto shape = solver.forward(mesh.points, {}, nullptr, ctx);
  const double flat = mesh.points[pole][2] - shape.nodes[pole][2];
  const double sharp = mesh.points[rim][0] - shape.nodes[rim][0];
  Findings found;
  found.checks.push_back(within("A7: contraction where flat / where sharply curved", 1.05, 100.0,
                                (flat / (0.5 * a)) / (sharp / a), "",
                                "\"larger at low curvature\"; at least 5 %"));
  found.checks.push_back(
      within("A7: inward displacement where flat", 0.0, 500.0 * a, 1e3 * flat, "mm", "inwards"));
  found.tables.push_back(
      {"Inward displacement of the wall",
       {"place", "half axis [mm]", "displacement [mm]", "share of the half axis"},
       {{"pole (flat)", fmt::format("{:.1f}", 500.0 * a), fmt::format("{:.3f}", 1e3 * flat),
         fmt::format("{:.4f}", flat / (0.5 * a))},
        {"rim (sharp)", fmt::format("{:.1f}", 1e3 * a), fmt::format("{:.3f}", 1e3 * sharp),
         fmt::format("{:.4f}", sharp / a)}}});
  return found;
}

struct ClinicalPoint {
  double day, volume;
};
constexpr std::array<ClinicalPoint, 4> kader{{{21, .764}, {56, .488}, {80.5, .341}, {135, .146}}};

Findings clinical(const Context& ctx) {
  // Slow cells invade in a layer of millimetres: 3 mm cells smear it and contract 0.03 too much.
  const double radius = 0.0245;
  const SphereHealing h =
      heal_body("clinical_kader", ball_with_fine_wall(radius, 0.8e-3, 1.4), radius, 135.0, ctx);
  const SphereHealing peer = heal_body("clinical_kader", ball_with_fine_wall(radius, 0.8e-3, 1.7),
                                       radius, 135.0, ctx, mechanics::Element::P2P1);
  Findings found;
  Curve points{"Kader 2008, V0 = 61.5 cm3 assumed", {}, {}, true};
  for (const ClinicalPoint& p : kader) {
    // The middle of each window is known to about 10 d, which is 0.0128/d x V x 10 d.
    const double tolerance = 0.128 * p.volume;
    found.checks.push_back(near(fmt::format("V/V0 at day {}", p.day), p.volume, h.volume.at(p.day),
                                std::max(tolerance, 0.02), "",
                                "mid-window times are known to 10 d at 0.0128/d"));
    points.x.push_back(p.day);
    points.y.push_back(p.volume);
    points.error_bar.push_back(tolerance);
  }
  const auto wound = healing::make_model("clinical_kader")->mechanics();
  for (const double day : {30.0, 60.0, 90.0, 135.0}) {
    found.checks.push_back(near(
        fmt::format("V/V0 of the radial solution, same cells, day {}", day),
        radial_volume_ratio(h.cells.at(day), 3.0 * radius, wound, healthy_tissue), h.volume.at(day),
        0.015, "", "P1/P1 cells of 6 to 12 mm in the middle at V/V0 = 0.14"));
  }
  double most = 0.0;
  for (double day = 0.0; day <= 135.0; day += 1.0) {
    most = std::max(most, std::abs(h.volume.at(day) - peer.volume.at(day)));
  }
  found.checks.push_back(within("largest difference of P2/P1 on half the vertices in V/V0", 0.0,
                                0.03, most, "",
                                "what the coarser mesh smears the layer of invading cells by"));
  // Not used in the calibration, and not met: shown as what it is.
  Curve jeon{"Jeon 2017, from day 23 (not fitted)", {}, {}, true};
  const double v23 = h.volume.at(23.1);
  double day = 23.1;
  for (const auto& [step, share] :
       {std::pair{0.0, 1.0}, std::pair{8.5, 0.60}, std::pair{7.2, 0.48}, std::pair{5.9, 0.40}}) {
    day += step;
    jeon.x.push_back(day);
    jeon.y.push_back(share * v23);
  }
  found.plots.push_back({"Cavity after breast-conserving surgery",
                         "day",
                         "V / V0",
                         {{"preset clinical_kader, P1/P1", h.volume.day, h.volume.value},
                          {"preset clinical_kader, P2/P1", peer.volume.day, peer.volume.value},
                          points,
                          jeon}});
  return found;
}

}  // namespace

void add_paper(std::vector<Case>& cases) {
  cases.push_back({"paper", "What the paper reports of healing (A1-A6)", Chapter::Validation,
                   Cost::Full,
                   "A spherical wound of 22 mm, default preset, 90 days, mechanics every six.",
                   as_the_paper_says});
  cases.push_back({"curvature", "Contraction and curvature of the wound (A7)", Chapter::Validation,
                   Cost::Fast,
                   "An oblate wound with half axes 22, 22 and 11 mm in healthy tissue pulls in. "
                   "Contraction is the inward displacement over the half axis.",
                   curvature});
}

void add_clinical(std::vector<Case>& cases) {
  cases.push_back({"clinical-kader", "Cavity volume in the clinic (B1)", Chapter::Validation,
                   Cost::Full,
                   "Preset clinical_kader, a wound of 61.5 cm3, against the window means of Kader "
                   "et al. 2008 (doi:10.1016/j.ijrobp.2008.02.049) to which it was calibrated; an "
                   "independent cohort that it does not match is drawn with it.",
                   clinical});
}

}  // namespace sanatrix::verification
