#include "pipeline/problem_solver.hpp"

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "fem/session.hpp"
#include "fem/transfer.hpp"
#include "io/mesh_file.hpp"
#include "pipeline/artefacts.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

struct Solution {
  mechanics::Shape shape;        ///< loaded, or unloaded for Inverse
  std::vector<double> jacobian;  ///< per cell, loaded against unloaded
  mechanics::SolveReport report;
  double volume_ratio = 1.0;  ///< loaded against unloaded
  std::optional<recovery::Result> recovery;
};

double total_volume(const SolveProblem& p, std::span<const Vec3> points) {
  const std::vector<double> volumes = cell_volumes(p.mesh, points);
  double mine = 0.0;
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    mine += fem::owns_cell(p.share.get(), c) ? volumes[c] : 0.0;
  }
  return fem::sum(p.share.get(), mine);
}

Solution solve_healing(const SolveProblem& p, mechanics::Solver& solver,
                       const std::vector<Vec3>& nodes, const Context& ctx) {
  Solution s;
  mechanics::Shape start{nodes, {}};
  if (norm(p.gravity) > 0) {
    start = solver.forward(nodes, p.gravity, nullptr, ctx.part(0.0, 0.1));
    s.report = solver.last_report();
  } else {
    s.report.min_jacobian = 1.0;
  }
  const std::span<const Vec3> points = vertices(p.mesh, start);
  recovery::Problem problem;
  problem.body = &p.body;
  problem.reference_nodes = nodes;
  problem.start = start;
  problem.species_points = points;
  problem.wound_fraction = p.healing->wound_fraction;
  problem.gravity = p.gravity;
  problem.model = p.healing->model.get();
  problem.species_options = p.healing->species;
  problem.schedule = p.healing->schedule;
  s.recovery = recovery::heal(
      problem, {}, [](const recovery::Checkpoint&) {},
      [](double, std::span<const double>, const mechanics::Shape&) {}, ctx.part(0.1, 1.0));
  s.shape = s.recovery->healed;
  mechanics::accumulate(s.report, s.recovery->totals);
  s.jacobian = solver.jacobians(nodes, s.shape.nodes);
  for (const recovery::HistoryRow& row : s.recovery->history) {
    s.report.min_jacobian = std::min(s.report.min_jacobian, row.min_jacobian);
  }
  s.report.min_jacobian =
      std::min(s.report.min_jacobian, -fem::largest(p.share.get(), -std::ranges::min(s.jacobian)));
  return s;
}

Solution solve(SolveProblem& p, const Context& ctx) {
  p.body.mesh = &p.mesh;
  mechanics::Solver solver(p.body);
  const std::vector<Vec3> nodes = solver.straight_nodes(p.mesh.points);
  const double given = total_volume(p, p.mesh.points);
  if (p.mode == Mode::Healing) {
    Solution s = solve_healing(p, solver, nodes, ctx);
    s.volume_ratio = total_volume(p, vertices(p.mesh, s.shape)) / given;
    return s;
  }
  Solution s;
  if (p.mode == Mode::Forward) {
    s.shape = solver.forward(nodes, p.gravity, nullptr, ctx);
    s.jacobian = solver.jacobians(nodes, s.shape.nodes);
    s.volume_ratio = total_volume(p, vertices(p.mesh, s.shape)) / given;
  } else {
    s.shape = solver.inverse(nodes, p.gravity, ctx);
    s.jacobian = solver.jacobians(s.shape.nodes, nodes);
    s.volume_ratio = given / total_volume(p, vertices(p.mesh, s.shape));
  }
  s.report = solver.last_report();
  return s;
}

std::vector<Vec3> displacements(const SolveProblem& p, const Solution& s) {
  const std::span<const Vec3> points = vertices(p.mesh, s.shape);
  std::vector<Vec3> moved(points.size());
  std::ranges::transform(points, p.mesh.points, moved.begin(),
                         [](const Vec3& now, const Vec3& was) { return now - was; });
  return moved;
}

io::Fields fields_of(const SolveProblem& p, const Solution& s) {
  io::Fields fields;
  fields.point.push_back(io::vector_field("displacement", displacements(p, s)));
  std::vector<double> pressure = s.shape.pressure;
  pressure.resize(p.mesh.points.size(), 0.0);
  fields.point.push_back(io::scalar_field("pressure", std::move(pressure)));
  fields.cell.push_back(io::scalar_field("region", {p.mesh.region.begin(), p.mesh.region.end()}));
  fields.cell.push_back(io::scalar_field("J", s.jacobian));
  return fields;
}

/// One piece per rank, with its own cells only, and result.pvtu that names them all.
void write_pieces(const SolveProblem& p, const io::Fields& fields, const fs::path& out) {
  TetMesh piece = p.mesh;
  piece.cells.clear();
  io::Fields values = fields;
  for (io::Field& field : values.cell) {
    field.values.clear();
  }
  for (std::size_t c = 0; c < p.mesh.cells.size(); ++c) {
    if (fem::owns_cell(p.share.get(), c)) {
      piece.cells.push_back(p.mesh.cells[c]);
      for (std::size_t f = 0; f < values.cell.size(); ++f) {
        values.cell[f].values.push_back(fields.cell[f].values[c]);
      }
    }
  }
  std::vector<std::string> names;
  for (int r = 0; r < fem::ranks(); ++r) {
    names.push_back(fmt::format("result_{:04d}.vtu", r));
  }
  io::write_vtu(piece, piece.points, values, out / names[static_cast<std::size_t>(fem::rank())],
                io::LengthUnit::Metre);
  if (fem::rank() == 0) {
    io::write_pvtu(names, fields, out / "result.pvtu");
  }
}

/// Up to this many vertices rank 0 also writes one file in the order of the mesh as given.
constexpr int one_file = 500000;

void write_fields(const SolveProblem& p, const Solution& s, const fs::path& out) {
  io::Fields fields = fields_of(p, s);
  if (p.share == nullptr) {
    if (fem::rank() == 0) {
      io::write_vtu(p.mesh, p.mesh.points, fields, out / "result.vtu", io::LengthUnit::Metre);
    }
    return;
  }
  write_pieces(p, fields, out);
  if (p.share->whole_vertices() > one_file) {
    return;
  }
  const fem::Transfer points = fem::vertex_transfer(*p.share);
  const fem::Transfer cells = fem::cell_transfer(*p.share);
  for (io::Field& field : fields.point) {
    field.values = points.to_leader(field.values, field.components);
  }
  for (io::Field& field : fields.cell) {
    field.values = cells.to_leader(field.values, field.components);
  }
  if (fem::rank() == 0) {
    const TetMesh whole = io::read_msh(p.mesh_file, p.mesh_unit);
    io::write_vtu(whole, whole.points, fields, out / "result.vtu", io::LengthUnit::Metre);
  }
}

/// int u dV / V over the given mesh, from the vertices [mm]: the mean that does not depend on where
/// the mesh is fine.
Vec3 volume_mean_mm(const SolveProblem& p, std::span<const Vec3> moved) {
  const std::vector<double> volumes = cell_volumes(p.mesh, p.mesh.points);
  Vec3 mean{};
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    for (const int v : p.mesh.cells[c]) {
      mean += fem::owns_cell(p.share.get(), c)
                  ? 0.25e3 * volumes[c] * moved[static_cast<std::size_t>(v)]
                  : Vec3{};
    }
  }
  const double volume = total_volume(p, p.mesh.points);
  std::ranges::transform(mean, mean.begin(),
                         [&](double m) { return fem::sum(p.share.get(), m) / volume; });
  return mean;
}

json distribution_json(const fem::MeshShare& share) {
  const fem::ShareSizes sizes = fem::sizes(share);
  return {{"ranks", fem::ranks()},
          {"most_own_vertices", sizes.most_own_vertices},
          {"most_ghost_vertices", sizes.most_ghost_vertices},
          {"mean_ghost_vertices", sizes.mean_ghost_vertices}};
}

json result_json(const SolveProblem& p, const Solution& s) {
  const std::vector<Vec3> moved = displacements(p, s);
  const double count = p.share == nullptr ? static_cast<double>(moved.size())
                                          : static_cast<double>(p.share->whole_vertices());
  double largest = 0.0;
  Vec3 mean{};
  for (std::size_t v = 0; v < moved.size(); ++v) {
    if (fem::owns_vertex(p.share.get(), v)) {
      largest = std::max(largest, norm(moved[v]));
      mean += (1e3 / count) * moved[v];
    }
  }
  largest = fem::largest(largest);
  std::ranges::transform(mean, mean.begin(), [&](double m) { return fem::sum(p.share.get(), m); });
  json probes = json::object();
  for (const auto& [name, vertex] : p.mesh.named_points) {
    Vec3 u = vertex >= 0 ? 1e3 * moved[static_cast<std::size_t>(vertex)] : Vec3{};
    std::ranges::transform(u, u.begin(), [&](double c) { return fem::sum(p.share.get(), c); });
    probes[name] = u;
  }
  json j{{"converged", true},
         {"newton_iterations", s.report.newton_iterations},
         {"krylov_iterations", s.report.krylov_iterations},
         {"factorisations", s.report.factorisations},
         {"load_steps", s.report.load_steps},
         {"last_residual", s.report.last_residual},
         {"max_displacement_mm", 1e3 * largest},
         {"mean_displacement_mm", mean},
         {"volume_mean_displacement_mm", volume_mean_mm(p, moved)},
         {"volume_ratio", s.volume_ratio},
         {"min_jacobian", s.report.min_jacobian},
         {"probes", probes},
         {"mesh",
          {{"vertices", p.share ? p.share->whole_vertices() : static_cast<int>(moved.size())},
           {"cells", p.share ? p.share->whole_cells() : static_cast<int>(p.mesh.cells.size())}}}};
  if (p.share) {
    j["distribution"] = distribution_json(*p.share);
  }
  if (s.recovery) {
    j["wound_volume_ratio_final"] = s.recovery->history.back().volume_ratio;
  }
  return j;
}

}  // namespace

std::string solve_problem(SolveProblem& problem, const fs::path& out, Team& team,
                          const Context& ctx) {
  const fs::path result_file = out / "result.json";
  if (team.leads()) {
    std::error_code problem_with_disk;
    fs::create_directories(out, problem_with_disk);
    if (problem_with_disk) {
      throw Error(Fault::Resource,
                  fmt::format("the output folder cannot be made: {}", problem_with_disk.message()));
    }
    fs::remove(result_file);  // a failed run must not leave an older success behind
  }
  team.share(0);  // the folder is there for all
  const Clock::time_point start = Clock::now();
  try {
    const Solution s = solve(problem, ctx);
    const double seconds_solve = since(start);
    const Clock::time_point writing = Clock::now();
    json j = result_json(problem, s);
    write_fields(problem, s, out);
    if (team.leads() && s.recovery) {
      write_text(out / "history.csv",
                 recovery::history_csv(s.recovery->history, *problem.healing->model));
    }
    j["seconds"] = {{"assembly", s.report.seconds_assembly},
                    {"linear", s.report.seconds_linear},
                    {"solve", seconds_solve},
                    {"write", since(writing)},
                    {"total", since(start)}};
    if (s.recovery) {
      j["seconds"]["species"] = s.recovery->seconds_species;
      j["seconds"]["mechanics"] = s.recovery->seconds_mechanics;
    }
    j["peak_memory_mb"] = peak_memory_mb();
    std::string text = j.dump(2) + "\n";
    if (team.leads()) {
      write_text(result_file, text);
    }
    return text;
  } catch (const Error& e) {
    if (team.leads() && e.fault() == Fault::Numerics) {
      write_text(result_file, json{{"converged", false}, {"error", e.one_line()}}.dump(2) + "\n");
    }
    throw;
  }
}

}  // namespace sanatrix::pipeline
