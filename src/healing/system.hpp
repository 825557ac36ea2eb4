// The semi-discrete equations dq/dt = D lap q + S(q) for the unknowns that one process owns: Eq.
// (7) of doi:10.1371/journal.pone.0159766 with clamped unknowns left out. No time stepping.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/tet_mesh.hpp"
#include "healing/diffusion.hpp"
#include "healing/model.hpp"
#include "healing/wound_map.hpp"

namespace sanatrix::healing {

/// The own vector holds two groups of unknowns: species that live in the whole mesh, for every own
/// vertex near the wound, far from which they stay healthy; then species that are clamped outside
/// the wound, for every own wound vertex.
class System {
 public:
  /// share: the mesh is this process's share of a larger; nullptr: it is the whole, of this process
  /// alone. Collective where the mesh is shared.
  System(const TetMesh& mesh, std::span<const Vec3> points, std::span<const double> wound_fraction,
         const Model& model, const fem::MeshShare* share);

  [[nodiscard]] const fem::MeshShare* share() const { return share_; }
  [[nodiscard]] const WoundMap& wound() const { return wound_; }
  [[nodiscard]] int own_unknowns() const { return own_unknowns_; }
  [[nodiscard]] int all_unknowns() const { return all_unknowns_; }
  /// Unknowns at wound vertices, of the whole mesh.
  [[nodiscard]] int wound_unknowns() const { return wound_unknowns_; }
  /// Global numbers of others' unknowns that own rows refer to; they follow the own ones.
  [[nodiscard]] const std::vector<int>& ghosts() const { return ghosts_; }

  /// Species at the start, vertices x species.
  [[nodiscard]] std::vector<double> initial_state() const;
  /// From and to vertices x species; clamped species get their healthy value, vertices of other
  /// processes what those have. at_vertices is collective where the mesh is shared.
  void pick_unknowns(std::span<const double> state, std::span<double> own) const;
  [[nodiscard]] std::vector<double> at_vertices(std::span<const double> own) const;

  /// dq/dt of the own unknowns; q: own unknowns and ghosts.
  void rate(std::span<const double> q, std::span<double> dq);
  /// Remembers the Jacobian of the source at q.
  void linearise(std::span<const double> q);
  /// Jacobian times v, at the last linearisation.
  void apply(std::span<const double> v, std::span<double> jv) const;
  /// Prepares the vertex blocks of (I - gamma J)^-1, at the last linearisation.
  void factorise(double gamma);
  /// z = approximate (I - gamma J)^-1 r.
  void precondition(std::span<const double> r, std::span<double> z) const;

  struct StepLimit {
    double dt;    ///< [s]
    int species;  ///< that sets it
    int vertex;   ///< where
  };
  /// Largest step of explicit Euler that is surely stable for the own unknowns (Gershgorin), at the
  /// last linearisation.
  [[nodiscard]] StepLimit explicit_limit() const;

 private:
  /// One of the two groups.
  struct Group {
    std::vector<int> species;
    std::vector<int> vertices;  ///< of the mesh, own ones, ascending
    Diffusion diffusion;
    [[nodiscard]] int stride() const { return static_cast<int>(species.size()); }
  };
  [[nodiscard]] std::vector<double> global_numbers() const;
  void localise_columns(std::size_t g, std::span<const double> global);
  void index_vertices();
  void gather(std::span<const double> own, std::span<double> at_vertices) const;

  const Model* model_;
  const fem::MeshShare* share_;
  int species_;
  WoundMap wound_;
  std::vector<int> own_;             ///< vertices near the wound, ascending
  std::vector<double> wound_share_;  ///< WoundMap::fraction of own vertices
  std::array<Group, 2> groups_;
  int own_unknowns_ = 0, all_unknowns_ = 0, wound_unknowns_ = 0;
  std::vector<int> ghosts_;
  // Unknowns by own vertex: vertex i has unknown_[k] of species species_of_[k] for
  // first_[i] <= k < first_[i + 1], and a square block of that size from block_[i] on.
  std::vector<int> first_, unknown_, species_of_, block_;
  std::vector<double> source_jacobian_, block_inverse_;      // blocks, row-major
  std::vector<double> at_vertices_, rates_, full_jacobian_;  // own vertices x species (x species)
};

}  // namespace sanatrix::healing
