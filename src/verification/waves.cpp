// Travelling fronts: the Fisher wave and the pushed front (VALIDATION.md C1), and the closing
// circular wound of Sherratt & Murray (C2), through the same solver as the five species.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "healing/adapter.hpp"
#include "healing/reaction_diffusion.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using healing::ReactionDiffusion;
using healing::Species;
using healing::WoundMechanics;

/// u_t = D lap u + k u (1 - u) (a + b u); a = 1, b = 0 is Fisher's.
struct Front {
  static constexpr std::size_t n = 1;
  double diffusivity, rate, a, b;
  [[nodiscard]] std::array<Species, n> species() const {
    return {{{"u", "density", 1.0, 0.0, false, diffusivity}}};
  }
  template <class T>
  [[nodiscard]] std::array<T, n> source(const std::array<T, n>& q, double) const {
    return {rate * (q[0] * (1.0 - q[0]) * (a + b * q[0]))};
  }
  [[nodiscard]] std::array<double, n> rest() const { return {1.0}; }
  [[nodiscard]] double cells(const std::array<double, n>& q) const { return q[0]; }
  [[nodiscard]] WoundMechanics mechanics() const { return {}; }
};

/// Epidermal wound of Sherratt & Murray 1990, doi:10.1098/rspb.1990.0061, without dimensions.
struct SherrattMurray {
  static constexpr std::size_t n = 2;
  enum class Control { Activator, Inhibitor } control;
  static constexpr double h = 10.0, peak = 40.0, alpha = 0.1;
  [[nodiscard]] bool activates() const { return control == Control::Activator; }
  [[nodiscard]] std::array<Species, n> species() const {
    return {{{"n", "cells", 1.0, 0.0, true, activates() ? 5e-4 : 1e-4},
             {"c", "chemical", 1.0, 0.0, true, activates() ? 0.45 : 0.85}}};
  }
  template <class T>
  [[nodiscard]] std::array<T, n> source(const std::array<T, n>& q, double) const {
    const auto& [cells, c] = q;
    const double beta = (1.0 + peak * peak - 2.0 * h * peak) / ((1.0 - peak) * (1.0 - peak));
    const T one(1.0);
    const T s = activates() ? 2.0 * peak * (h - beta) * c / (peak * peak + c * c) + beta
                            : ((h - 1.0) * c + h) / (2.0 * (h - 1.0) * c + one);
    const T g =
        activates() ? (1.0 + alpha * alpha) * cells / (cells * cells + alpha * alpha) : 1.0 * cells;
    return {s * cells * (2.0 - cells) - cells, (activates() ? 30.0 : 5.0) * (g - c)};
  }
  [[nodiscard]] std::array<double, n> rest() const { return {1.0, 1.0}; }
  [[nodiscard]] double cells(const std::array<double, n>& q) const { return q[0]; }
  [[nodiscard]] WoundMechanics mechanics() const { return {}; }
};

/// Slowest growth rate over decay rates q: c_h = min_q [r + 2D/h^2 (cosh qh - 1)] / q, the speed of
/// a pulled front on a lattice.
struct LatticeSpeed {
  double speed = 1e300, decay = 0.0;
};
LatticeSpeed lattice_speed(double d, double r, double h) {
  LatticeSpeed best;
  for (double q = 1e-3; q < 5.0; q += 1e-4) {
    const double c = (r + 2.0 * d / (h * h) * (std::cosh(q * h) - 1.0)) / q;
    if (c < best.speed) {
      best = {c, q};
    }
  }
  return best;
}

/// Where u falls through 1/2 on the edge y = z = 0 of a bar, at the given times.
std::vector<double> front_positions(const Front& front, int boxes, double h, double start,
                                    const std::vector<double>& times, const Context& ctx) {
  // Thin, so that the bar acts as a line.
  const TetMesh mesh = bar(boxes, boxes * h, 0.05 * std::min(h, 1.0));
  const auto model = healing::adapt("front", "", front);
  // The tolerance has to be tiny: a pulled front is led by what lies far ahead of it.
  ReactionDiffusion rd(mesh, mesh.points, std::vector<double>(mesh.cells.size(), 1.0), *model,
                       {.relative_tolerance = 1e-8});
  std::vector<double> q;
  for (const Vec3& p : mesh.points) {
    q.push_back(p[0] < start ? 1.0 : 0.0);
  }
  rd.restore(0.0, q);
  std::vector<double> positions;
  rd.advance(times.back(), ctx, times, [&] {
    const auto& u = rd.state();
    std::size_t i = 0;
    while (u[i + 1] > 0.5) {
      ++i;
    }
    positions.push_back(h * (static_cast<double>(i) + (u[i] - 0.5) / (u[i] - u[i + 1])));
  });
  return positions;
}

Findings fisher_on_a_lattice(const Context& ctx) {
  // Lengths in sqrt(D/r), times in 1/r; boxes as coarse as 1.5 widths of the front, where the
  // lattice slows the wave measurably.
  const double h = 1.5;
  const auto x = front_positions({1.0, 1.0, 1.0, 0.0}, 140, h, 4.0 * h, {60.0, 80.0}, ctx);
  const LatticeSpeed lattice = lattice_speed(1.0, 1.0, h);
  // Bramson: c(t) = c - 3/(2 q t), so x(80) - x(60) = 20 c - 3/(2q) ln(80/60).
  const double expected = lattice.speed - 1.5 / lattice.decay * std::log(80.0 / 60.0) / 20.0;
  Findings found;
  found.checks.push_back(near("speed on boxes of 1.5 front widths", expected, (x[1] - x[0]) / 20.0,
                              0.01 * expected, "sqrt(rD)",
                              "1 %: what Bramson's term leaves out decays as t^-3/2"));
  found.checks.push_back(within("speed of the lattice against the continuum's 2", 2.1, 3.0,
                                lattice.speed, "sqrt(rD)", "the lattice effect must be visible"));
  return found;
}

Findings fisher_in_the_continuum(const Context& ctx) {
  // Capillary values of the default preset: D = 5e-12 m2/s, r = 1.16e-6 1/s, in scaled units.
  Findings found;
  Table table{"", {"h / front width", "speed", "order"}, {}};
  std::vector<double> sizes{1.0, 0.5, 0.25};
  std::vector<double> speeds;
  const double exact = 2.0 - 1.5 * std::log(40.0 / 30.0) / 10.0;  // Bramson, between t = 30 and 40
  for (const double h : sizes) {
    const auto x =
        front_positions({1.0, 1.0, 1.0, 0.0}, static_cast<int>(110 / h), h, 6.0, {30.0, 40.0}, ctx);
    speeds.push_back((x[1] - x[0]) / 10.0);
  }
  // Speeds differ from the exact one by c h^2 and by Bramson's rest: the first cancels here.
  const double limit = speeds[2] + (speeds[2] - speeds[1]) / 3.0;
  const double order = std::log2((speeds[0] - speeds[1]) / (speeds[1] - speeds[2]));
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    table.rows.push_back({fmt::format("{}", sizes[i]), fmt::format("{:.4f}", speeds[i]),
                          i == 2 ? fmt::format("{:.2f}", order) : ""});
  }
  found.tables.push_back(std::move(table));
  found.checks.push_back(near("speed, extrapolated to h = 0", exact, limit, 0.01 * exact,
                              "sqrt(rD)", "1 %: Bramson's rest at t = 30"));
  found.checks.push_back(near("order in h of the speed", 2.0, order, 0.2, "", "lumped P1"));
  // A pushed front forgets its start exponentially fast and has an exact speed.
  const double a = 0.2, b = 1.0;
  std::vector<double> pushed;
  for (const double h : {0.5, 0.25}) {
    const auto x =
        front_positions({1.0, 1.0, a, b}, static_cast<int>(60 / h), h, 6.0, {30.0, 50.0}, ctx);
    pushed.push_back((x[1] - x[0]) / 20.0);
  }
  const double c = std::sqrt(0.5 * b) + a * std::sqrt(2.0 / b);
  found.checks.push_back(near("pushed front, extrapolated to h = 0", c,
                              pushed[1] + (pushed[1] - pushed[0]) / 3.0, 0.003 * c, "sqrt(kD)",
                              "0.3 %: fourth order in h is left"));
  return found;
}

struct Disc {
  SherrattMurray::Control control;
  double healed;                 // T in units of 1/k
  std::array<double, 9> radius;  // where n = 0.8, at 0.1 T ... 0.9 T
};

Findings closing_disc(const Disc& disc, const Context& ctx) {
  // A wedge with its tip cut off at 2 % of the radius; the outermost ring is healthy.
  const int rings = 245;
  const double step = 0.004, tip = 0.02, angle = 0.2;
  const TetMesh mesh = lattice({rings + 1, 1, 1}, [=](int i, int j, int k) {
    const double r = tip + step * i;
    return Vec3{r * std::cos(angle * j), r * std::sin(angle * j), 0.1 * k};
  });
  std::vector<double> fraction(mesh.cells.size(), 1.0);
  std::fill_n(fraction.rbegin(), 6, 0.0);
  const auto model = healing::adapt("sherratt_murray", "", SherrattMurray{disc.control});
  model->check_steady_state();
  ReactionDiffusion rd(mesh, mesh.points, fraction, *model, {.relative_tolerance = 1e-3});
  std::vector<double> times;
  std::vector<double> radii;
  for (int i = 1; i <= 9; ++i) {
    times.push_back(0.1 * i * disc.healed);
  }
  rd.advance(disc.healed, ctx, times, [&] {
    const auto& q = rd.state();
    int i = rings + 1;
    while (i > 0 && q[static_cast<std::size_t>(2 * (i - 1))] > 0.8) {
      --i;
    }
    const double inner = q[static_cast<std::size_t>(2 * (i - 1))];
    const double outer = q[static_cast<std::size_t>(2 * i)];
    radii.push_back(tip + step * (i - 1 + (0.8 - inner) / (outer - inner)));
  });
  Findings found;
  Curve ours{"computed", {}, radii};
  Curve reference{"reference", {}, {disc.radius.begin(), disc.radius.end()}, true};
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double t = 0.1 * (1.0 + static_cast<double>(i));
    ours.x.push_back(t);
    reference.x.push_back(t);
    found.checks.push_back(
        near(fmt::format("radius at {:.1f} T", t), disc.radius[i], radii[i], 0.01, "",
             "rings of 0.004 carry fronts of width 0.01 to 0.02; table to 0.001"));
  }
  found.plots.push_back({"", "t / T", "radius where n = 0.8", {ours, reference}});
  return found;
}

constexpr auto disc_about =
    "Unit disc without cells, healthy at its edge; epidermal healing of "
    "doi:10.1098/rspb.1990.0061. "
    "Reference: independent radial computation, grid-converged over 400 to 1600 points.";

}  // namespace

void add_waves(std::vector<Case>& cases) {
  cases.push_back({"fisher-lattice", "Fisher wave on a coarse lattice (C1)",
                   Chapter::CodeVerification, Cost::Fast,
                   "u_t = D lap u + r u (1 - u). Reference: the exact speed of the semi-discrete "
                   "front, with Bramson's correction for its age.",
                   fisher_on_a_lattice});
  cases.push_back({"fisher", "Fisher wave and pushed front (C1)", Chapter::CodeVerification,
                   Cost::Full,
                   "Speeds 2 sqrt(rD) (with Bramson's correction) and, for k u (1 - u)(a + b u), "
                   "sqrt(Dk) (sqrt(b/2) + a sqrt(2/b)).",
                   fisher_in_the_continuum});
  const Disc activator{SherrattMurray::Control::Activator,
                       20.64,
                       {.974, .897, .795, .693, .590, .486, .379, .267, .146}};
  const Disc inhibitor{SherrattMurray::Control::Inhibitor,
                       46.07,
                       {.961, .869, .761, .650, .539, .431, .327, .227, .129}};
  cases.push_back({"disc-activator", "Closing circular wound, activator (C2)",
                   Chapter::CodeVerification, Cost::Fast, disc_about, [=](const Context& ctx) {
                     return closing_disc(activator, ctx);
                   }});
  cases.push_back({"disc-inhibitor", "Closing circular wound, inhibitor (C2)",
                   Chapter::CodeVerification, Cost::Full, disc_about, [=](const Context& ctx) {
                     return closing_disc(inhibitor, ctx);
                   }});
}

}  // namespace sanatrix::verification
