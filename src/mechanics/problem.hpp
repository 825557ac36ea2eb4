// Quasi-static equilibrium of a soft body with a skin under gravity: forward (reference shape
// known) and inverse (loaded shape known). Eq. (8), doi:10.1371/journal.pone.0159766.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/tet_mesh.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::fem {
class MeshShare;
}

namespace sanatrix::mechanics {

enum class Element {
  P1P1,      ///< linear, with pressure projection
  Smoothed,  ///< the same with strains averaged around edges: as many unknowns, far less stiff
  P2P1,      ///< Taylor-Hood
};

/// As parameters and problem files name them, in the order of Element.
const std::vector<std::string>& element_names();
/// `name` must be one of them.
Element element_named(const std::string& name);
/// "p1p1".
const std::string& name_of(Element element);
/// Layers of cells around a process's vertices that their residual depends on.
int cell_layers(Element element);
/// "P1/P1", for tables.
std::string title_of(Element element);

/// Dead loads and moved supports beside gravity: what verification needs. Forward problems only.
/// Forces are given per reference volume and area and do not follow the deformation.
struct Loads {
  std::function<Vec3(const Vec3& X)> body_force;  ///< [N/m3]; empty: none
  std::vector<BoundaryFace> traction_faces;       ///< any order; `name` is not used
  std::function<Vec3(const Vec3& X)> traction;    ///< [Pa] on them; empty: none
  std::vector<Vec3> prescribed;  ///< displacement per node where it is held [m]; empty: zero
  [[nodiscard]] bool any() const { return body_force || traction || !prescribed.empty(); }
};

/// A body: topology, tissue per cell, skin per face, supports. Shapes are given to the solver
/// apart.
struct Body {
  const TetMesh* mesh = nullptr;
  const fem::MeshShare* share = nullptr;  ///< given: the mesh is this process's share of a larger
  Element element = Element::P1P1;
  std::vector<Tissue> tissue;  ///< per cell
  struct SkinFace {
    std::array<int, 3> vertex;
    int law;  ///< index into skins
  };
  std::vector<SkinFace> skin_faces;
  std::vector<Skin> skins;
  std::vector<std::uint8_t> fixed;  ///< per vertex: bit 0 x, bit 1 y, bit 2 z held at 0
  Loads loads;
};

/// Node positions of the element: vertices first, then (P2) one node per edge in `edges` order.
struct Shape {
  std::vector<Vec3> nodes;       ///< [m]
  std::vector<double> pressure;  ///< per vertex [Pa]; empty: zero
};

struct SolveOptions {
  double relative_tolerance = 1e-9;  ///< of the scaled residual against the load
  int max_newton = 40;               ///< per load step
  /// Of one load path, steps that were halved included. Paths that arrived took 8 to 99.
  int max_newton_total = 400;
  double smallest_load_step = 1.0 / 256.0;  ///< of the whole load
};

struct SolveReport {
  bool converged = false;
  int newton_iterations = 0, krylov_iterations = 0, factorisations = 0, load_steps = 0;
  double last_residual = 0.0;  ///< scaled
  double min_jacobian = 0.0;   ///< of cells, det dx/dX
  double seconds_assembly = 0.0, seconds_linear = 0.0, seconds_total = 0.0;
};

/// Adds counts and seconds; keeps the smaller min_jacobian and the last residual and verdict.
void accumulate(SolveReport& sum, const SolveReport& next);

/// One body, solved many times: keeps distribution, matrix pattern and the last factorisation.
/// All calls are collective over MPI_COMM_WORLD; results are complete on every rank, for all nodes
/// and cells of its mesh.
class Solver {
 public:
  explicit Solver(const Body& body, SolveOptions options = {});
  ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// Node pairs of the P2 mid-edge nodes, empty for P1.
  [[nodiscard]] const std::vector<std::array<int, 2>>& edges() const;
  /// Vertices, and for P2 straight mid-edge nodes.
  [[nodiscard]] std::vector<Vec3> straight_nodes(std::span<const Vec3> vertices) const;

  /// Changed tissue (healing), same mesh.
  void set_tissue(std::span<const Tissue> tissue);
  /// SolveOptions::relative_tolerance of the solves that follow.
  void set_tolerance(double relative);

  /// Loaded shape of a body with this stress-free reference. `guess` may be empty. Load is stepped
  /// from the guess's equilibrium (or rest) and halved on failure; held nodes start where the loads
  /// prescribe them. Throws Error{Numerics} naming
  /// cell, region, load fraction and min J when it fails at the smallest step, or
  /// after max_newton_total iterations.
  Shape forward(std::span<const Vec3> reference_nodes, const Vec3& gravity, const Shape* guess,
                const Context& ctx);
  /// Scaled residual of a shape under gravity: 0 in equilibrium, infinite where a cell is inverted.
  double misfit(std::span<const Vec3> reference_nodes, const Vec3& gravity, const Shape& shape);
  /// Stress-free reference of a body whose loaded shape is known. Error{Input} for a body with
  /// `loads`.
  Shape inverse(std::span<const Vec3> loaded_nodes, const Vec3& gravity, const Context& ctx);
  [[nodiscard]] const SolveReport& last_report() const;

  /// det F per cell (mean over quadrature points), complete on every rank.
  [[nodiscard]] std::vector<double> jacobians(std::span<const Vec3> reference_nodes,
                                              std::span<const Vec3> deformed_nodes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::mechanics
