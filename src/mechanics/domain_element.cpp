// The smoothing domain of an edge: stress and volume of linear cells from strains averaged around
// it. Linear cells alone are too stiff: on a patient they lack a fifth of a pose's movement.
#include <algorithm>

#include "core/error.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/mooney_rivlin.hpp"

namespace sanatrix::mechanics {

namespace {

/// What is averaged over the cells by reference volume.
enum Average { C1, C2, Active, Pressure, Shrinkage };
using Averages = std::array<double, 5>;

/// One cell's part: a sixth of its reference volume.
struct Piece {
  double volume;          // [m3]
  std::array<Vec3, 4> G;  // gradients of the corners in the reference configuration [1/m]
  Mat3 F;
  Averages value;
};

constexpr std::size_t most_nodes = most_domain_nodes;

struct Domain {
  std::size_t nodes = 0;
  std::span<const DomainCell> cells;
  std::array<Piece, most_nodes> pieces;
  double volume = 0.0;
  std::array<Vec3, most_nodes> B{};       // sum of volume G: F = sum x B / volume [m2]
  std::array<double, most_nodes> mass{};  // weight of every pressure [m3]
  Mat3 F{};
  Averages mean{};
};

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

Averages values(const DomainInput& in, const DomainCell& cell) {
  const Tissue& t = *cell.tissue;
  double p = 0.0;
  for (const int a : cell.node) {
    p += 0.25 * in.pressure[index(a)];
  }
  // As in a cell, nodal pressures carry the active stress.
  return {t.integrity * t.c1, t.integrity * t.c2, t.active_stress, p - t.active_stress,
          t.shrinkage};
}

/// False when a reference volume is not positive; it is then left in `volume`.
bool add_piece(const DomainInput& in, std::size_t c, Domain& domain) {
  const bool forward = in.unknown == Unknown::Deformed;
  const auto X = forward ? in.known : in.sought;
  const auto x = forward ? in.sought : in.known;
  const auto& node = in.cells[c].node;
  Piece& piece = domain.pieces[c];
  Mat3 edges{};  // rows
  for (std::size_t k = 0; k < 3; ++k) {
    edges[k] = X[index(node[k + 1])] - X[index(node[0])];
  }
  const double six_volumes = determinant(edges);
  if (!(six_volumes > 0.0)) {
    domain.volume = six_volumes;
    return false;
  }
  const Mat3 gradient = inverse(edges);
  piece.volume = six_volumes / 36.0;
  piece.G[0] = {};
  for (std::size_t k = 0; k < 3; ++k) {
    piece.G[k + 1] = {gradient[0][k], gradient[1][k], gradient[2][k]};
    piece.G[0] += -1.0 * piece.G[k + 1];
  }
  piece.F = {};
  for (std::size_t a = 0; a < 4; ++a) {
    const std::size_t n = index(node[a]);
    for (std::size_t i = 0; i < 3; ++i) {
      piece.F[i] += x[n][i] * piece.G[a];
    }
    domain.B[n] += piece.volume * piece.G[a];
    domain.mass[n] += 0.25 * piece.volume;
  }
  piece.value = values(in, in.cells[c]);
  domain.volume += piece.volume;
  for (std::size_t i = 0; i < 3; ++i) {
    domain.F[i] += piece.volume * piece.F[i];
  }
  for (std::size_t v = 0; v < domain.mean.size(); ++v) {
    domain.mean[v] += piece.volume * piece.value[v];
  }
  return true;
}

/// False as above.
bool gather(const DomainInput& in, Domain& domain) {
  domain.nodes = in.known.size();
  domain.cells = in.cells;
  domain.volume = 0.0;
  std::fill_n(domain.B.begin(), domain.nodes, Vec3{});
  std::fill_n(domain.mass.begin(), domain.nodes, 0.0);
  domain.F = {};
  domain.mean = {};
  for (std::size_t c = 0; c < in.cells.size(); ++c) {
    if (!add_piece(in, c, domain)) {
      return false;
    }
  }
  for (Vec3& row : domain.F) {
    row = (1.0 / domain.volume) * row;
  }
  for (double& v : domain.mean) {
    v /= domain.volume;
  }
  return true;
}

/// Stress and its derivatives at the domain's deformation gradient.
struct Response {
  Tissue tissue;
  double excess;  // J - 1 + shrinkage
  StressPoint at;
  Mat3 cofactor;
};

Response respond(const Domain& domain) {
  Response r{};
  r.tissue.c1 = domain.mean[C1];
  r.tissue.c2 = domain.mean[C2];
  r.tissue.integrity = 1.0;
  r.tissue.active_stress = domain.mean[Active];
  const double J = determinant(domain.F);
  r.excess = J - 1.0 + domain.mean[Shrinkage];
  r.at = stress(r.tissue, domain.F, domain.mean[Pressure]);
  for (std::size_t i = 0; i < 3; ++i) {
    r.cofactor[i] = J * r.at.F_inv_t[i];
  }
  return r;
}

/// Blocks of all node pairs; entry (i, k) of block (a, b), with i, k = 3 for the pressure.
struct Out {
  std::size_t nodes;
  std::span<double> matrix;
  [[nodiscard]] double* block(std::size_t a, std::size_t b) const {
    return matrix.data() + 16 * (a * nodes + b);
  }
  [[nodiscard]] double& K(std::size_t a, std::size_t b, std::size_t i, std::size_t k) const {
    return block(a, b)[4 * k + i];
  }
};

void add_pressure_columns(const Domain& d, const Response& r, const Out& out) {
  for (std::size_t a = 0; a < d.nodes; ++a) {
    const Vec3 force = (1.0 / d.volume) * (r.cofactor * d.B[a]);
    for (std::size_t b = 0; b < d.nodes; ++b) {
      for (std::size_t i = 0; i < 3; ++i) {
        out.K(a, b, i, 3) += d.mass[b] * force[i];
      }
    }
  }
}

/// The columns of one node's position: dP_iJ / d(node, k), index [3 i + J], times every B_aJ, and
/// the change of J - 1 + shrinkage times every pressure's weight.
void add_columns(const Domain& d, std::size_t node, const std::array<Vec3, 9>& dP,
                 const Vec3& excess, const Out& out) {
  using Lanes = std::array<double, 4>;  // x y z p: what the compiler turns into one register
  std::array<std::array<Lanes, 3>, 3> by{};
  std::array<Lanes, 3> weight{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t J = 0; J < 3; ++J) {
      for (std::size_t i = 0; i < 3; ++i) {
        by[k][J][i] = dP[3 * i + J][k];
      }
    }
    weight[k][3] = excess[k];
  }
  for (std::size_t a = 0; a < d.nodes; ++a) {
    const Vec3& B = d.B[a];
    double* to = out.block(a, node);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 4; ++i) {
        to[4 * k + i] +=
            B[0] * by[k][0][i] + B[1] * by[k][1][i] + B[2] * by[k][2][i] + d.mass[a] * weight[k][i];
      }
    }
  }
}

void add_forward(const Domain& d, const Response& r, const Tangent9& A, const Out& out) {
  for (std::size_t b = 0; b < d.nodes; ++b) {
    const Vec3 B = (1.0 / d.volume) * d.B[b];
    std::array<Vec3, 9> dP{};
    for (std::size_t m = 0; m < 9; ++m) {
      for (std::size_t k = 0; k < 3; ++k) {
        dP[m][k] = A[m][3 * k] * B[0] + A[m][3 * k + 1] * B[1] + A[m][3 * k + 2] * B[2];
      }
    }
    add_columns(d, b, dP, r.cofactor * B, out);
  }
}

/// Derivatives of the domain's averages with respect to the reference position of one node.
struct Change {
  std::array<Vec3, 9> F{};
  std::array<Vec3, std::tuple_size_v<Averages>> mean{};
};

/// With  d(v G_aJ)/dX_bK = v (G_aJ G_bK - G_aK G_bJ)  and  dv/dX_b = v G_b.
Change change(const Domain& d, std::size_t node) {
  Change to;
  for (std::size_t c = 0; c < d.cells.size(); ++c) {
    const Piece& piece = d.pieces[c];
    const auto& corners = d.cells[c].node;
    const auto at = std::ranges::find(corners, static_cast<int>(node));
    if (at == corners.end()) {
      continue;
    }
    const Vec3 g =
        (piece.volume / d.volume) * piece.G[index(static_cast<int>(at - corners.begin()))];
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t L = 0; L < 3; ++L) {
        to.F[3 * k + L] += (piece.F[k][L] - d.F[k][L]) * g + (-g[L]) * piece.F[k];
      }
    }
    for (std::size_t v = 0; v < to.mean.size(); ++v) {
      to.mean[v] += (piece.value[v] - d.mean[v]) * g;
    }
  }
  return to;
}

/// dP of a change of F and of the averaged tissue.
std::array<Vec3, 9> stress_change(const Domain& d, const Response& r, const Tangent9& A,
                                  const std::array<Mat3, 2>& unit_stress, const Change& by) {
  std::array<Vec3, 9> dP{};
  for (std::size_t m = 0; m < 9; ++m) {
    const std::size_t i = m / 3;
    const std::size_t K = m % 3;
    dP[m] = unit_stress[0][i][K] * by.mean[C1] + unit_stress[1][i][K] * by.mean[C2] +
            d.F[i][K] * by.mean[Active] + r.cofactor[i][K] * by.mean[Pressure];
    for (std::size_t n = 0; n < 9; ++n) {
      dP[m] += A[m][n] * by.F[n];
    }
  }
  return dP;
}

/// P dB and the change of the pressures' weights: one corner of one cell moves.
void add_moved_corner(const Piece& piece, const DomainCell& cell, std::size_t b, const Response& r,
                      const Out& out) {
  const Vec3& G = piece.G[b];
  const Vec3 PG = r.at.P * G;
  for (std::size_t a = 0; a < 4; ++a) {
    double* to = out.block(index(cell.node[a]), index(cell.node[b]));
    const Vec3 PGa = r.at.P * piece.G[a];
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        to[4 * k + i] += piece.volume * (PGa[i] * G[k] - piece.G[a][k] * PG[i]);
      }
      to[4 * k + 3] += 0.25 * piece.volume * G[k] * r.excess;
    }
  }
}

void add_inverse(const Domain& d, const Response& r, const Tangent9& A, const Out& out) {
  Tissue unit;
  unit.c1 = 1.0;
  unit.c2 = 0.0;
  std::array<Mat3, 2> unit_stress{stress(unit, d.F, 0.0).P, {}};
  std::swap(unit.c1, unit.c2);
  unit_stress[1] = stress(unit, d.F, 0.0).P;
  for (std::size_t b = 0; b < d.nodes; ++b) {
    const Change by = change(d, b);
    Vec3 excess = by.mean[Shrinkage];
    for (std::size_t m = 0; m < 9; ++m) {
      excess += r.cofactor[m / 3][m % 3] * by.F[m];
    }
    add_columns(d, b, stress_change(d, r, A, unit_stress, by), excess, out);
  }
  for (std::size_t c = 0; c < d.cells.size(); ++c) {
    for (std::size_t b = 0; b < 4; ++b) {
      add_moved_corner(d.pieces[c], d.cells[c], b, r, out);
    }
  }
}

}  // namespace

double domain_element(const DomainInput& in, std::span<double> residual, std::span<double> blocks) {
  ensure(in.known.size() <= most_nodes && in.cells.size() <= most_nodes,
         "a smoothing domain of {} nodes", in.known.size());
  thread_local Domain domain;  // too large to clear for every edge
  if (!gather(in, domain)) {
    return domain.volume;
  }
  const double J = determinant(domain.F);
  if (!(J > 0.0)) {
    return J;
  }
  const Response r = respond(domain);
  const std::size_t n = domain.nodes;
  for (std::size_t a = 0; a < n; ++a) {
    const Vec3 force = r.at.P * domain.B[a];
    std::ranges::copy(force, residual.begin() + static_cast<std::ptrdiff_t>(4 * a));
    residual[4 * a + 3] = domain.mass[a] * r.excess;
  }
  if (blocks.empty()) {
    return J;
  }
  std::ranges::fill(blocks, 0.0);
  const Out out{n, blocks};
  Tangent9 A{};
  stress_tangent(r.tissue, domain.F, domain.mean[Pressure], 0.0, r.at, A);
  add_pressure_columns(domain, r, out);
  if (in.unknown == Unknown::Deformed) {
    add_forward(domain, r, A, out);
  } else {
    add_inverse(domain, r, A, out);
  }
  return J;
}

}  // namespace sanatrix::mechanics
