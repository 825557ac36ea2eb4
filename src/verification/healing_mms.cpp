// Manufactured solutions of the five species: prescribed fields, their forcing from the shipped
// source terms, and the solver has to follow them.
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "healing/adapter.hpp"
#include "healing/five_species.hpp"
#include "healing/reaction_diffusion.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using healing::FiveSpecies;
using healing::Species;

constexpr double edge = 0.002;           // of the cube [m]
constexpr double horizon = 2 * 86400.0;  // [s]
constexpr double wave = std::numbers::pi / edge;

/// cos cos cos: no flux through the faces of the cube, Laplacian -3 wave^2 times itself.
double shape_at(const Vec3& p) {
  return std::cos(wave * p[0]) * std::cos(wave * p[1]) * std::cos(wave * p[2]);
}

/// q_s = mean + amplitude shape sin(2 pi t / period + phase)
struct Prescribed {
  double mean, amplitude, period, phase;
  [[nodiscard]] double angle(double t) const { return 2.0 * std::numbers::pi * t / period + phase; }
};
constexpr std::array<Prescribed, 5> prescribed{{{0.6, 0.25, 1.1 * horizon, 0.3},
                                                {0.7, 0.20, 0.8 * horizon, 1.0},
                                                {0.5, 0.30, 1.4 * horizon, 2.0},
                                                {0.3, 0.10, 0.9 * horizon, 0.5},
                                                {1.5, 0.60, 1.2 * horizon, 4.0}}};

/// The shipped model with a forcing that makes the prescribed fields a solution. Position and time
/// reach the source as two more species: the shape function, constant in time, and a clock.
struct Forced {
  static constexpr std::size_t n = 7;
  enum : std::size_t { Shape = 5, Clock = 6 };
  FiveSpecies base;

  [[nodiscard]] std::array<Species, n> species() const {
    const auto given = base.species();
    std::array<Species, n> all{};
    std::copy(given.begin(), given.end(), all.begin());
    all[Shape] = {"shape", "shape", 0.0, 0.0, false, 0.0};
    all[Clock] = {"clock", "time", 0.0, 0.0, false, 0.0};
    return all;
  }
  /// d q_s / dt - D lap q_s of the prescribed field.
  static double operator_of(const Prescribed& p, double diffusivity, double shape, double t) {
    return p.amplitude * shape *
           (2.0 * std::numbers::pi / p.period * std::cos(p.angle(t)) +
            3.0 * wave * wave * diffusivity * std::sin(p.angle(t)));
  }
  template <class T>
  [[nodiscard]] std::array<T, n> source(const std::array<T, n>& q, double wound) const {
    const double shape = value_of(q[Shape]);
    const double t = horizon * value_of(q[Clock]);
    std::array<T, 5> now;
    std::array<double, 5> exact{};
    for (std::size_t s = 0; s < 5; ++s) {
      now[s] = q[s];
      exact[s] =
          prescribed[s].mean + prescribed[s].amplitude * shape * std::sin(prescribed[s].angle(t));
    }
    const auto rate = base.source(now, wound);
    const auto exact_rate = base.source(exact, wound);
    const auto given = base.species();
    std::array<T, n> all;
    for (std::size_t s = 0; s < 5; ++s) {
      all[s] =
          rate[s] + T(operator_of(prescribed[s], given[s].diffusivity, shape, t) - exact_rate[s]);
    }
    all[Shape] = T(0.0);
    all[Clock] = T(1.0 / horizon);
    return all;
  }
  static double value_of(double x) { return x; }
  template <std::size_t N>
  static double value_of(const healing::Jet<N>& x) {
    return x.value;
  }
  [[nodiscard]] std::array<double, n> rest() const { return {}; }
  [[nodiscard]] double cells(const std::array<double, n>& q) const { return q[0]; }
  [[nodiscard]] healing::WoundMechanics mechanics() const { return base.mechanics(); }
};

/// The activator with its published rates. Diffusivities are such that every species is carried
/// across the cube within the horizon, otherwise the error in space would not be seen.
FiveSpecies five_species() {
  FiveSpecies::Parameters p{};
  p.regulation = FiveSpecies::Regulation::Activator;
  p.eta0 = p.zeta0 = p.v0 = p.mu0 = 1.0;
  p.eta_init = p.zeta_init = p.xi_init = 0.5;
  p.healthy_clamp = false;
  p.d_eta = 2e-13;
  p.d_zeta = 3e-12;
  p.d_v = 1e-12;
  p.d_xi = 8e-12;
  p.d_mu = 5e-12;
  p.k = 6.3e-6;
  p.chi = 4.0;
  p.h2 = 0.8;
  p.h0 = 10.0;
  p.l = 8.3e-5;
  p.beta_v0 = 1.2e-6;
  p.lambda = 2e-5;
  p.xi_tilde = 0.6;
  p.xi_hat = 0.5;
  p.phi = 1e-5;
  p.phi_xi = 2e-5;
  return FiveSpecies(p);
}

std::vector<double> exact_state(const TetMesh& mesh, double t) {
  std::vector<double> q;
  for (const Vec3& p : mesh.points) {
    const double shape = shape_at(p);
    for (const Prescribed& s : prescribed) {
      q.push_back(s.mean + s.amplitude * shape * std::sin(s.angle(t)));
    }
    q.insert(q.end(), {shape, t / horizon});
  }
  return q;
}

/// The cube with smoothly graded, distorted boxes.
TetMesh distorted_cube(int n) {
  TetMesh mesh = block({edge, edge, edge}, {n, n, n});
  for (Vec3& p : mesh.points) {
    const double bump =
        0.05 * edge * std::sin(wave * p[0]) * std::sin(wave * p[1]) * std::sin(wave * p[2]);
    p += bump * Vec3{1.0, -0.7, 0.5};
  }
  return mesh;
}

std::vector<double> run(const TetMesh& mesh, healing::RdOptions options, const Context& ctx) {
  const auto model = healing::adapt("forced", "", Forced{five_species()});
  healing::ReactionDiffusion rd(mesh, mesh.points, std::vector<double>(mesh.cells.size(), 1.0),
                                *model, options);
  rd.restore(0.0, exact_state(mesh, 0.0));
  rd.advance(horizon, ctx);
  return rd.state();
}

/// Root mean square difference over vertices and the five species.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sum += k % Forced::n < 5 ? (a[k] - b[k]) * (a[k] - b[k]) : 0.0;
  }
  return std::sqrt(sum / (5.0 * static_cast<double>(a.size()) / Forced::n));
}

Findings order_study(const std::string& what, const std::string& unit, const std::vector<double>& x,
                     const std::vector<double>& error, double order, double spread) {
  Findings found;
  const std::vector<double> orders = observed_orders(x, error);
  Table table{"", {what + " [" + unit + "]", "RMS error", "order"}, {}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    table.rows.push_back({fmt::format("{:.4g}", x[i]), fmt::format("{:.3e}", error[i]),
                          i == 0 ? "" : fmt::format("{:.2f}", orders[i - 1])});
  }
  found.tables.push_back(std::move(table));
  found.plots.push_back(
      {"", what + " [" + unit + "]", "RMS error", {{"five species", x, error}}, true, true});
  found.checks.push_back(near("order in " + what + ", two finest", order, orders.back(), spread, "",
                              "observed against theory"));
  return found;
}

Findings space_order(const Context& ctx) {
  std::vector<double> h;
  std::vector<double> error;
  for (const int n : {4, 8, 12, 16}) {
    const TetMesh mesh = distorted_cube(n);
    h.push_back(1e3 * edge / n);
    error.push_back(
        difference(run(mesh, {.relative_tolerance = 1e-8}, ctx), exact_state(mesh, horizon)));
  }
  return order_study("h", "mm", h, error, 2.0, 0.2);
}

/// Against a run of the same mesh with a tight tolerance, so that only the error in time is left.
Findings time_order(healing::Scheme scheme, const Context& ctx) {
  const TetMesh mesh = distorted_cube(3);
  const auto reference = run(mesh, {.relative_tolerance = 1e-11}, ctx);
  std::vector<double> x;
  std::vector<double> error;
  const bool paper = scheme == healing::Scheme::Explicit;
  for (const double step : paper ? std::vector{1600.0, 800.0, 400.0, 200.0}
                                 : std::vector{1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    healing::RdOptions options{.scheme = scheme};
    (paper ? options.dt_s : options.relative_tolerance) = step;
    x.push_back(step);
    error.push_back(difference(run(mesh, options, ctx), reference));
  }
  if (paper) {
    return order_study("dt", "s", x, error, 1.0, 0.1);
  }
  Findings found = order_study("tolerance", "1", x, error, 1.0, 0.2);
  // Steps come in sizes, so single decades scatter: judge the whole range.
  found.checks.front() =
      near("error per tolerance, slope over all decades", 1.0,
           std::log(error.front() / error.back()) / std::log(x.front() / x.back()), 0.2, "",
           "an adaptive method is asked for errors proportional to its tolerance");
  return found;
}

constexpr auto about =
    "The five shipped source terms (activator, all branches of K and Q inside their smooth ranges) "
    "with a forcing that makes prescribed fields in space and time a solution, on a cube of 2 mm "
    "without flux through its faces. ";

}  // namespace

void add_healing_mms(std::vector<Case>& cases) {
  cases.push_back({"mms-species-space", "Manufactured species, order in space",
                   Chapter::CodeVerification, Cost::Fast,
                   std::string(about) + "Lumped P1 on distorted meshes; theory: order 2.",
                   space_order});
  cases.push_back({"mms-species-explicit", "Manufactured species, explicit Euler in time",
                   Chapter::CodeVerification, Cost::Fast,
                   std::string(about) + "The paper's scheme; theory: order 1.",
                   [](const Context& ctx) {
                     return time_order(healing::Scheme::Explicit, ctx);
                   }});
  cases.push_back(
      {"mms-species-cvode", "Manufactured species, CVODE in time", Chapter::CodeVerification,
       Cost::Fast,
       std::string(about) + "Variable-order BDF: the error follows the tolerance (slope 1).",
       [](const Context& ctx) {
         return time_order(healing::Scheme::Cvode, ctx);
       }});
}

}  // namespace sanatrix::verification
