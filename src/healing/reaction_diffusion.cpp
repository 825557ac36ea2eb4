#include "healing/reaction_diffusion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <mpi.h>

#include "core/error.hpp"
#include "fem/session.hpp"
#include "healing/ghosted_vector.hpp"
#include "healing/stepper.hpp"
#include "healing/system.hpp"

namespace sanatrix::healing {
namespace {

constexpr double day = 86400.0;

/// Listens for a stop on every rank at the same step: a rank alone must not leave the others
/// waiting in a sum.
void report(const Context& ctx, double fraction, double t) {
  int stop = 0;
  try {
    ctx.at(fraction, fmt::format("day {:.1f}", t / day));
  } catch (const Cancelled&) {
    stop = 1;
  }
  if (fem::ranks() > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  }
  if (stop != 0) {
    throw Cancelled{};
  }
}

}  // namespace

struct ReactionDiffusion::Impl {
  Impl(const TetMesh& mesh, std::span<const Vec3> points, std::span<const double> wound_fraction,
       const Model& m, const RdOptions& options, const fem::MeshShare* share)
      : model(m),
        cells(mesh.cells),
        system(mesh, points, wound_fraction, m, share),
        state(system.initial_state()) {
    if (options.scheme == Scheme::Cvode) {
      stepper = make_cvode(system, options.relative_tolerance);
    } else {
      system.linearise(unknowns());
      stepper = make_explicit(system, m, options.dt_s);
      steps_per_report = 64;  // an explicit step costs less than saying so
    }
  }

  [[nodiscard]] std::vector<double> unknowns() const {
    std::vector<double> own(system.own_unknowns());
    system.pick_unknowns(state, own);
    return own;
  }

  void gather(double t) {
    std::vector<double> own(system.own_unknowns());
    stepper->state_at(t, own);
    state = system.at_vertices(own);
    time = t;
    const bool finite = std::ranges::all_of(state, [](double q) { return std::isfinite(q); });
    if (fem::largest(system.share(), finite ? 0.0 : 1.0) > 0.0) {
      throw Error(Fault::Numerics,
                  fmt::format("healing: a species is not finite on day {:.2f}", t / day),
                  "use scheme=cvode or a smaller dt_s");
    }
  }

  const Model& model;
  std::vector<std::array<int, 4>> cells;
  System system;
  std::unique_ptr<Stepper> stepper;
  std::vector<double> state;
  double time = 0.0;
  long steps = 0;
  long steps_per_report = 1;
};

ReactionDiffusion::ReactionDiffusion(const TetMesh& mesh, std::span<const Vec3> points,
                                     std::span<const double> wound_fraction, const Model& model,
                                     RdOptions options, const fem::MeshShare* share) {
  ensure(points.size() == mesh.points.size() && wound_fraction.size() == mesh.cells.size(),
         "healing needs a position per vertex and a wound fraction per cell");
  require(options.relative_tolerance > 0.0 && options.relative_tolerance < 1.0,
          "healing: relative tolerance {} is outside (0, 1)", options.relative_tolerance);
  impl_ = std::make_unique<Impl>(mesh, points, wound_fraction, model, options, share);
}

ReactionDiffusion::~ReactionDiffusion() = default;

void ReactionDiffusion::advance(double t_s, const Context& ctx,
                                std::span<const double> record_times_s,
                                const std::function<void()>& on_record) {
  Impl& im = *impl_;
  const double begin = im.time;
  ensure(t_s >= begin, "healing cannot go back from {} s to {} s", begin, t_s);
  auto next_record = std::ranges::lower_bound(record_times_s, begin);
  const auto record_until = [&](double t) {
    for (; next_record != record_times_s.end() && *next_record <= t; ++next_record) {
      if (*next_record > begin) {
        im.gather(*next_record);
      }
      on_record();
    }
  };
  record_until(begin);
  if (t_s == begin) {
    return;
  }
  im.stepper->start(begin, im.unknowns());
  for (double t = begin; t < t_s;) {
    t = im.stepper->step(t_s);
    ++im.steps;
    record_until(t);
    if (im.steps % im.steps_per_report == 0) {
      report(ctx, (t - begin) / (t_s - begin), t);
    }
  }
  im.gather(t_s);
}

double ReactionDiffusion::time_s() const {
  return impl_->time;
}
const std::vector<double>& ReactionDiffusion::state() const {
  return impl_->state;
}
long ReactionDiffusion::steps() const {
  return impl_->steps;
}

const fem::MeshShare* ReactionDiffusion::share() const {
  return impl_->system.share();
}

const std::vector<bool>& ReactionDiffusion::wound_vertices() const {
  return impl_->system.wound().vertex;
}

void ReactionDiffusion::restore(double t_s, std::span<const double> state) {
  require(state.size() == impl_->state.size(),
          "healing: a stored state of {} numbers does not fit {} vertices of {} species",
          state.size(), impl_->system.wound().vertex.size(), impl_->model.species().size());
  impl_->state.assign(state.begin(), state.end());
  impl_->time = t_s;
}

std::vector<double> ReactionDiffusion::cell_density() const {
  const std::size_t n = impl_->model.species().size();
  std::vector<double> at_vertex(impl_->state.size() / n);
  for (std::size_t i = 0; i < at_vertex.size(); ++i) {
    at_vertex[i] = impl_->model.cells(std::span(impl_->state).subspan(i * n, n));
  }
  std::vector<double> density;
  density.reserve(impl_->cells.size());
  const std::vector<bool>& wound = impl_->system.wound().vertex;
  for (const auto& cell : impl_->cells) {
    double sum = 0.0, all = 0.0;
    int counted = 0;
    for (const int v : cell) {
      all += at_vertex[v];
      sum += wound[v] ? at_vertex[v] : 0.0;
      counted += wound[v] ? 1 : 0;
    }
    density.push_back(counted > 0 ? sum / counted : 0.25 * all);
  }
  return density;
}

namespace {

/// Of all vertices the one of the least score, where this process owns it, else nothing. Among
/// scores that are equal but for rounding the first vertex of the whole mesh wins, so that the
/// choice does not hang on the order in which the shares' sums were taken.
std::optional<std::size_t> least(const fem::MeshShare* share, std::span<const double> score) {
  double lowest = std::numeric_limits<double>::max();
  for (std::size_t v = 0; v < score.size(); ++v) {
    lowest = fem::owns_vertex(share, v) ? std::min(lowest, score[v]) : lowest;
  }
  lowest = -fem::largest(share, -lowest);
  const double rounding = 1e-12 * std::abs(lowest);
  std::optional<std::size_t> found;
  double first = std::numeric_limits<double>::max();
  for (std::size_t v = 0; v < score.size(); ++v) {
    const double number = share == nullptr ? static_cast<double>(v) : share->vertex()[v];
    if (fem::owns_vertex(share, v) && score[v] <= lowest + rounding && number < first) {
      found = v;
      first = number;
    }
  }
  return -fem::largest(share, -first) == first ? found : std::nullopt;
}

/// Species at a vertex that one process owns, on every process.
std::vector<double> species_at(std::optional<std::size_t> vertex, const ReactionDiffusion& rd,
                               std::size_t species) {
  std::vector<double> q(species);
  if (vertex) {
    std::ranges::copy(std::span(rd.state()).subspan(*vertex * species, species), q.begin());
  }
  fem::sum_each(rd.share(), q);
  return q;
}

/// Means of the species over the wound [0, n), its volume, and three sums for its centroid.
std::vector<double> wound_sums(const ReactionDiffusion& rd, const TetMesh& mesh,
                               std::span<const Vec3> points, std::span<const double> wound_fraction,
                               std::size_t n) {
  const std::vector<double>& q = rd.state();
  std::vector<double> sums(n + 4);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (wound_fraction[c] <= 0.0 || !fem::owns_cell(rd.share(), c)) {
      continue;
    }
    const auto& [v0, v1, v2, v3] = mesh.cells[c];
    const double v = wound_fraction[c] * volume(points[v0], points[v1], points[v2], points[v3]);
    for (const int i : mesh.cells[c]) {
      if (!rd.wound_vertices()[i]) {
        continue;
      }
      sums[n] += 0.25 * v;
      for (std::size_t d = 0; d < 3; ++d) {
        sums[n + 1 + d] += 0.25 * v * points[i][d];
      }
      for (std::size_t s = 0; s < n; ++s) {
        sums[s] += 0.25 * v * q[i * n + s];
      }
    }
  }
  fem::sum_each(rd.share(), sums);
  return sums;
}

}  // namespace

SpeciesRecord record(const ReactionDiffusion& rd, const TetMesh& mesh, std::span<const Vec3> points,
                     std::span<const double> wound_fraction, const Model& model) {
  const std::size_t n = model.species().size();
  const std::vector<double> sums = wound_sums(rd, mesh, points, wound_fraction, n);
  const double wound_volume = sums[n];
  require(wound_volume > 0.0, "healing: the wound has no volume");
  SpeciesRecord r{};
  r.t_day = rd.time_s() / day;
  for (std::size_t s = 0; s < n; ++s) {
    r.mean.push_back(sums[s] / wound_volume);
  }
  const Vec3 centroid = (1.0 / wound_volume) * Vec3{sums[n + 1], sums[n + 2], sums[n + 3]};
  std::vector<double> near(points.size()), far(points.size());
  double lowest = std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::lowest();
  for (std::size_t i = 0; i < points.size(); ++i) {
    near[i] = dot(points[i] - centroid, points[i] - centroid);
    far[i] = -near[i];
    if (!rd.wound_vertices()[i]) {
      lowest = std::min(lowest, rd.state()[i * n]);
      highest = std::max(highest, rd.state()[i * n]);
    }
  }
  r.eta_healthy_min = -fem::largest(rd.share(), -lowest);
  r.eta_healthy_max = fem::largest(rd.share(), highest);
  r.centre = species_at(least(rd.share(), near), rd, n);
  r.far_field_second = species_at(least(rd.share(), far), rd, n)[std::min<std::size_t>(1, n - 1)];
  return r;
}

}  // namespace sanatrix::healing
