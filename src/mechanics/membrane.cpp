#include "mechanics/membrane.hpp"

#include <algorithm>
#include <cmath>

namespace sanatrix::mechanics {

namespace {

/// Squared stretches closer to one than this count as slack: the direction of tension is undefined
/// at rest. The stress ignored is below 1e-4 Pa.
constexpr double slack_limit = 1e-9;

struct Stretches {
  double trace, det;  // of C = A^-1 a
  double mu1, mu2;    // squared principal stretches, mu1 >= mu2
};

Stretches stretches(const Metrics& m) {
  const double det_A = m.A[0] * m.A[2] - m.A[1] * m.A[1];
  const double det_a = m.a[0] * m.a[2] - m.a[1] * m.a[1];
  const double m11 = (m.A[2] * m.a[0] - m.A[1] * m.a[1]) / det_A;  // A^-1 a
  const double m22 = (m.A[0] * m.a[2] - m.A[1] * m.a[1]) / det_A;
  const double m12 = (m.A[2] * m.a[1] - m.A[1] * m.a[2]) / det_A;
  const double m21 = (m.A[0] * m.a[1] - m.A[1] * m.a[0]) / det_A;
  const double trace = m11 + m22;
  const double root = std::sqrt(std::max((m11 - m22) * (m11 - m22) + 4.0 * m12 * m21, 0.0));
  return {trace, det_a / det_A, 0.5 * (trace + root), 0.5 * (trace - root)};
}

using J6 = Jet<6>;

/// alpha (exp(beta (I1 - 3)) - 1) + c2 (I2 - 3)
J6 veronda_westmann(const Skin& skin, const J6& I1, const J6& I2) {
  return skin.alpha * (exp(skin.beta * (I1 + -3.0)) + -1.0) + skin.c2 * (I2 + -3.0);
}

J6 energy_in_state(const Skin& skin, const Metrics& m, MembraneState state) {
  if (state == MembraneState::Slack) {
    return {};
  }
  const J6 a11 = J6::input(0, m.a[0]);
  const J6 a12 = J6::input(1, m.a[1]);
  const J6 a22 = J6::input(2, m.a[2]);
  const J6 A11 = J6::input(3, m.A[0]);
  const J6 A12 = J6::input(4, m.A[1]);
  const J6 A22 = J6::input(5, m.A[2]);
  const J6 det_A = A11 * A22 - A12 * A12;
  const J6 per_det_A = reciprocal(det_A);
  const J6 m11 = (A22 * a11 - A12 * a12) * per_det_A;  // A^-1 a
  const J6 m22 = (A11 * a22 - A12 * a12) * per_det_A;
  const J6 trace = m11 + m22;
  const J6 det = (a11 * a22 - a12 * a12) * per_det_A;
  const J6 weight = skin.thickness * sqrt(det_A);
  if (state == MembraneState::Taut) {
    // lambda3^2 = 1/det: I1 = tr + 1/det, I2 = det + tr/det
    const J6 per_det = reciprocal(det);
    return weight * veronda_westmann(skin, trace + per_det, det + trace * per_det);
  }
  // Uniaxial tension, lambda2 = lambda3 = lambda1^-1/2: I1 = mu + 2/sqrt(mu), I2 = 2 sqrt(mu) +
  // 1/mu The discriminant as a sum of products of small terms: trace^2 - 4 det would cancel near
  // rest.
  const J6 m12 = (A22 * a12 - A12 * a22) * per_det_A;
  const J6 m21 = (A11 * a12 - A12 * a11) * per_det_A;
  const J6 mu = 0.5 * (trace + sqrt((m11 - m22) * (m11 - m22) + 4.0 * (m12 * m21)));
  const J6 root = sqrt(mu);
  return weight * veronda_westmann(skin, mu + 2.0 * reciprocal(root), 2.0 * root + reciprocal(mu));
}

}  // namespace

MembraneState membrane_state(const Metrics& m, bool tension_field) {
  if (!tension_field) {
    return MembraneState::Taut;
  }
  const Stretches s = stretches(m);
  if (s.mu1 <= 1.0 + slack_limit) {
    return MembraneState::Slack;
  }
  return s.mu2 * std::sqrt(s.mu1) < 1.0 ? MembraneState::Wrinkled : MembraneState::Taut;
}

Jet<6> membrane_energy(const Skin& skin, const Metrics& m) {
  return energy_in_state(skin, m, membrane_state(m, skin.tension_field));
}

Jet<6> membrane_energy_at_rest(const Skin& skin, const Metrics& m) {
  const Metrics rest{m.A, m.A};
  return energy_in_state(skin, rest, MembraneState::Taut);
}

std::array<double, 4> reference_area(const Metrics& m) {
  const double root = std::sqrt(m.A[0] * m.A[2] - m.A[1] * m.A[1]);
  return {root, 0.5 * m.A[2] / root, -m.A[1] / root, 0.5 * m.A[0] / root};
}

}  // namespace sanatrix::mechanics
