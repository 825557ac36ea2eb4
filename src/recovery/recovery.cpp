#include "recovery/recovery.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "fem/mesh_share.hpp"
#include "recovery/wound_shape.hpp"

namespace sanatrix::recovery {

namespace {

constexpr double day_s = 86400.0;
/// Species do not feel the shape, so that no error of a shape on the way reaches the end. This much
/// of the load, unbalanced, moves the curve of volumes by 1e-6 and nothing by a micrometre; it
/// saves a third of the Newton steps.
constexpr double tolerance_on_the_way = 1e-4;
/// Of day 0, whose volume is the measure of all later ones, and of the end, which stays.
constexpr double tolerance_of_results = mechanics::SolveOptions{}.relative_tolerance;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What one mechanics solve tells the history.
struct Measured {
  double eta_mean, volume_ratio, max_displacement_mm, wall_displacement_mm, min_jacobian;
};

/// A history row to be, and the species (vertices x species) of a day that is observed without an
/// equilibrium of its own.
struct Sample {
  healing::SpeciesRecord record;
  std::vector<double> species;
};

/// A change of mean cell density that tells nothing.
constexpr double least_change = 1e-6;

/// On the line through two shapes: s = 0 the first, 1 the second.
mechanics::Shape on_line(const mechanics::Shape& a, const mechanics::Shape& b, double s) {
  mechanics::Shape shape = b;
  for (std::size_t n = 0; n < shape.nodes.size(); ++n) {
    shape.nodes[n] += (s - 1.0) * (b.nodes[n] - a.nodes[n]);
  }
  for (std::size_t v = 0; v < shape.pressure.size(); ++v) {
    shape.pressure[v] += (s - 1.0) * (b.pressure[v] - a.pressure[v]);
  }
  return shape;
}

class Recovery {
 public:
  Recovery(const Problem& problem, const Save& save, const Observe& observe)
      : problem_(problem),
        save_(save),
        observe_(observe),
        mesh_(*problem.body->mesh),
        share_(problem.body->share),
        species_(mesh_, problem.species_points, problem.wound_fraction, *problem.model,
                 problem.species_options, share_),
        solver_(*problem.body),
        wound_(mesh_, problem.wound_fraction, problem.reference_nodes.first(mesh_.points.size()),
               problem.body->tissue, share_),
        has_skin_(fem::largest(share_, problem.body->skin_faces.empty() ? 0.0 : 1.0) > 0.0) {
    result_.totals.min_jacobian = 1.0;
  }

  Result run(const std::optional<Checkpoint>& resume, const Context& ctx);

 private:
  [[nodiscard]] std::vector<mechanics::Tissue> tissue_now(bool traction) const;
  void solve_mechanics(bool traction, double density, double tolerance, const Context& ctx);
  [[nodiscard]] std::optional<mechanics::Shape> predicted(double density) const;
  void advance_species(std::vector<Sample>& samples, const Context& ctx);
  void operate(const Context& ctx);
  void continue_from(const Checkpoint& checkpoint);
  [[nodiscard]] Checkpoint checkpoint() const;
  void step(const Context& ctx);
  void look_back(const std::vector<Sample>& samples, const Measured& next);
  [[nodiscard]] Measured measure(double eta_mean) const;
  [[nodiscard]] healing::SpeciesRecord record_species() const {
    return healing::record(species_, mesh_, problem_.species_points, problem_.wound_fraction,
                           *problem_.model);
  }
  [[nodiscard]] std::span<const Vec3> vertices(const mechanics::Shape& s) const {
    return std::span(s.nodes).first(mesh_.points.size());
  }

  const Problem& problem_;
  const Save& save_;
  const Observe& observe_;
  const TetMesh& mesh_;
  const fem::MeshShare* share_;
  healing::ReactionDiffusion species_;
  mechanics::Solver solver_;
  WoundShape wound_;
  bool has_skin_;
  mechanics::Shape shape_, earlier_;  ///< after the last mechanics step, and after the one before
  double earlier_density_ = 0.0;
  double volume0_ = 0.0;
  Measured last_{};
  Result result_;
};

/// Contraction follows the mean cell density (dV/V = -T0 <eta> / (kappa + 4 mu / 3) to first
/// order), and so does the shape: the last two shapes, continued to the next density.
std::optional<mechanics::Shape> Recovery::predicted(double density) const {
  const double last = last_.eta_mean - earlier_density_;
  if (earlier_.nodes.empty() || std::abs(last) < least_change) {
    return std::nullopt;
  }
  return on_line(earlier_, shape_, (density - earlier_density_) / last);
}

std::vector<mechanics::Tissue> Recovery::tissue_now(bool traction) const {
  healing::WoundMechanics wound = problem_.model->mechanics();
  wound.active_stress = traction ? wound.active_stress : 0.0;
  return healing_tissue(problem_.body->tissue, problem_.wound_fraction, species_.cell_density(),
                        wound);
}

/// Equilibrium with the tissue of the moment. It starts from the last one, from the prediction,
/// from the body before surgery or from the hint, whichever is nearest to it: a wound of some days
/// is closer to healthy tissue than to a fresh one, in which tissue flows. `density`: the mean cell
/// density for which it is.
void Recovery::solve_mechanics(bool traction, double density, double tolerance,
                               const Context& ctx) {
  solver_.set_tissue(tissue_now(traction));
  solver_.set_tolerance(tolerance);
  const double start = now_s();
  const std::optional<mechanics::Shape> continued = predicted(density);
  const mechanics::Shape* guess = &shape_;
  const std::optional<mechanics::Shape> hint =
      problem_.hint ? problem_.hint(species_.time_s() / day_s) : std::nullopt;
  std::vector<const mechanics::Shape*> others;
  for (const auto& maybe : {&continued, &hint}) {
    if (maybe->has_value()) {
      others.push_back(&**maybe);
    }
  }
  if (!result_.history.empty()) {  // day 0 starts there
    others.push_back(&problem_.start);
  }
  const auto misfit = [&](const mechanics::Shape& shape) {
    return solver_.misfit(problem_.reference_nodes, problem_.gravity, shape);
  };
  double least = others.empty() ? 0.0 : misfit(shape_);
  for (const mechanics::Shape* other : others) {
    if (const double its = misfit(*other); its < least) {
      guess = other;
      least = its;
    }
  }
  mechanics::Shape next = solver_.forward(problem_.reference_nodes, problem_.gravity, guess, ctx);
  earlier_ = std::move(shape_);
  earlier_density_ = last_.eta_mean;
  shape_ = std::move(next);
  result_.seconds_mechanics += now_s() - start;
  mechanics::accumulate(result_.totals, solver_.last_report());
}

Measured Recovery::measure(double eta_mean) const {
  Measured m{};
  m.eta_mean = eta_mean;
  const auto before = vertices(problem_.start);
  const auto after = vertices(shape_);
  const std::vector<double> J = solver_.jacobians(problem_.reference_nodes, shape_.nodes);
  m.min_jacobian = -fem::largest(share_, -*std::ranges::min_element(J));
  m.volume_ratio = wound_.volume(J, shape_.pressure) / volume0_;
  m.wall_displacement_mm = 1e3 * wound_.mean_inward_displacement(before, after);
  const auto consider = [&](std::size_t v) {
    m.max_displacement_mm = std::max(m.max_displacement_mm, 1e3 * norm(after[v] - before[v]));
  };
  for (const auto& face : problem_.body->skin_faces) {
    for (const int v : face.vertex) {
      consider(static_cast<std::size_t>(v));
    }
  }
  for (std::size_t v = 0; v < before.size() && !has_skin_; ++v) {
    consider(v);
  }
  m.max_displacement_mm = fem::largest(share_, m.max_displacement_mm);
  return m;
}

/// Day 0: the excised tissue becomes a fresh wound. Its volume in this equilibrium, before cells
/// pull, is the V0 of the history.
void Recovery::operate(const Context& ctx) {
  const healing::SpeciesRecord species = record_species();
  during("mechanics at day 0",
         [&] { solve_mechanics(false, species.mean[0], tolerance_of_results, ctx); });
  volume0_ =
      wound_.volume(solver_.jacobians(problem_.reference_nodes, shape_.nodes), shape_.pressure);
  earlier_ = {};  // before surgery: nothing to continue from
  last_ = measure(species.mean[0]);
  result_.history.push_back({species, last_.volume_ratio, last_.max_displacement_mm,
                             last_.wall_displacement_mm, last_.min_jacobian});
}

Checkpoint Recovery::checkpoint() const {
  return {.t_s = species_.time_s(),
          .wound_volume_m3 = volume0_,
          .species = species_.state(),
          .shape = shape_,
          .earlier = earlier_,
          .earlier_density = earlier_density_,
          .history = result_.history};
}

void Recovery::continue_from(const Checkpoint& checkpoint) {
  species_.restore(checkpoint.t_s, checkpoint.species);
  volume0_ = checkpoint.wound_volume_m3;
  shape_ = checkpoint.shape;
  earlier_ = checkpoint.earlier;
  earlier_density_ = checkpoint.earlier_density;
  result_.history = checkpoint.history;
  const HistoryRow& row = result_.history.back();
  last_ = {row.species.mean[0], row.volume_ratio, row.max_displacement_mm, row.wall_displacement_mm,
           row.min_jacobian};
}

/// Until the next equilibrium is due: at the end, or when the wound has changed enough. Species
/// begin anew wherever one is looked for, or rounding would grow to the tolerance in long runs and
/// ranks would disagree (docs/theory/healing.md).
void Recovery::advance_species(std::vector<Sample>& samples, const Context& ctx) {
  const Schedule& schedule = problem_.schedule;
  const double every = schedule.record_interval_days;
  for (bool due = false; !due;) {
    const double from = species_.time_s() / day_s;
    const double to = std::min(schedule.days, from + schedule.mechanics_interval_days);
    std::vector<double> times;
    for (double k = std::floor(from / every + 1e-9) + 1.0; k * every < to - 1e-9; ++k) {
      times.push_back(k * every * day_s);
    }
    const auto note = [&] {
      samples.push_back({record_species(), {}});
    };
    species_.advance(to * day_s, ctx.part(from / schedule.days, to / schedule.days), times, note);
    note();
    const double change = std::abs(samples.back().record.mean[0] - last_.eta_mean);
    due = to >= schedule.days || change >= schedule.mechanics_density_change;
    if (!due) {
      samples.back().species = species_.state();
    }
  }
}

/// History rows, and shapes at the days that had no equilibrium of their own. Between two
/// equilibria the shape follows the mean cell density: contraction has no lag of its own
/// (quasi-static), and to first order dV/V = -T0 <eta> / (kappa + 4 mu / 3).
void Recovery::look_back(const std::vector<Sample>& samples, const Measured& next) {
  const double from = result_.history.back().species.t_day;
  for (const Sample& sample : samples) {
    const healing::SpeciesRecord& r = sample.record;
    const double change = next.eta_mean - last_.eta_mean;
    const double s = std::abs(change) > least_change
                         ? (r.mean[0] - last_.eta_mean) / change
                         : (r.t_day - from) / (samples.back().record.t_day - from);
    result_.history.push_back({r, std::lerp(last_.volume_ratio, next.volume_ratio, s),
                               std::lerp(last_.max_displacement_mm, next.max_displacement_mm, s),
                               std::lerp(last_.wall_displacement_mm, next.wall_displacement_mm, s),
                               next.min_jacobian});
    if (!sample.species.empty()) {
      observe_(r.t_day, sample.species, on_line(earlier_, shape_, s));
    }
  }
}

/// Species until the next equilibrium is due, and that equilibrium.
void Recovery::step(const Context& ctx) {
  const double days = problem_.schedule.days;
  std::vector<Sample> samples;
  const double start = now_s();
  during(fmt::format("species after day {:g}", species_.time_s() / day_s),
         [&] { advance_species(samples, ctx); });
  result_.seconds_species += now_s() - start;
  const double day = samples.back().record.t_day;
  const double density = samples.back().record.mean[0];
  during(fmt::format("mechanics at day {:g}", day), [&] {
    solve_mechanics(true, density, day < days ? tolerance_on_the_way : tolerance_of_results,
                    ctx.part(day / days, day / days));
  });
  const Measured next = measure(density);
  look_back(samples, next);
  last_ = next;
  observe_(day, species_.state(), shape_);
  ctx.at(day / days, fmt::format("day {:g}: wound at {:.1f} % of its volume, cells {:.0f} %", day,
                                 100.0 * last_.volume_ratio, 100.0 * last_.eta_mean));
}

Result Recovery::run(const std::optional<Checkpoint>& resume, const Context& ctx) {
  problem_.model->check_steady_state();
  shape_ = problem_.start;
  const Schedule& schedule = problem_.schedule;
  require(schedule.days > 0.0 && schedule.mechanics_interval_days > 0.0,
          "healing needs positive days and mechanics_interval_days, got {:g} and {:g}",
          schedule.days, schedule.mechanics_interval_days);
  if (resume) {
    continue_from(*resume);
  } else {
    operate(ctx.part(0.0, 0.05));
    observe_(0.0, species_.state(), shape_);
  }
  while (species_.time_s() < schedule.days * day_s - 1.0) {
    step(ctx.part(0.05, 1.0));
    save_(checkpoint());
  }
  result_.healed = shape_;
  result_.tissue = tissue_now(true);  // also of a run that resumed with nothing left to compute
  result_.species = species_.state();
  return result_;
}

}  // namespace

Result heal(const Problem& problem, const std::optional<Checkpoint>& resume, const Save& save,
            const Observe& observe, const Context& ctx) {
  ensure(problem.body != nullptr && problem.model != nullptr, "healing without a body or a model");
  const double wounded =
      fem::largest(problem.body->share, *std::ranges::max_element(problem.wound_fraction));
  require(wounded > 0.0, "the wound is empty: no cell lies in the resection");
  return Recovery(problem, save, observe).run(resume, ctx);
}

}  // namespace sanatrix::recovery
