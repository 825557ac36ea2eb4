#include "verification/healing_sphere.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "geometry/structured_mesh.hpp"
#include "recovery/recovery.hpp"

namespace sanatrix::verification {
namespace {

constexpr double seconds_per_day = 86400.0;

std::size_t index_of(const healing::Model& model, const std::string& key) {
  const auto species = model.species();
  return static_cast<std::size_t>(std::ranges::find(species, key, &healing::Species::key) -
                                  species.begin());
}

void add(SphereHealing& h, const healing::SpeciesRecord& record) {
  const auto put = [&](History& history, double value) {
    history.day.push_back(record.t_day);
    history.value.push_back(value);
  };
  put(h.eta, record.mean[0]);
  put(h.nu, record.mean[2]);
  put(h.xi, record.mean[3]);
  put(h.zeta_far, record.far_field_second);
}

std::size_t centre_of(const TetMesh& mesh) {
  return static_cast<std::size_t>(
      std::ranges::min_element(mesh.points, {}, [](const Vec3& p) { return norm(p); }) -
      mesh.points.begin());
}

/// On the edge of the octant, from the centre to the wall.
RadialProfile cells_along_axis(const TetMesh& mesh, double radius, std::span<const double> species,
                               const healing::Model& model) {
  const std::size_t n = model.species().size();
  std::map<double, double> along;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    if (std::hypot(p[1], p[2]) < 1e-9 && p[0] < radius * (1.0 + 1e-9)) {
      along[p[0]] = model.cells(species.subspan(v * n, n));
    }
  }
  RadialProfile profile;
  for (const auto& [r, density] : along) {
    profile.radius.push_back(r);
    profile.density.push_back(density);
  }
  return profile;
}

}  // namespace

double History::at(double when) const {
  const auto next = std::ranges::lower_bound(day, when) - day.begin();
  if (next == 0) {
    return value.front();
  }
  if (next == static_cast<std::ptrdiff_t>(day.size())) {
    return value.back();
  }
  const auto i = static_cast<std::size_t>(next);
  const double share = (when - day[i - 1]) / (day[i] - day[i - 1]);
  return value[i - 1] + share * (value[i] - value[i - 1]);
}

double History::time_of(double level) const {
  for (std::size_t i = 1; i < value.size(); ++i) {
    if ((value[i - 1] - level) * (value[i] - level) <= 0.0 && value[i] != value[i - 1]) {
      return day[i - 1] +
             (level - value[i - 1]) / (value[i] - value[i - 1]) * (day[i] - day[i - 1]);
    }
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TetMesh wounded_ball(double radius, int layers) {
  return ball_octant(graded_radii(radius, layers, 3.0 * radius, 1.4));
}

TetMesh ball_with_fine_wall(double radius, double thinnest, double growth) {
  std::vector<double> inwards;  // thicknesses from the wall
  double h = thinnest;
  double rest = radius;
  for (; rest > 1.6 * h; h *= growth) {
    inwards.push_back(h);
    rest -= h;
  }
  std::vector<double> radii{0.0, rest};
  for (const double thickness : inwards | std::views::reverse) {
    radii.push_back(radii.back() + thickness);
  }
  const double outer = 3.0 * radius;
  for (h = thinnest; radii.back() < outer; h *= growth) {
    const double next = radii.back() + h;
    radii.push_back(next > outer - 0.5 * h ? outer : next);
  }
  return ball_octant(radii);
}

std::vector<double> wound_of(const TetMesh& mesh, double radius) {
  return cells_where(mesh, [=](const Vec3& p) { return norm(p) < radius; });
}

SphereHealing heal_species(const std::string& preset, double radius, int layers, double days,
                           const Context& ctx) {
  const TetMesh mesh = wounded_ball(radius, layers);
  const auto wound = wound_of(mesh, radius);
  const auto model = healing::make_model(preset, std::vector<std::string>{"zeta_init=0"});
  healing::ReactionDiffusion rd(mesh, mesh.points, wound, *model, {});
  const std::size_t nu = centre_of(mesh) * model->species().size() + index_of(*model, "nu");
  SphereHealing h;
  const auto note = [&] {
    add(h, healing::record(rd, mesh, mesh.points, wound, *model));
    h.centre_nu.day.push_back(h.eta.day.back());
    h.centre_nu.value.push_back(rd.state()[nu]);
  };
  for (double from = 0.0; from < days; from += 6.0) {
    const double to = std::min(from + 6.0, days);
    std::vector<double> times;
    for (double t = from; t < to; t += 0.5) {
      times.push_back(t * seconds_per_day);
    }
    rd.advance(to * seconds_per_day, ctx, times, note);
  }
  note();
  return h;
}

SphereHealing heal_body(const std::string& preset, const TetMesh& mesh, double radius, double days,
                        const Context& ctx, mechanics::Element element) {
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element;
  body.fixed = symmetry_supports(mesh);
  body.tissue.assign(mesh.cells.size(), healthy_tissue);
  const auto model = healing::make_model(preset);
  recovery::Problem problem;
  problem.body = &body;
  const std::vector<Vec3> nodes = mechanics::Solver(body).straight_nodes(mesh.points);
  problem.reference_nodes = nodes;
  problem.start = {nodes, {}};
  problem.species_points = mesh.points;
  problem.wound_fraction = wound_of(mesh, radius);
  problem.model = model.get();
  problem.schedule.days = days;
  const std::size_t nu = centre_of(mesh) * model->species().size() + index_of(*model, "nu");
  SphereHealing h;
  const auto observe = [&](double day, std::span<const double> species, const mechanics::Shape&) {
    h.centre_nu.day.push_back(day);
    h.centre_nu.value.push_back(species[nu]);
    h.cells[day] = cells_along_axis(mesh, radius, species, *model);
  };
  const recovery::Result result = recovery::heal(
      problem, {}, [](const recovery::Checkpoint&) {}, observe, ctx);
  for (const recovery::HistoryRow& row : result.history) {
    add(h, row.species);
    h.volume.day.push_back(row.species.t_day);
    h.volume.value.push_back(row.volume_ratio);
  }
  return h;
}

}  // namespace sanatrix::verification
