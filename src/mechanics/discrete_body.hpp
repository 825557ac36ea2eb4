// A body as unknowns and elements: gathers node values, calls the element kernels in parallel
// threads, and hands their blocks to the sparse system.
#pragma once

#include <memory>
#include <vector>

#include "fem/sparse_system.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/problem.hpp"
#include "mechanics/smoothing.hpp"

namespace sanatrix::mechanics {

/// The unknowns: node positions of the sought shape and pressures at the vertices.
struct State {
  std::vector<Vec3> nodes;
  std::vector<double> pressure;
};

/// The worst cell of an evaluation.
struct Worst {
  double J = 0.0;
  int cell = -1;  ///< in the mesh of the process that found it
};

class DiscreteBody {
 public:
  explicit DiscreteBody(const Body& body);

  [[nodiscard]] const Body& body() const { return body_; }
  [[nodiscard]] const fem::EdgeTable& edges() const { return edges_; }
  [[nodiscard]] std::size_t node_count() const { return node_count_; }
  void set_tissue(std::span<const Tissue> tissue);

  /// Chooses direction, known shape and gravity for the following evaluations.
  void begin(Unknown unknown, std::span<const Vec3> known, const Vec3& gravity);
  /// Puts held nodes where the body's loads prescribe them (with respect to the known shape).
  void place_supports(State& state) const;
  /// R(state), `fem::block` values per node, zero for fixed unknowns and for nodes of other ranks.
  /// False when a cell is inverted (worst_place() names it).
  bool residual(const State& state, std::vector<double>& r);
  /// R and its matrix. at_rest: membranes answer with their stiffness at rest.
  bool residual_and_matrix(const State& state, std::vector<double>& r, bool at_rest);
  fem::LinearReport solve(std::span<const double> b, double relative_tolerance,
                          std::vector<double>& x);
  void forget_factorisation();
  /// state + alpha d
  [[nodiscard]] State moved(const State& state, std::span<const double> d, double alpha) const;
  /// The largest share of the step d, at most 1, that leaves every cell `kept` of its volume in the
  /// sought shape (straight edges). Collective.
  [[nodiscard]] double share_within(const State& state, std::span<const double> d,
                                    double kept) const;
  /// Euclidean norm with pressure rows [m3] scaled to forces [N] by a typical mu/h.
  [[nodiscard]] double norm(std::span<const double> r) const;
  /// What that norm is compared with: the norm of gravity and dead loads, or a small force of the
  /// body's own stiffness where there is no gravity. [N]
  [[nodiscard]] double load_scale() const { return load_scale_; }
  [[nodiscard]] double worst_J() const { return worst_.J; }
  /// "cell 12 of region 'breast' near (1.0, 2.0, 3.0) mm". Collective.
  [[nodiscard]] std::string worst_place() const;
  /// Has any cell of any rank next to no shear stiffness, since the last begin()?
  [[nodiscard]] bool is_soft() const { return soft_; }
  /// Mean det F over the quadrature points of every cell.
  [[nodiscard]] std::vector<double> jacobians(std::span<const Vec3> reference,
                                              std::span<const Vec3> deformed) const;

 private:
  struct Buffer;
  /// What one thread works on.
  struct Part {
    fem::RowPart rows;
    std::vector<int> elements;
  };
  template <std::size_t Nodes>
  double compute_cell(int e, const State& state, const Tissue& tissue, double share,
                      Buffer& to) const;
  template <std::size_t Nodes>
  void add_for_factors(int e, const State& state, Tissue tissue, const Buffer& in_system,
                       Buffer& stiff, fem::RowPart rows);
  double add_domain(int domain, const State& state, Buffer& to, fem::RowPart rows);
  void list_domains();
  template <std::size_t Nodes>
  void compute_face(int f, const State& state, bool at_rest, Buffer& to) const;
  template <std::size_t CellNodes, std::size_t FaceNodes>
  Worst evaluate_part(const Part& part, const State& state, bool with_matrix, bool at_rest);
  template <std::size_t CellNodes, std::size_t FaceNodes>
  bool evaluate(const State& state, bool with_matrix, bool at_rest);
  bool run(const State& state, bool with_matrix, bool at_rest);
  void hold_nodes();
  void list_elements();
  void list_parts();
  void set_scales();
  void set_pressure_diagonal();
  void begin_dead_loads();
  void subtract_dead_forces(std::vector<double>& r) const;
  [[nodiscard]] bool is_mine(std::span<const int> nodes) const;

  Body body_;
  fem::EdgeTable edges_;
  std::vector<std::array<int, 3>> face_edges_;
  std::size_t node_count_ = 0;
  fem::Layout layout_;
  fem::ElementList elements_;
  std::vector<int> cells_, faces_, domains_;  ///< that touch an own node, in element order
  SmoothingDomains smoothing_;                ///< of smoothed elements only
  std::vector<std::uint8_t> fixed_;           ///< per node: bits x y z p
  std::vector<Part> parts_;
  std::unique_ptr<fem::SparseSystem> system_;
  Unknown unknown_ = Unknown::Deformed;
  std::vector<Vec3> known_;
  std::vector<double> pressure_diagonal_;  ///< per node, of the factors only [m3/Pa]
  std::vector<double> dead_force_;         ///< per unknown, zero where held; empty: no dead loads
  Vec3 gravity_{};
  double pressure_scale_ = 1.0, load_scale_ = 1.0;
  bool soft_ = false;
  Worst worst_;
  int worst_rank_ = 0;  ///< that found it
};

}  // namespace sanatrix::mechanics
