// The solid element: P1/P1 with pressure projection and P2/P1 Taylor-Hood from one template.
#include <algorithm>
#include <limits>

#include "mechanics/elements.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

template <std::size_t Nodes>
struct Local {
  static constexpr std::size_t size = 3 * Nodes + 4;
  std::span<double> residual, matrix;
  [[nodiscard]] bool wants_matrix() const { return !matrix.empty(); }
  double& K(std::size_t row, std::size_t column) const { return matrix[row * size + column]; }
};

/// Everything about one quadrature point that both directions need.
template <std::size_t Nodes>
struct Point {
  double volume;                // weight in the known configuration [m3]
  std::array<double, Nodes> N;  // basis values
  std::array<double, 4> Np;     // pressure basis values
  std::array<Vec3, Nodes> G;    // gradients in the known configuration [1/m]
  Mat3 H;                       // d sought / d known
  double p;                     // without the active part [Pa]
};

template <std::size_t Nodes>
Point<Nodes> make_point(const CellInput& in, const QuadraturePoint<4>& q) {
  const TetBasis<Nodes> basis(q.lambda);
  Mat3 jacobian{};  // d known / d lambda
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t d = 0; d < 3; ++d) {
        jacobian[i][d] += in.known[a][i] * basis.derivative[a][d];
      }
    }
  }
  Point<Nodes> point{};
  point.volume = q.weight * determinant(jacobian) / 6.0;
  point.N = basis.value;
  point.Np = q.lambda;
  const Mat3 to_known = transpose(inverse(jacobian));
  for (std::size_t a = 0; a < Nodes; ++a) {
    point.G[a] = to_known * basis.derivative[a];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t J = 0; J < 3; ++J) {
        point.H[i][J] += in.sought[a][i] * point.G[a][J];
      }
    }
  }
  for (std::size_t v = 0; v < 4; ++v) {
    point.p += in.share * q.lambda[v] * (in.pressure[v] - in.tissue.active_stress);
  }
  return point;
}

/// Adds the displacement-displacement block  w G_aJ D_iJkL G_bL.
template <std::size_t Nodes>
void add_stiffness(const Point<Nodes>& at, double w, const Tangent9& D, const Local<Nodes>& out) {
  for (std::size_t b = 0; b < Nodes; ++b) {
    std::array<std::array<double, 3>, 9> DG{};
    for (std::size_t m = 0; m < 9; ++m) {
      for (std::size_t k = 0; k < 3; ++k) {
        DG[m][k] = w * (D[m][3 * k] * at.G[b][0] + D[m][3 * k + 1] * at.G[b][1] +
                        D[m][3 * k + 2] * at.G[b][2]);
      }
    }
    for (std::size_t a = 0; a < Nodes; ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          out.K(3 * a + i, 3 * b + k) += at.G[a][0] * DG[3 * i][k] + at.G[a][1] * DG[3 * i + 1][k] +
                                         at.G[a][2] * DG[3 * i + 2][k];
        }
      }
    }
  }
}

/// Shear modulus that sets the size of the stabilisations: at full integrity, because a fresh wound
/// (1 % of it) would otherwise be forced to constant pressure.
double stabilising_shear(const Tissue& t) {
  return 2.0 * (t.c1 + t.c2) + t.active_stress;
}

/// The share gamma of the bulk modulus that every cell answers with on its own, beside the pressure
/// field (grad-div stabilisation): the field conserves volume only around vertices, and single
/// cells at a held edge would collapse. Small against kappa, so that nothing locks. Taylor-Hood
/// needs none.
template <std::size_t Nodes>
double own_bulk(const Tissue& t) {
  return Nodes == 4 ? own_bulk_modulus(t) : 0.0;
}

/// A cell whose volume smoothing domains conserve answers with none of it, or it would be as stiff
/// as without them; but when it has lost this share of its volume, or gained as much, it resists,
/// because nothing else keeps single cells at held edges from turning inside out.
constexpr double free_volume = 0.7;

/// gamma/2 (J - 1/J) and its derivative: gamma (J - 1) near rest, without bound towards J = 0.
struct OwnPressure {
  double p, dp_dJ;
};
template <std::size_t Nodes>
OwnPressure own_pressure(const CellInput& in, double J) {
  const double own = own_bulk<Nodes>(in.tissue);
  const double half = 0.5 * in.share * own;
  OwnPressure at{half * (J - 1.0 / J), half * (1.0 + 1.0 / (J * J))};
  const double barrier = (1.0 - in.share) * own;
  const double lost = free_volume / J - 1.0;
  const double gained = free_volume * J - 1.0;
  if (lost > 0.0) {
    at.p -= barrier * lost * lost;
    at.dp_dJ += barrier * 2.0 * lost * free_volume / (J * J);
  } else if (gained > 0.0) {
    at.p += barrier * gained * gained;
    at.dp_dJ += barrier * 2.0 * gained * free_volume;
  }
  return at;
}

/// What of the tissue's stress the cell answers for.
Tissue own_tissue(const CellInput& in) {
  Tissue own = in.tissue;
  own.integrity *= in.share;
  own.active_stress *= in.share;
  return own;
}

/// Does the cell answer for no stress at this volume?
bool is_idle(const CellInput& in, const OwnPressure& own) {
  return in.share == 0.0 && own.p == 0.0;
}

/// Weight of w times this density [kg/m3].
template <std::size_t Nodes>
void add_weight(const CellInput& in, const Point<Nodes>& at, double density,
                const Local<Nodes>& out) {
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      out.residual[3 * a + i] -= at.volume * density * at.N[a] * in.gravity[i];
    }
  }
}

/// Reference shape known: F = H. Returns det F.
template <std::size_t Nodes>
double add_forward(const CellInput& in, const Point<Nodes>& at, const Local<Nodes>& out) {
  const double J = determinant(at.H);
  if (!(J > 0.0)) {
    return J;
  }
  add_weight(in, at, in.tissue.density, out);
  const OwnPressure own = own_pressure<Nodes>(in, J);
  if (is_idle(in, own)) {
    return J;
  }
  const Tissue tissue = own_tissue(in);
  const StressPoint s = stress(tissue, at.H, at.p + own.p);
  const double w = at.volume;
  const Mat3 cofactor = {J * s.F_inv_t[0], J * s.F_inv_t[1], J * s.F_inv_t[2]};
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      out.residual[3 * a + i] += w * dot(s.P[i], at.G[a]);
    }
  }
  for (std::size_t q = 0; q < 4; ++q) {
    out.residual[3 * Nodes + q] += in.share * w * at.Np[q] * (J - 1.0 + in.tissue.shrinkage);
  }
  if (!out.wants_matrix()) {
    return J;
  }
  Tangent9 A{};
  stress_tangent(tissue, at.H, at.p + own.p, own.dp_dJ, s, A);
  add_stiffness(at, w, A, out);
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double c = in.share * w * dot(cofactor[i], at.G[a]);
      for (std::size_t q = 0; q < 4; ++q) {
        out.K(3 * a + i, 3 * Nodes + q) += c * at.Np[q];
        out.K(3 * Nodes + q, 3 * a + i) += c * at.Np[q];
      }
    }
  }
  return J;
}

/// d sigma_ij / d f_Kl for sigma = P F^T / J, F = f^-1, index [3 i + j][3 K + l].
Tangent9 inverse_tangent(const Tissue& tissue, const Mat3& F, const OwnPressure& pressure,
                         const StressPoint& s, const Mat3& sigma) {
  Tangent9 A{};
  stress_tangent(tissue, F, pressure.p, pressure.dp_dJ, s, A);
  const double j = 1.0 / s.J;
  Tangent9 D{};
  for (std::size_t K = 0; K < 3; ++K) {
    for (std::size_t l = 0; l < 3; ++l) {
      std::array<double, 9> dF{};  // -F_iK F_lJ
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t J = 0; J < 3; ++J) {
          dF[3 * i + J] = -F[i][K] * F[l][J];
        }
      }
      Mat3 dP{};
      for (std::size_t m = 0; m < 9; ++m) {
        double sum = 0.0;
        for (std::size_t n = 0; n < 9; ++n) {
          sum += A[m][n] * dF[n];
        }
        dP[m / 3][m % 3] = sum;
      }
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3 dF_k{dF[3 * k], dF[3 * k + 1], dF[3 * k + 2]};
          D[3 * i + k][3 * K + l] =
              F[l][K] * sigma[i][k] + j * (dot(dP[i], F[k]) + dot(s.P[i], dF_k));
        }
      }
    }
  }
  return D;
}

/// Derivative of the weight with respect to the sought reference shape; dj: of j dV at a node.
template <std::size_t Nodes>
void add_weight_change(const CellInput& in, const Point<Nodes>& at, const Mat3& F, double j,
                       const Local<Nodes>& out) {
  for (std::size_t b = 0; b < Nodes; ++b) {
    for (std::size_t K = 0; K < 3; ++K) {
      const double dj = at.volume * j * dot(Vec3{F[0][K], F[1][K], F[2][K]}, at.G[b]);
      for (std::size_t a = 0; a < Nodes; ++a) {
        for (std::size_t i = 0; i < 3; ++i) {
          out.K(3 * a + i, 3 * b + K) -= dj * in.tissue.density * at.N[a] * in.gravity[i];
        }
      }
    }
  }
}

/// The columns and rows of the pressure in the inverse problem.
template <std::size_t Nodes>
void add_inverse_pressure(const CellInput& in, const Point<Nodes>& at, const Mat3& F, double j,
                          const Local<Nodes>& out) {
  const double rest = 1.0 - in.tissue.shrinkage;  // J without pressure
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double dj = at.volume * j * dot(Vec3{F[0][i], F[1][i], F[2][i]}, at.G[a]);
      for (std::size_t q = 0; q < 4; ++q) {
        out.K(3 * Nodes + q, 3 * a + i) -= in.share * dj * rest * at.Np[q];
        out.K(3 * a + i, 3 * Nodes + q) += in.share * at.volume * at.G[a][i] * at.Np[q];
      }
    }
  }
}

/// Deformed shape known: F = H^-1. Returns det F.
template <std::size_t Nodes>
double add_inverse(const CellInput& in, const Point<Nodes>& at, const Local<Nodes>& out) {
  const double j = determinant(at.H);
  if (!(j > 0.0)) {
    return j;
  }
  const Mat3 F = inverse(at.H);
  add_weight(in, at, j * in.tissue.density, out);
  if (out.wants_matrix()) {
    add_weight_change(in, at, F, j, out);
  }
  const OwnPressure own = own_pressure<Nodes>(in, 1.0 / j);
  if (is_idle(in, own)) {
    return 1.0 / j;
  }
  const Tissue tissue = own_tissue(in);
  const StressPoint s = stress(tissue, F, at.p + own.p);
  Mat3 sigma{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      sigma[i][k] = j * dot(s.P[i], F[k]);
    }
  }
  const double w = at.volume;
  for (std::size_t a = 0; a < Nodes; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      out.residual[3 * a + i] += w * dot(sigma[i], at.G[a]);
    }
  }
  for (std::size_t q = 0; q < 4; ++q) {
    out.residual[3 * Nodes + q] +=
        in.share * w * at.Np[q] * (1.0 - (1.0 - in.tissue.shrinkage) * j);
  }
  if (out.wants_matrix()) {
    add_stiffness(at, w, inverse_tangent(tissue, F, {at.p + own.p, own.dp_dJ}, s, sigma), out);
    add_inverse_pressure(in, at, F, j, out);
  }
  return s.J;
}

/// Compressibility  -int q p/kappa dV  and stabilisation  -tau int (p - Pi p)(q - Pi q) dV  of one
/// quadrature contribution with mass matrix M and moments m, in the reference measure. `scale` is
/// dV_ref per the measure of M (1, or j); for the inverse, gradient d(scale)/dX arrives separately.
struct PressureMass {
  std::array<std::array<double, 4>, 4> M{};
};

/// B = M/kappa + tau (M - m m^T/V) for an affine cell with constant measure V. Linear cells are too
/// stiff in shear, and 2/mu makes up for a part of it by their volume; smoothing domains need half.
PressureMass affine_pressure_block(const Tissue& tissue, double share, double V) {
  PressureMass block;
  const double tau = (1.0 + share) / stabilising_shear(tissue);
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b < 4; ++b) {
      const double mass = V / 20.0 * (a == b ? 2.0 : 1.0);
      block.M[a][b] = mass / (tissue.kappa - share * own_bulk<4>(tissue)) + tau * (mass - V / 16.0);
    }
  }
  return block;
}

/// Adds -s B p and its derivatives; ds_dX (may be null) is s's gradient with respect to the sought
/// nodes in the inverse problem, per unit of s B.
template <std::size_t Nodes>
void add_pressure_block(const CellInput& in, const PressureMass& block, const Point<Nodes>& at,
                        const Local<Nodes>& out) {
  const double j = in.unknown == Unknown::Reference ? determinant(at.H) : 1.0;
  std::array<double, 4> Bp{};
  for (std::size_t q = 0; q < 4; ++q) {
    for (std::size_t r = 0; r < 4; ++r) {
      Bp[q] += block.M[q][r] * (in.pressure[r] - in.tissue.active_stress);
    }
    out.residual[3 * Nodes + q] -= j * Bp[q];
  }
  if (!out.wants_matrix()) {
    return;
  }
  for (std::size_t q = 0; q < 4; ++q) {
    for (std::size_t r = 0; r < 4; ++r) {
      out.K(3 * Nodes + q, 3 * Nodes + r) -= j * block.M[q][r];
    }
  }
  if (in.unknown == Unknown::Reference) {
    const Mat3 F = inverse(at.H);
    for (std::size_t b = 0; b < Nodes; ++b) {
      for (std::size_t K = 0; K < 3; ++K) {
        const double dj = j * dot(Vec3{F[0][K], F[1][K], F[2][K]}, at.G[b]);
        for (std::size_t q = 0; q < 4; ++q) {
          out.K(3 * Nodes + q, 3 * b + K) -= dj * Bp[q];
        }
      }
    }
  }
}

template <std::size_t Nodes>
std::span<const QuadraturePoint<4>> rule() {
  if constexpr (Nodes == 4) {
    return tet_centroid;
  } else {
    return tet_degree2();
  }
}

}  // namespace

double own_bulk_modulus(const Tissue& tissue) {
  return tissue.guard * std::min(2.0 * stabilising_shear(tissue), 0.02 * tissue.kappa);
}

template <std::size_t Nodes>
double cell_element(const CellInput& in, std::span<double> residual, std::span<double> matrix) {
  std::ranges::fill(residual, 0.0);
  std::ranges::fill(matrix, 0.0);
  const Local<Nodes> out{residual, matrix};
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& q : rule<Nodes>()) {
    const Point<Nodes> at = make_point<Nodes>(in, q);
    const double J =
        in.unknown == Unknown::Deformed ? add_forward(in, at, out) : add_inverse(in, at, out);
    smallest = std::min(smallest, J);
    if (!(J > 0.0)) {
      return J;
    }
    PressureMass block;
    if constexpr (Nodes == 4) {
      block = affine_pressure_block(in.tissue, in.share, at.volume);
    } else {
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          block.M[a][b] = at.volume * at.Np[a] * at.Np[b] / in.tissue.kappa;
        }
      }
    }
    add_pressure_block(in, block, at, out);
  }
  return smallest;
}

template double cell_element<4>(const CellInput&, std::span<double>, std::span<double>);
template double cell_element<10>(const CellInput&, std::span<double>, std::span<double>);

}  // namespace sanatrix::mechanics
