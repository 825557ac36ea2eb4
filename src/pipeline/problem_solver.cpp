#include "pipeline/problem_solver.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "core/error.hpp"
#include "core/files.hpp"
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

double total_volume(const TetMesh& mesh, std::span<const Vec3> points) {
  const std::vector<double> volumes = cell_volumes(mesh, points);
  return std::accumulate(volumes.begin(), volumes.end(), 0.0);
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
  s.report.min_jacobian = std::min(s.report.min_jacobian, std::ranges::min(s.jacobian));
  return s;
}

Solution solve(SolveProblem& p, const Context& ctx) {
  p.body.mesh = &p.mesh;
  mechanics::Solver solver(p.body);
  const std::vector<Vec3> nodes = solver.straight_nodes(p.mesh.points);
  const double given = total_volume(p.mesh, p.mesh.points);
  if (p.mode == Mode::Healing) {
    Solution s = solve_healing(p, solver, nodes, ctx);
    s.volume_ratio = total_volume(p.mesh, vertices(p.mesh, s.shape)) / given;
    return s;
  }
  Solution s;
  if (p.mode == Mode::Forward) {
    s.shape = solver.forward(nodes, p.gravity, nullptr, ctx);
    s.jacobian = solver.jacobians(nodes, s.shape.nodes);
    s.volume_ratio = total_volume(p.mesh, vertices(p.mesh, s.shape)) / given;
  } else {
    s.shape = solver.inverse(nodes, p.gravity, ctx);
    s.jacobian = solver.jacobians(s.shape.nodes, nodes);
    s.volume_ratio = given / total_volume(p.mesh, vertices(p.mesh, s.shape));
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

void write_vtu_of(const SolveProblem& p, const Solution& s, const fs::path& file) {
  io::Fields fields;
  fields.point.push_back(io::vector_field("displacement", displacements(p, s)));
  std::vector<double> pressure = s.shape.pressure;
  pressure.resize(p.mesh.points.size(), 0.0);
  fields.point.push_back(io::scalar_field("pressure", std::move(pressure)));
  fields.cell.push_back(io::scalar_field("region", {p.mesh.region.begin(), p.mesh.region.end()}));
  fields.cell.push_back(io::scalar_field("J", s.jacobian));
  io::write_vtu(p.mesh, p.mesh.points, fields, file, io::LengthUnit::Metre);
}

json result_json(const SolveProblem& p, const Solution& s) {
  const std::vector<Vec3> moved = displacements(p, s);
  double largest = 0.0;
  Vec3 mean{};
  for (const Vec3& u : moved) {
    largest = std::max(largest, norm(u));
    mean += (1e3 / static_cast<double>(moved.size())) * u;
  }
  json probes = json::object();
  for (const auto& [name, vertex] : p.mesh.named_points) {
    probes[name] = 1e3 * moved[static_cast<std::size_t>(vertex)];
  }
  json j{{"converged", true},
         {"newton_iterations", s.report.newton_iterations},
         {"krylov_iterations", s.report.krylov_iterations},
         {"factorisations", s.report.factorisations},
         {"load_steps", s.report.load_steps},
         {"last_residual", s.report.last_residual},
         {"max_displacement_mm", 1e3 * largest},
         {"mean_displacement_mm", mean},
         {"volume_ratio", s.volume_ratio},
         {"min_jacobian", s.report.min_jacobian},
         {"probes", probes},
         {"mesh", {{"vertices", p.mesh.points.size()}, {"cells", p.mesh.cells.size()}}}};
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
  const Clock::time_point start = Clock::now();
  try {
    const Solution s = solve(problem, ctx);
    const double seconds_solve = since(start);
    const Clock::time_point writing = Clock::now();
    json j = result_json(problem, s);
    if (team.leads()) {
      write_vtu_of(problem, s, out / "result.vtu");
      if (s.recovery) {
        write_text(out / "history.csv",
                   recovery::history_csv(s.recovery->history, *problem.healing->model));
      }
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
    const std::string text = j.dump(2) + "\n";
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
