// Residual and tangent of one cell and of one skin face, for an unknown deformed shape (forward) or
// an unknown reference shape (inverse). Both come from the same discrete equations R(X, x, p) = 0,
// so that unloading and loading again returns the same shape to solver accuracy.
#pragma once

#include <span>

#include "geometry/vec3.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::mechanics {

enum class Unknown {
  Deformed,   ///< reference X is known, deformed x is sought
  Reference,  ///< deformed x is known, reference X is sought
};

struct CellInput {
  Unknown unknown;
  std::span<const Vec3> known, sought;  ///< node positions [m]
  std::array<double, 4> pressure;       ///< at the vertices [Pa]
  Tissue tissue;
  Vec3 gravity;  ///< [m/s2]
  /// The share of its stress and volume that the cell answers for; smoothing domains do the rest.
  double share = 1.0;
};

/// Weak form of Eq. (8) with pressure p as an independent field:
///   R_u = int P : grad(w) dV - int rho g . w dV,   R_p = int q (J - 1 + e - p/kappa) dV -
///   stabilisation,
/// with the polynomial pressure projection of Bochev and Dohrmann for P1/P1
/// (doi:10.1137/S0036142905444482), integrated in the reference measure.
/// The nodal pressure carries the active stress: p_nodal = p + T. Normal stress is continuous
/// across the wall of a wound while p jumps by about T; without the shift a continuous field would
/// smear that jump over the wall's cells (measured: 11 % instead of 8 % contraction of a sphere).
/// Unknowns: displacement node-major xyz, then 4 pressures. residual: 3 Nodes + 4; matrix: its
/// square, row-major, or empty. Returns the smallest det F; when it is not positive the outputs are
/// not written.
/// A P1/P1 cell answers with its own share of the bulk modulus (below), so that the nodal pressure
/// is (kappa - share) (J - 1) + T.
template <std::size_t Nodes>
double cell_element(const CellInput& in, std::span<double> residual, std::span<double> matrix);

/// That share [Pa]; ADR 3.
double own_bulk_modulus(const Tissue& tissue);

/// More cells meet at no edge of a mesh that is worth computing with.
constexpr std::size_t most_domain_nodes = 48;

/// A cell of a smoothing domain, by the domain's nodes.
struct DomainCell {
  std::array<int, 4> node;
  const Tissue* tissue;
};

struct DomainInput {
  Unknown unknown;
  std::span<const Vec3> known, sought;  ///< positions of the domain's nodes [m]
  std::span<const double> pressure;     ///< at them [Pa]
  std::span<const DomainCell> cells;
};

/// Stress and volume of the smoothing domain of an edge: a sixth of every linear cell around it,
/// with one deformation gradient, the mean of the cells' by reference volume, and mean tissue
/// (edge-based smoothed finite elements, doi:10.1002/nme.4472). R as above without gravity and
/// p/kappa terms, which stay with the cells. Unknowns: x y z p of every node; residual: 4 per node;
/// blocks: 4 x 4 per pair of nodes (row-major pairs), each by columns, or empty. Returns det F, or
/// the first reference volume that is not positive; then the outputs are not written.
double domain_element(const DomainInput& in, std::span<double> residual, std::span<double> blocks);

struct FaceInput {
  Unknown unknown;
  std::span<const Vec3> known, sought;
  Skin skin;
  Vec3 gravity;
  bool tangent_at_rest = false;  ///< see membrane_energy_at_rest
};

/// Membrane forces and weight of a skin face. residual: 3 Nodes; matrix: its square or empty.
template <std::size_t Nodes>
void face_element(const FaceInput& in, std::span<double> residual, std::span<double> matrix);

}  // namespace sanatrix::mechanics
