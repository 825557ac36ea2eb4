// Mesh and time convergence of a case's clinical outputs: the case on several meshes and with
// several intervals between mechanical equilibria, and how far the finest may be from the limit.
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "pipeline/case.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::pipeline {

/// How far the value on the finest of three meshes may be from that of an infinitely fine one.
struct ErrorBar {
  double order;      ///< of convergence, 1 ... 2
  bool observed;     ///< false: the values do not settle as an order of 1 or more would; 1 is taken
  double half_size;  ///< in the unit of the value
};
/// Grid convergence index of the last three values (Roache 1994, doi:10.1115/1.2910291) for edges
/// that shrink by unequal ratios (Celik et al. 2008, doi:10.1115/1.2960953), safety factor 1.25. At
/// least the spread of the three where no order is observed.
ErrorBar richardson(std::span<const double> edges, std::span<const double> values);

/// A number of outcome.json that is studied.
struct ClinicalOutput {
  std::string key, name, unit;
};
const std::vector<ClinicalOutput>& clinical_outputs();

struct ConvergenceRun {
  int vertices = 0;
  double interval_days = 0.0;
  std::vector<double> values;    ///< in the order of clinical_outputs()
  double estimated_error = 0.0;  ///< discretisation_error.relative of the same outcome.json
};

struct ConvergenceOptions {
  std::vector<int> vertices;      ///< to aim at; empty: three, up to what the case asks for
  std::vector<double> intervals;  ///< between equilibria [days]; empty: twice, once and half of it
  std::filesystem::path out;      ///< keeps the results of single runs, so that a study goes on
};

struct Convergence {
  std::vector<ConvergenceRun> by_mesh;      ///< coarsest first
  std::vector<ConvergenceRun> by_interval;  ///< longest first, all on the case's own mesh
  std::vector<ErrorBar> error_bars;         ///< of the finest mesh, per output

  /// Typical edges of the meshes, the finest as 1.
  [[nodiscard]] std::vector<double> edges() const;
  [[nodiscard]] std::vector<double> mesh_values(std::size_t output) const;
  [[nodiscard]] std::vector<double> interval_values(std::size_t output) const;
};

/// The case itself is brought as far as its supine pose; all else happens in `out`. The caller
/// holds the case's lock. Collective over the team. Error{Usage} for fewer than three meshes,
/// Error{Numerics} when a run fails or two meshes are alike.
Convergence converge(const Case& patient, const ConvergenceOptions& options, Monitor& monitor,
                     Team& team, const std::stop_token& stop);

}  // namespace sanatrix::pipeline
