#include "mechanics/mooney_rivlin.hpp"

namespace sanatrix::mechanics {

namespace {

double squared_norm(const Mat3& m) {
  return dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2]);
}

/// What stress and tangent share: invariants and the derivatives of Ibar1 and Ibar2.
struct Invariants {
  double j1, j2;        // J^-2/3, J^-4/3
  double I1, I1b, I2b;  // I1, Ibar1, Ibar2
  Mat3 C, M;            // F^T F; dI2/dF = 2 (I1 F - F C)
  Mat3 P1, P2;          // dIbar1/dF, dIbar2/dF
};

Invariants invariants(const Mat3& F, const Mat3& B, double J) {
  Invariants v{};
  const double cube_root = std::cbrt(J);
  v.j1 = 1.0 / (cube_root * cube_root);
  v.j2 = v.j1 * v.j1;
  v.C = transpose(F) * F;
  v.I1 = v.C[0][0] + v.C[1][1] + v.C[2][2];
  const double I2 = 0.5 * (v.I1 * v.I1 - squared_norm(v.C));
  v.I1b = v.j1 * v.I1;
  v.I2b = v.j2 * I2;
  const Mat3 FC = F * v.C;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t J3 = 0; J3 < 3; ++J3) {
      v.M[i][J3] = 2.0 * (v.I1 * F[i][J3] - FC[i][J3]);
      v.P1[i][J3] = 2.0 * v.j1 * F[i][J3] - 2.0 / 3.0 * v.I1b * B[i][J3];
      v.P2[i][J3] = v.j2 * v.M[i][J3] - 4.0 / 3.0 * v.I2b * B[i][J3];
    }
  }
  return v;
}

}  // namespace

StressPoint stress(const Tissue& tissue, const Mat3& F, double p) {
  StressPoint at{};
  at.J = determinant(F);
  at.F_inv_t = transpose(inverse(F));
  const Invariants v = invariants(F, at.F_inv_t, at.J);
  const double c1 = tissue.integrity * tissue.c1;
  const double c2 = tissue.integrity * tissue.c2;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t K = 0; K < 3; ++K) {
      at.P[i][K] = c1 * v.P1[i][K] + c2 * v.P2[i][K] + tissue.active_stress * F[i][K] +
                   p * at.J * at.F_inv_t[i][K];
    }
  }
  return at;
}

void stress_tangent(const Tissue& tissue, const Mat3& F, double p, double dp_dJ,
                    const StressPoint& at, Tangent9& A) {
  const Mat3& B = at.F_inv_t;
  const Invariants v = invariants(F, B, at.J);
  const double c1 = tissue.integrity * tissue.c1;
  const double c2 = tissue.integrity * tissue.c2;
  const Mat3 b = F * transpose(F);
  const double pJ = p * at.J;
  const double twice = pJ + dp_dJ * at.J * at.J;                             // of B_iJ B_kL
  const double swap = 2.0 / 3.0 * c1 * v.I1b + 4.0 / 3.0 * c2 * v.I2b - pJ;  // of B_iL B_kJ
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t J = 0; J < 3; ++J) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t L = 0; L < 3; ++L) {
          double a =
              -4.0 / 3.0 * c1 * v.j1 * F[i][J] * B[k][L] - 2.0 / 3.0 * c1 * B[i][J] * v.P1[k][L] -
              4.0 / 3.0 * c2 * v.j2 * v.M[i][J] * B[k][L] - 4.0 / 3.0 * c2 * B[i][J] * v.P2[k][L] +
              c2 * v.j2 * (4.0 * F[i][J] * F[k][L] - 2.0 * F[i][L] * F[k][J]) +
              swap * B[i][L] * B[k][J] + twice * B[i][J] * B[k][L];
          if (i == k) {
            a -= 2.0 * c2 * v.j2 * v.C[L][J];
          }
          if (J == L) {
            a -= 2.0 * c2 * v.j2 * b[i][k];
          }
          if (i == k && J == L) {
            a += 2.0 * c1 * v.j1 + 2.0 * c2 * v.j2 * v.I1 + tissue.active_stress;
          }
          A[3 * i + J][3 * k + L] = a;
        }
      }
    }
  }
}

double energy(const Tissue& tissue, const Mat3& F) {
  const double J = determinant(F);
  const Invariants v = invariants(F, transpose(inverse(F)), J);
  return tissue.integrity * (tissue.c1 * (v.I1b - 3.0) + tissue.c2 * (v.I2b - 3.0)) +
         0.5 * tissue.active_stress * (v.I1 - 3.0);
}

}  // namespace sanatrix::mechanics
