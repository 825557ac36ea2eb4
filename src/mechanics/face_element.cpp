// The skin element: membrane forces and weight on a linear or quadratic triangle.
#include <algorithm>

#include "mechanics/elements.hpp"
#include "mechanics/membrane.hpp"
#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

struct Tangents {
  Vec3 g1{}, g2{};
  [[nodiscard]] std::array<double, 3> metric() const {
    return {dot(g1, g1), dot(g1, g2), dot(g2, g2)};
  }
};

template <std::size_t Nodes>
Tangents tangents(std::span<const Vec3> nodes, const TriangleBasis<Nodes>& basis) {
  Tangents t;
  for (std::size_t a = 0; a < Nodes; ++a) {
    t.g1 += basis.derivative[a][0] * nodes[a];
    t.g2 += basis.derivative[a][1] * nodes[a];
  }
  return t;
}

/// d metric_m / d (node b, component k)
double metric_derivative(const Tangents& t, const std::array<double, 2>& dN, std::size_t m,
                         std::size_t k) {
  switch (m) {
    case 0:
      return 2.0 * t.g1[k] * dN[0];
    case 1:
      return t.g1[k] * dN[1] + t.g2[k] * dN[0];
    default:
      return 2.0 * t.g2[k] * dN[1];
  }
}

template <std::size_t Nodes>
struct FacePoint {
  TriangleBasis<Nodes> basis;
  double weight;
  Tangents deformed, reference;
  Jet<6> energy;               // forces
  Jet<6> tangent;              // second derivatives used in the matrix
  std::array<double, 4> area;  // sqrt(det A) and its derivatives
};

template <std::size_t Nodes>
void add_forces(const FaceInput& in, const FacePoint<Nodes>& at, std::span<double> residual) {
  const auto& e = at.energy.gradient;
  const Vec3 n1 = 2.0 * e[0] * at.deformed.g1 + e[1] * at.deformed.g2;
  const Vec3 n2 = e[1] * at.deformed.g1 + 2.0 * e[2] * at.deformed.g2;
  const double mass = at.weight * in.skin.density * in.skin.thickness * at.area[0];
  for (std::size_t a = 0; a < Nodes; ++a) {
    const auto& dN = at.basis.derivative[a];
    for (std::size_t i = 0; i < 3; ++i) {
      residual[3 * a + i] +=
          at.weight * (dN[0] * n1[i] + dN[1] * n2[i]) - mass * at.basis.value[a] * in.gravity[i];
    }
  }
}

template <std::size_t Nodes>
void add_deformed_tangent(const FacePoint<Nodes>& at, std::span<double> matrix) {
  const auto& H = at.tangent.hessian;
  const auto& e = at.tangent.gradient;
  for (std::size_t a = 0; a < Nodes; ++a) {
    const auto& da = at.basis.derivative[a];
    for (std::size_t b = 0; b < Nodes; ++b) {
      const auto& db = at.basis.derivative[b];
      const double geometric = 2.0 * e[0] * da[0] * db[0] + e[1] * (da[0] * db[1] + da[1] * db[0]) +
                               2.0 * e[2] * da[1] * db[1];
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          double v = i == k ? geometric : 0.0;
          for (std::size_t m = 0; m < 3; ++m) {
            for (std::size_t n = 0; n < 3; ++n) {
              v += metric_derivative(at.deformed, da, m, i) * H[m][n] *
                   metric_derivative(at.deformed, db, n, k);
            }
          }
          matrix[(3 * a + i) * 3 * Nodes + 3 * b + k] += at.weight * v;
        }
      }
    }
  }
}

template <std::size_t Nodes>
void add_reference_tangent(const FaceInput& in, const FacePoint<Nodes>& at,
                           std::span<double> matrix) {
  const auto& H = at.tangent.hessian;
  const double areal_density = in.skin.density * in.skin.thickness;
  for (std::size_t b = 0; b < Nodes; ++b) {
    const auto& db = at.basis.derivative[b];
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<double, 3> dA{};
      for (std::size_t n = 0; n < 3; ++n) {
        dA[n] = metric_derivative(at.reference, db, n, k);
      }
      const double d_area = at.area[1] * dA[0] + at.area[2] * dA[1] + at.area[3] * dA[2];
      for (std::size_t a = 0; a < Nodes; ++a) {
        const auto& da = at.basis.derivative[a];
        for (std::size_t i = 0; i < 3; ++i) {
          double v = -areal_density * d_area * at.basis.value[a] * in.gravity[i];
          for (std::size_t m = 0; m < 3; ++m) {
            const double row = metric_derivative(at.deformed, da, m, i);
            for (std::size_t n = 0; n < 3; ++n) {
              v += row * H[m][n + 3] * dA[n];
            }
          }
          matrix[(3 * a + i) * 3 * Nodes + 3 * b + k] += at.weight * v;
        }
      }
    }
  }
}

template <std::size_t Nodes>
std::span<const QuadraturePoint<3>> rule() {
  if constexpr (Nodes == 3) {
    return triangle_centroid;
  } else {
    return triangle_degree4();
  }
}

}  // namespace

template <std::size_t Nodes>
void face_element(const FaceInput& in, std::span<double> residual, std::span<double> matrix) {
  std::ranges::fill(residual, 0.0);
  std::ranges::fill(matrix, 0.0);
  const bool forward = in.unknown == Unknown::Deformed;
  for (const auto& q : rule<Nodes>()) {
    const TriangleBasis<Nodes> basis(q.lambda);
    const Tangents deformed = tangents<Nodes>(forward ? in.sought : in.known, basis);
    const Tangents reference = tangents<Nodes>(forward ? in.known : in.sought, basis);
    const Metrics metrics{deformed.metric(), reference.metric()};
    const Jet<6> e = membrane_energy(in.skin, metrics);
    const FacePoint<Nodes> at{basis,
                              0.5 * q.weight,
                              deformed,
                              reference,
                              e,
                              in.tangent_at_rest ? membrane_energy_at_rest(in.skin, metrics) : e,
                              reference_area(metrics)};
    add_forces(in, at, residual);
    if (!matrix.empty()) {
      if (forward) {
        add_deformed_tangent(at, matrix);
      } else {
        add_reference_tangent(in, at, matrix);
      }
    }
  }
}

template void face_element<3>(const FaceInput&, std::span<double>, std::span<double>);
template void face_element<6>(const FaceInput&, std::span<double>, std::span<double>);

}  // namespace sanatrix::mechanics
