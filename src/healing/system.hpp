// The semi-discrete equations dq/dt = D M^-1 K q + S(q) of the vertices that one rank owns: lumped
// P1 on tetrahedra, Eq. (7) of doi:10.1371/journal.pone.0159766. No library, no time stepping.
#pragma once

#include <span>
#include <vector>

#include "geometry/tet_mesh.hpp"
#include "healing/model.hpp"

namespace sanatrix::healing {

/// Vertices fall into a fixed number of consecutive chunks; a rank owns whole chunks, so that sums
/// taken chunk by chunk have the same bits on any number of ranks.
struct Partition {
  static constexpr int chunks = 256;
  /// Vertices before the given chunk.
  static int chunk_begin(int chunk, int vertices);
  /// First vertex of a rank; rank == ranks gives the number of vertices.
  static int rank_begin(int rank, int ranks, int vertices);
};

/// Where and how much of the mesh is wound.
struct WoundMap {
  std::vector<bool> vertex;     ///< belongs to the wound, interface included
  std::vector<double> fraction; ///< share of wound in the vertex's lumped volume
};

class System {
 public:
  System(const TetMesh& mesh, std::span<const Vec3> points, std::span<const double> wound_fraction,
         const Model& model, int rank, int ranks);

  [[nodiscard]] int species() const { return species_; }
  [[nodiscard]] int begin() const { return begin_; }        ///< first own vertex
  [[nodiscard]] int own() const { return end_ - begin_; }   ///< own vertices
  [[nodiscard]] int vertices() const { return vertices_; }  ///< of the whole mesh
  /// Vertices of other ranks that own rows refer to, ascending; they follow the own ones in q.
  [[nodiscard]] const std::vector<int>& ghosts() const { return ghosts_; }
  [[nodiscard]] const WoundMap& wound() const { return wound_; }
  /// Unknowns of the whole mesh that are not clamped, and those of them in the wound.
  [[nodiscard]] long free_unknowns() const { return free_; }
  [[nodiscard]] long free_wound_unknowns() const { return free_wound_; }
  /// Species at the start, vertices x species, of the whole mesh.
  [[nodiscard]] std::vector<double> initial_state() const;

  /// dq/dt of the own vertices; q: own vertices and ghosts.
  void rate(std::span<const double> q, std::span<double> dq) const;
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
    int vertex;   ///< where, of the whole mesh
  };
  /// Largest step of explicit Euler that is surely stable for the own vertices (Gershgorin).
  [[nodiscard]] StepLimit explicit_limit() const;

 private:
  struct Entry {
    int column;     ///< local: own vertices, then ghosts
    double weight;  ///< -K_ij / m_i [1/m2]
  };
  void assemble(const TetMesh& mesh, std::span<const Vec3> points);
  void localise(const std::vector<int>& columns);
  /// out = D M^-1 K q
  void diffuse(std::span<const double> q, std::span<double> out) const;
  void hold_clamped(std::span<double> own_values) const;

  const Model* model_;
  int species_, vertices_, begin_, end_;
  std::vector<double> diffusivity_;
  WoundMap wound_;
  std::vector<int> ghosts_;
  std::vector<int> row_;       // CSR over own vertices, diagonal left out
  std::vector<Entry> entries_; // in the order of global columns
  std::vector<double> diagonal_;     // sum of a row's weights
  std::vector<int> clamped_;         // own unknowns that are held
  long free_ = 0, free_wound_ = 0;
  std::vector<double> jacobian_;     // of the source, per own vertex
  std::vector<double> block_inverse_;
  mutable std::vector<double> work_;
};

}  // namespace sanatrix::healing
