// Newton's method with line search and load continuation; Solver's public face.
#include <algorithm>
#include <chrono>
#include <limits>

#include "core/error.hpp"
#include "mechanics/discrete_body.hpp"

namespace sanatrix::mechanics {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The first trial of a step may raise the residual this much: a membrane that takes up load
/// overshoots once and then converges in fewer iterations than with damped steps (measured: 12
/// instead of 16).
constexpr double allowed_growth = 10.0;

/// Shapes at less than the whole load are starts for the next ones only: of the residual that the
/// load steps take away.
constexpr double tolerance_on_the_way = 1e-3;

// Unloading with P1/P1 only (docs/performance.md, unloading); loading, and Taylor-Hood, need the
// freedom of full steps.
/// No step may take more than the rest of a cell's volume (of the sought shape). A handful of cells
/// at held edges would be turned inside out by the full step, and next to that their forces bury
/// those of the whole body.
constexpr double kept_volume = 0.2;
/// Nor may the first trial raise the residual further than so many times the whole load.
constexpr double ceiling = 5.0;
/// So many steps of which the search leaves less than this: a smaller load step takes less. Six are
/// common where skin tightens, and worth it.
constexpr double crawl = 0.2;
constexpr int allowed_crawls = 8;
/// A load step with at most this many iterations is followed by one of twice the size.
constexpr int quick = 8;
/// Taylor-Hood: a first try at the whole load that is not below its start after this many steps
/// goes astray, and half the load first takes fewer iterations in all (docs/performance.md).
constexpr int trial_steps = 3;
/// Below this share of a step the search direction is no good: the load step is halved instead.
constexpr double smallest_step = 1e-3;

enum class Patience { Little, All };         ///< Little: half the load can still be tried
enum class Tangent { None, AtRest, Exact };  ///< AtRest: membranes answer as at rest

std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b, double s) {
  std::vector<double> r(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    r[i] = a[i] - s * b[i];
  }
  return r;
}

}  // namespace

const std::vector<std::string>& element_names() {
  static const std::vector<std::string> names{"p1p1", "smoothed", "p2p1"};
  return names;
}

Element element_named(const std::string& name) {
  const auto at = std::ranges::find(element_names(), name);
  ensure(at != element_names().end(), "no element is called {}", name);
  return static_cast<Element>(at - element_names().begin());
}

const std::string& name_of(Element element) {
  return element_names()[static_cast<std::size_t>(element)];
}

int cell_layers(Element element) {
  return element == Element::Smoothed ? 2 : 1;
}

std::string title_of(Element element) {
  switch (element) {
    case Element::P1P1:
      return "P1/P1";
    case Element::Smoothed:
      return "smoothed P1/P1";
    case Element::P2P1:
      return "P2/P1";
  }
  return {};
}

void accumulate(SolveReport& sum, const SolveReport& next) {
  sum.converged = next.converged;
  sum.newton_iterations += next.newton_iterations;
  sum.krylov_iterations += next.krylov_iterations;
  sum.factorisations += next.factorisations;
  sum.load_steps += next.load_steps;
  sum.seconds_assembly += next.seconds_assembly;
  sum.seconds_linear += next.seconds_linear;
  sum.seconds_total += next.seconds_total;
  sum.last_residual = next.last_residual;
  sum.min_jacobian = std::min(sum.min_jacobian, next.min_jacobian);
}

struct Solver::Impl {
  DiscreteBody discrete;
  SolveOptions options;
  SolveReport report;
  Unknown unknown = Unknown::Deformed;  ///< of the solve that runs

  Impl(const Body& body, SolveOptions o) : discrete(body), options(o) {}

  bool newton(State& state, const std::vector<double>& target, double share, bool at_rest,
              Patience patience, const Context& ctx, double done);
  bool evaluate(const State& state, const std::vector<double>& target, double share,
                Tangent tangent, std::vector<double>& r);
  double line_search(State& state, const std::vector<double>& direction,
                     const std::vector<double>& target, double share, std::vector<double>& r,
                     double enough, bool is_last);
  /// Is this a problem whose single cells would fold? Fresh wounds are nearly fluid.
  [[nodiscard]] bool folds() const {
    return (unknown == Unknown::Reference || discrete.is_soft()) &&
           discrete.body().element != Element::P2P1;
  }
  State follow_load(State state, bool from_rest, const Context& ctx);
  [[noreturn]] void fail(double load) const;
  Shape solve(Unknown sought, std::span<const Vec3> known, const Vec3& gravity, const Shape* guess,
              const Context& ctx);
};

/// R - share * target at the state and, if wanted, the matrix. False when a cell is inverted.
bool Solver::Impl::evaluate(const State& state, const std::vector<double>& target, double share,
                            Tangent tangent, std::vector<double>& r) {
  const auto start = std::chrono::steady_clock::now();
  const bool valid = tangent == Tangent::None
                         ? discrete.residual(state, r)
                         : discrete.residual_and_matrix(state, r, tangent == Tangent::AtRest);
  report.seconds_assembly += seconds_since(start);
  if (valid) {
    r = minus(r, target, share);
  }
  return valid;
}

/// Backtracking on the norm of R - share * target from the full step, or the largest that spares
/// every cell, generous to that one. Moves the state to a better one, with its residual and, unless
/// that is at most `enough`, its matrix. is_last: the full step is expected to be enough. What the
/// search left of that largest step, 0 where there is no better state.
double Solver::Impl::line_search(State& state, const std::vector<double>& direction,
                                 const std::vector<double>& target, double share,
                                 std::vector<double>& r, double enough, bool is_last) {
  const double before = discrete.norm(r);
  const double growth =
      folds() ? std::clamp(ceiling * discrete.norm(target) / before, 1.0, allowed_growth)
              : allowed_growth;
  const double most = folds() ? discrete.share_within(state, direction, kept_volume) : 1.0;
  for (double alpha = most; alpha >= smallest_step;) {
    State trial = discrete.moved(state, direction, alpha);
    // First trials are nearly always taken, and then their matrix is needed.
    const bool first = alpha == most;
    const bool with_matrix = first && !is_last;
    const bool valid =
        evaluate(trial, target, share, with_matrix ? Tangent::Exact : Tangent::None, r);
    const double after = valid ? discrete.norm(r) : 0.0;
    if (valid && after < (first ? growth : 1.0 - 1e-3 * alpha) * before) {
      state = std::move(trial);
      const bool complete = with_matrix || after <= enough;
      return complete || evaluate(state, target, share, Tangent::Exact, r) ? alpha / most : 0.0;
    }
    // The quadratic through the merit at 0 (slope -2 before^2) and alpha, kept within [0.25, 0.5].
    const double ratio = valid ? after / before : 0.0;
    const double best = valid ? alpha / (ratio * ratio - 1.0 + 2.0 * alpha) * alpha : 0.5 * alpha;
    alpha = std::clamp(best, 0.25 * alpha, 0.5 * alpha);
  }
  return 0.0;
}

/// Solves R(state) = share * target. False when it does not converge; state is then unspecified.
bool Solver::Impl::newton(State& state, const std::vector<double>& target, double share,
                          bool at_rest, Patience patience, const Context& ctx, double done) {
  const double on_the_way = share > 0.0 ? tolerance_on_the_way * discrete.norm(target) : 0.0;
  const double tolerance = std::max(options.relative_tolerance * discrete.load_scale(), on_the_way);
  double first = 0.0;
  double previous = 0.0;
  int crawls = 0;
  std::vector<double> r;
  if (!evaluate(state, target, share, at_rest ? Tangent::AtRest : Tangent::Exact, r)) {
    return false;
  }
  for (int it = 0;; ++it) {
    const double now = discrete.norm(r);
    report.last_residual = now / discrete.load_scale();
    ctx.detail(done,
               fmt::format("load {:.3g} %, Newton {}, residual {:.2e}, min J {:.3f}",
                           100.0 * (1.0 - share), it, report.last_residual, discrete.worst_J()));
    if (now <= tolerance) {
      report.min_jacobian = discrete.worst_J();
      return true;
    }
    first = it == 0 ? now : first;
    const bool astray = patience == Patience::Little && it == trial_steps && now > first;
    const bool spent =
        it == options.max_newton || report.newton_iterations >= options.max_newton_total;
    if (astray || crawls == allowed_crawls || spent || !std::isfinite(now)) {
      return false;
    }
    // Eisenstat and Walker, choice 2 (doi:10.1137/0917003), never tighter than the goal needs.
    const double forcing =
        it == 0 ? 1e-2 : std::min(1e-2, 0.9 * (now / previous) * (now / previous));
    const double linear = std::max({forcing, 0.1 * tolerance / now, 1e-8});
    // Quadratic convergence, but for what the linear solver leaves.
    const double ratio = it == 0 ? 1.0 : now / previous;
    const bool is_last = now * std::max(linear, ratio * ratio) <= tolerance;
    previous = now;
    std::vector<double> direction;
    const auto start = std::chrono::steady_clock::now();
    std::ranges::transform(r, r.begin(), std::negate<>());
    const fem::LinearReport solved = discrete.solve(r, linear, direction);
    report.seconds_linear += seconds_since(start);
    report.krylov_iterations += solved.iterations;
    report.factorisations += solved.factorised ? 1 : 0;
    ++report.newton_iterations;
    const double left = solved.converged
                            ? line_search(state, direction, target, share, r, tolerance, is_last)
                            : 0.0;
    if (left == 0.0) {
      return false;
    }
    crawls += folds() && left < crawl ? 1 : 0;
  }
}

void Solver::Impl::fail(double load) const {
  throw Error(
      Fault::Numerics,
      fmt::format("Newton's method did not converge beyond {:.3g} % of the load in {} iterations "
                  "(residual {:.1e}); the worst cell is {}, det F = {:.3f}",
                  100.0 * load, report.newton_iterations, report.last_residual,
                  discrete.worst_place(), discrete.worst_J()),
      fmt::format(
          "see docs/failing/newton.md: stiffer tissue, a finer mesh there, or element {}",
          name_of(discrete.body().element == Element::P1P1 ? Element::P2P1 : Element::P1P1)));
}

/// Follows R(y) = (1 - s) R(y0) from s = 0, where y0 solves it, to s = 1. From rest that is gravity
/// turned up; from an equilibrium whose tissue or gravity changed it is the change turned up.
State Solver::Impl::follow_load(State state, bool from_rest, const Context& ctx) {
  std::vector<double> start_residual;
  if (!discrete.residual(state, start_residual)) {
    fail(0.0);
  }
  double load = 0.0;
  double step = 1.0;
  bool halved = false;
  while (load < 1.0) {
    const double next = std::min(1.0, load + step);
    State trial = state;
    const bool at_rest = from_rest && load == 0.0;
    const bool may_halve = at_rest && !halved && discrete.body().element == Element::P2P1;
    const Patience patience = may_halve ? Patience::Little : Patience::All;
    const int before = report.newton_iterations;
    if (newton(trial, start_residual, 1.0 - next, at_rest, patience, ctx, load)) {
      state = std::move(trial);
      load = next;
      ++report.load_steps;
      step *= !folds() || report.newton_iterations - before <= quick ? 2.0 : 1.0;
      ctx.at(load, fmt::format("load {:.3g} %", 100.0 * load));
    } else {
      discrete.forget_factorisation();
      halved = true;
      step = 0.5 * (next - load);
      if (step < options.smallest_load_step ||
          report.newton_iterations >= options.max_newton_total) {
        fail(load);
      }
    }
  }
  return state;
}

Solver::Solver(const Body& body, SolveOptions options)
    : impl_(std::make_unique<Impl>(body, options)) {}
Solver::~Solver() = default;

const std::vector<std::array<int, 2>>& Solver::edges() const {
  return impl_->discrete.edges().edges;
}

std::vector<Vec3> Solver::straight_nodes(std::span<const Vec3> vertices) const {
  std::vector<Vec3> nodes(vertices.begin(), vertices.end());
  for (const auto& [a, b] : edges()) {
    nodes.push_back(
        0.5 * (vertices[static_cast<std::size_t>(a)] + vertices[static_cast<std::size_t>(b)]));
  }
  return nodes;
}

void Solver::set_tissue(std::span<const Tissue> tissue) {
  impl_->discrete.set_tissue(tissue);
}

void Solver::set_tolerance(double relative) {
  impl_->options.relative_tolerance = relative;
}

/// From the guess or from rest.
Shape Solver::Impl::solve(Unknown sought, std::span<const Vec3> known, const Vec3& gravity,
                          const Shape* guess, const Context& ctx) {
  const auto start = std::chrono::steady_clock::now();
  report = {};
  unknown = sought;
  discrete.begin(sought, known, gravity);
  State state{{known.begin(), known.end()},
              std::vector<double>(discrete.body().mesh->points.size(), 0.0)};
  if (guess != nullptr) {
    state.nodes = guess->nodes;
    if (!guess->pressure.empty()) {
      state.pressure = guess->pressure;
    }
  }
  discrete.place_supports(state);
  state = follow_load(std::move(state), guess == nullptr, ctx);
  report.converged = true;
  report.seconds_total = seconds_since(start);
  return {std::move(state.nodes), std::move(state.pressure)};
}

Shape Solver::forward(std::span<const Vec3> reference_nodes, const Vec3& gravity,
                      const Shape* guess, const Context& ctx) {
  return impl_->solve(Unknown::Deformed, reference_nodes, gravity, guess, ctx);
}

double Solver::misfit(std::span<const Vec3> reference_nodes, const Vec3& gravity,
                      const Shape& shape) {
  impl_->discrete.begin(Unknown::Deformed, reference_nodes, gravity);
  State state{shape.nodes, shape.pressure};
  state.pressure.resize(impl_->discrete.body().mesh->points.size());  // a body at rest has none
  std::vector<double> r;
  return impl_->discrete.residual(state, r) ? impl_->discrete.norm(r) / impl_->discrete.load_scale()
                                            : std::numeric_limits<double>::infinity();
}

Shape Solver::inverse(std::span<const Vec3> loaded_nodes, const Vec3& gravity, const Context& ctx) {
  return impl_->solve(Unknown::Reference, loaded_nodes, gravity, nullptr, ctx);
}

const SolveReport& Solver::last_report() const {
  return impl_->report;
}

std::vector<double> Solver::jacobians(std::span<const Vec3> reference_nodes,
                                      std::span<const Vec3> deformed_nodes) const {
  return impl_->discrete.jacobians(reference_nodes, deformed_nodes);
}

}  // namespace sanatrix::mechanics
