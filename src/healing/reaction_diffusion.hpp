// dq/dt = D lap q + S(q) on a tetrahedral mesh: lumped P1 in space; CVODE (BDF + SPGMR) or the
// paper's explicit Euler in time. Eq. (7), doi:10.1371/journal.pone.0159766.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "fem/mesh_share.hpp"
#include "geometry/tet_mesh.hpp"
#include "healing/model.hpp"

namespace sanatrix::healing {

enum class Scheme { Cvode, Explicit };

struct RdOptions {
  Scheme scheme = Scheme::Cvode;
  double relative_tolerance = 1e-4;
  double dt_s = 17.28;  ///< explicit only; Error{Input} when above the stability limit
};

/// Species on a mesh that belongs to this process alone, or on its share of a larger one.
class ReactionDiffusion {
 public:
  /// wound_fraction: per cell, 0..1. A vertex is a wound vertex when a cell with fraction >= 0.5
  /// touches it. Interface vertices start as wound and exchange with healthy tissue across the
  /// wound's surface; vertices strictly outside are clamped (docs/theory/healing.md).
  ReactionDiffusion(const TetMesh& mesh, std::span<const Vec3> points,
                    std::span<const double> wound_fraction, const Model& model, RdOptions options,
                    const fem::MeshShare* share = nullptr);
  ~ReactionDiffusion();
  ReactionDiffusion(const ReactionDiffusion&) = delete;
  ReactionDiffusion& operator=(const ReactionDiffusion&) = delete;

  /// Advances to time t [s], t >= time_s(), and ends exactly there. Collective. Every call begins
  /// anew from the state alone, so that a run resumed between two calls repeats an undisturbed one.
  /// on_record is called at the given ascending times on the way, with time_s() and state() of that
  /// moment; this costs far less than one call per record.
  void advance(double t_s, const Context& ctx, std::span<const double> record_times_s = {},
               const std::function<void()>& on_record = {});
  [[nodiscard]] double time_s() const;
  /// vertices x species, ghosts of a share included; what checkpoints store.
  [[nodiscard]] const std::vector<double>& state() const;
  void restore(double t_s, std::span<const double> state);
  /// Per vertex: does it belong to the wound (interface included)?
  [[nodiscard]] const std::vector<bool>& wound_vertices() const;
  /// cells() of the model in the wound's part of each cell: averaged over its wound vertices; over
  /// all four where it has none.
  [[nodiscard]] std::vector<double> cell_density() const;
  [[nodiscard]] const fem::MeshShare* share() const;
  /// Number of time steps so far.
  [[nodiscard]] long steps() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Volume means over the wound vertices' share of the wound, and the value at the vertex nearest to
/// the wound's centroid, per species. Columns of history.csv: key_mean, key_centre.
struct SpeciesRecord {
  double t_day;
  std::vector<double> mean, centre;         ///< per species
  double eta_healthy_min, eta_healthy_max;  ///< species 0 outside the wound
  double far_field_second;  ///< species 1 (zeta) at the vertex farthest from the wound
};
/// Collective where the mesh is shared; then the same on every process, of the whole mesh.
SpeciesRecord record(const ReactionDiffusion& rd, const TetMesh& mesh, std::span<const Vec3> points,
                     std::span<const double> wound_fraction, const Model& model);

}  // namespace sanatrix::healing
