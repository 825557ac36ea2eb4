#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

std::array<QuadraturePoint<4>, 4> make_tet_degree2() {
  constexpr double a = 0.13819660112501051518;  // (5 - sqrt 5)/20
  std::array<QuadraturePoint<4>, 4> points{};
  for (std::size_t v = 0; v < 4; ++v) {
    points[v] = {{a, a, a, a}, 0.25};
    points[v].lambda[v] = 1.0 - 3.0 * a;
  }
  return points;
}

std::array<QuadraturePoint<4>, 14> make_tet_degree5() {
  std::array<QuadraturePoint<4>, 14> points{};
  std::size_t n = 0;
  constexpr double a1 = 0.31088591926330060980, w1 = 0.11268792571801585080;
  constexpr double a2 = 0.092735250310891226402, w2 = 0.073493043116361949544;
  for (const auto& [a, w] : {std::array{a1, w1}, std::array{a2, w2}}) {
    for (std::size_t v = 0; v < 4; ++v) {
      points[n] = {{a, a, a, a}, w};
      points[n++].lambda[v] = 1.0 - 3.0 * a;
    }
  }
  constexpr double a3 = 0.045503704125649649492, w3 = 0.042546020777081466438;
  for (const auto& [i, j] : fem::EdgeTable::local) {
    points[n] = {{a3, a3, a3, a3}, w3};
    points[n].lambda[static_cast<std::size_t>(i)] = 0.5 - a3;
    points[n++].lambda[static_cast<std::size_t>(j)] = 0.5 - a3;
  }
  return points;
}

std::array<QuadraturePoint<3>, 6> make_triangle_degree4() {
  std::array<QuadraturePoint<3>, 6> points{};
  std::size_t n = 0;
  constexpr double a1 = 0.445948490915965, w1 = 0.223381589678011;
  constexpr double a2 = 0.091576213509771, w2 = 0.109951743655322;
  for (const auto& [a, w] : {std::array{a1, w1}, std::array{a2, w2}}) {
    for (std::size_t v = 0; v < 3; ++v) {
      points[n] = {{a, a, a}, w};
      points[n++].lambda[v] = 1.0 - 2.0 * a;
    }
  }
  return points;
}

/// d lambda_v / d lambda_{1..3}
constexpr double barycentric_derivative(std::size_t v, std::size_t along) {
  return v == 0 ? -1.0 : (v == along + 1 ? 1.0 : 0.0);
}

}  // namespace

std::span<const QuadraturePoint<4>> tet_degree2() {
  static const auto points = make_tet_degree2();
  return points;
}

std::span<const QuadraturePoint<4>> tet_degree5() {
  static const auto points = make_tet_degree5();
  return points;
}

std::span<const QuadraturePoint<3>> triangle_degree4() {
  static const auto points = make_triangle_degree4();
  return points;
}

template <std::size_t Nodes>
TetBasis<Nodes>::TetBasis(const std::array<double, 4>& lambda) : value{}, derivative{} {
  for (std::size_t v = 0; v < 4; ++v) {
    const double l = lambda[v];
    value[v] = Nodes == 4 ? l : l * (2.0 * l - 1.0);
    for (std::size_t d = 0; d < 3; ++d) {
      derivative[v][d] = (Nodes == 4 ? 1.0 : 4.0 * l - 1.0) * barycentric_derivative(v, d);
    }
  }
  if constexpr (Nodes == 10) {
    for (std::size_t e = 0; e < 6; ++e) {
      const auto i = static_cast<std::size_t>(fem::EdgeTable::local[e][0]);
      const auto j = static_cast<std::size_t>(fem::EdgeTable::local[e][1]);
      value[4 + e] = 4.0 * lambda[i] * lambda[j];
      for (std::size_t d = 0; d < 3; ++d) {
        derivative[4 + e][d] = 4.0 * (lambda[i] * barycentric_derivative(j, d) +
                                      lambda[j] * barycentric_derivative(i, d));
      }
    }
  }
}

template <std::size_t Nodes>
TriangleBasis<Nodes>::TriangleBasis(const std::array<double, 3>& lambda) : value{}, derivative{} {
  for (std::size_t v = 0; v < 3; ++v) {
    const double l = lambda[v];
    value[v] = Nodes == 3 ? l : l * (2.0 * l - 1.0);
    for (std::size_t d = 0; d < 2; ++d) {
      derivative[v][d] = (Nodes == 3 ? 1.0 : 4.0 * l - 1.0) * barycentric_derivative(v, d);
    }
  }
  if constexpr (Nodes == 6) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t i = e;
      const std::size_t j = (e + 1) % 3;
      value[3 + e] = 4.0 * lambda[i] * lambda[j];
      for (std::size_t d = 0; d < 2; ++d) {
        derivative[3 + e][d] = 4.0 * (lambda[i] * barycentric_derivative(j, d) +
                                      lambda[j] * barycentric_derivative(i, d));
      }
    }
  }
}

template struct TetBasis<4>;
template struct TetBasis<10>;
template struct TriangleBasis<3>;
template struct TriangleBasis<6>;

}  // namespace sanatrix::mechanics
