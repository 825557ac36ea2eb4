// Step H: the only place where healing and mechanics meet. Species advance for six days or more,
// until the wound has changed, then the body finds its new equilibrium with the healed tissue, and
// so on for three months.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "healing/reaction_diffusion.hpp"
#include "mechanics/problem.hpp"

namespace sanatrix::recovery {

struct Schedule {
  double days = 90.0;
  /// Equilibria are looked for, and shapes observed, at multiples of this after the last one.
  double mechanics_interval_days = 6.0;
  /// There the body is only solved for when the mean cell density of the wound (healthy: 1) has
  /// changed by this much since the last equilibrium; in between the shape follows the density.
  double mechanics_density_change = 0.05;
  double record_interval_days = 0.5;  ///< history rows
};

/// One row of history.csv; columns as in the reference histories of validation.
struct HistoryRow {
  healing::SpeciesRecord species;
  double volume_ratio = 1.0;          ///< V/V0 of the wound
  double max_displacement_mm = 0.0;   ///< of the skin against day 0
  double wall_displacement_mm = 0.0;  ///< mean inward displacement of the wound's boundary
  double min_jacobian = 1.0;
};

/// Everything needed to go on after a stop.
struct Checkpoint {
  double t_s = 0.0;
  double wound_volume_m3 = 0.0;  ///< V0: after surgery, before cells pull
  std::vector<double> species;
  mechanics::Shape shape;
  /// The shape of one equilibrium earlier and the mean cell density then (relative), for the
  /// prediction of the next; empty while there is none.
  mechanics::Shape earlier;
  double earlier_density = 0.0;
  std::vector<HistoryRow> history;
};

struct Result {
  std::vector<HistoryRow> history;
  mechanics::Shape healed;                ///< supine equilibrium at the end
  std::vector<double> species;            ///< vertices x species at the end
  std::vector<mechanics::Tissue> tissue;  ///< per cell at the end
  mechanics::SolveReport totals;          ///< summed over all solves
  double seconds_species = 0.0, seconds_mechanics = 0.0;
};

/// Tissue of every cell for a given state of healing: damage 1 - eta/eta0 scales the isochoric
/// energy inside the wound, kappa and stiffness of the wound replace the healthy ones by volume
/// fraction, T0 eta/eta0 pulls. Healthy cells are untouched.
std::vector<mechanics::Tissue> healing_tissue(std::span<const mechanics::Tissue> healthy,
                                              std::span<const double> wound_fraction,
                                              std::span<const double> cell_density,
                                              const healing::WoundMechanics& wound);

/// On several ranks the body may be this rank's share of a larger one, and so is all that is given
/// and returned per node, vertex or cell; numbers of the history are of the whole, on every rank.
struct Problem {
  const mechanics::Body* body = nullptr;  ///< with healthy tissue
  std::span<const Vec3> reference_nodes;  ///< stress-free shape
  mechanics::Shape start;                 ///< equilibrium before surgery (supine)
  std::span<const Vec3> species_points;   ///< vertex positions on which species diffuse
  std::vector<double> wound_fraction;     ///< per cell
  Vec3 gravity{};
  const healing::Model* model = nullptr;
  healing::RdOptions species_options;
  Schedule schedule;
  /// Where there is one, a shape that may be near the equilibrium of that day, of another plan on
  /// the same body, say. It decides where Newton's method starts and not where it ends.
  std::function<std::optional<mechanics::Shape>(double t_day)> hint = {};
};
using Save = std::function<void(const Checkpoint&)>;  ///< called after every equilibrium
/// Called with time, species (vertices x species) and shape every mechanics_interval_days; between
/// two equilibria with the shape that the mean cell density then gives.
using Observe =
    std::function<void(double t_day, std::span<const double> species, const mechanics::Shape&)>;

Result heal(const Problem& problem, const std::optional<Checkpoint>& resume, const Save& save,
            const Observe& observe, const Context& ctx);
/// history.csv: the columns of the reference histories plus max_displacement_mm and min_jacobian.
std::string history_csv(const std::vector<HistoryRow>& history, const healing::Model& model);

}  // namespace sanatrix::recovery
