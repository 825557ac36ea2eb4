#include "healing/reaction_diffusion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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
       const Model& m, const RdOptions& options)
      : model(m),
        cells(mesh.cells),
        system(mesh, points, wound_fraction, m, fem::rank(), fem::ranks()),
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
    state = gathered(system.at_own_vertices(own));
    time = t;
    for (const double q : state) {
      if (!std::isfinite(q)) {
        throw Error(Fault::Numerics,
                    fmt::format("healing: a species is not finite on day {:.2f}", t / day),
                    "use scheme=cvode or a smaller dt_s");
      }
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
                                     RdOptions options) {
  ensure(points.size() == mesh.points.size() && wound_fraction.size() == mesh.cells.size(),
         "healing needs a position per vertex and a wound fraction per cell");
  require(options.relative_tolerance > 0.0 && options.relative_tolerance < 1.0,
          "healing: relative tolerance {} is outside (0, 1)", options.relative_tolerance);
  impl_ = std::make_unique<Impl>(mesh, points, wound_fraction, model, options);
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

SpeciesRecord record(const ReactionDiffusion& rd, const TetMesh& mesh, std::span<const Vec3> points,
                     std::span<const double> wound_fraction, const Model& model) {
  const std::size_t n = model.species().size();
  const std::vector<double>& q = rd.state();
  SpeciesRecord r{};
  r.t_day = rd.time_s() / day;
  r.mean.resize(n);
  double wound_volume = 0.0;
  Vec3 centroid{};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (wound_fraction[c] <= 0.0) {
      continue;
    }
    const auto& [v0, v1, v2, v3] = mesh.cells[c];
    const double v = wound_fraction[c] * volume(points[v0], points[v1], points[v2], points[v3]);
    for (const int i : mesh.cells[c]) {
      if (!rd.wound_vertices()[i]) {
        continue;
      }
      wound_volume += 0.25 * v;
      centroid += 0.25 * v * points[i];
      for (std::size_t s = 0; s < n; ++s) {
        r.mean[s] += 0.25 * v * q[i * n + s];
      }
    }
  }
  require(wound_volume > 0.0, "healing: the wound has no volume");
  for (double& m : r.mean) {
    m /= wound_volume;
  }
  centroid = (1.0 / wound_volume) * centroid;
  const auto distance2 = [&](std::size_t i) {
    return dot(points[i] - centroid, points[i] - centroid);
  };
  std::size_t nearest = 0, farthest = 0;
  r.eta_healthy_min = std::numeric_limits<double>::max();
  r.eta_healthy_max = std::numeric_limits<double>::lowest();
  for (std::size_t i = 0; i < points.size(); ++i) {
    nearest = distance2(i) < distance2(nearest) ? i : nearest;
    farthest = distance2(i) > distance2(farthest) ? i : farthest;
    if (!rd.wound_vertices()[i]) {
      r.eta_healthy_min = std::min(r.eta_healthy_min, q[i * n]);
      r.eta_healthy_max = std::max(r.eta_healthy_max, q[i * n]);
    }
  }
  r.centre.assign(q.begin() + nearest * n, q.begin() + (nearest + 1) * n);
  r.far_field_second = q[farthest * n + std::min<std::size_t>(1, n - 1)];
  return r;
}

}  // namespace sanatrix::healing
