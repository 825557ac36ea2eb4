// A number that carries its first derivatives: evaluating a source term with jets gives its exact
// Jacobian from the one formula.
#pragma once

#include <array>
#include <cstddef>

namespace sanatrix::healing {

template <std::size_t N>
struct Jet {
  double value = 0.0;
  std::array<double, N> slope{};

  constexpr Jet() = default;
  constexpr Jet(double constant) : value(constant) {}  // implicit: constants mix with jets
  static constexpr Jet variable(double value, std::size_t which) {
    Jet x(value);
    x.slope[which] = 1.0;
    return x;
  }

  friend constexpr Jet operator+(Jet a, const Jet& b) {
    a.value += b.value;
    for (std::size_t i = 0; i < N; ++i) {
      a.slope[i] += b.slope[i];
    }
    return a;
  }
  friend constexpr Jet operator-(Jet a, const Jet& b) {
    a.value -= b.value;
    for (std::size_t i = 0; i < N; ++i) {
      a.slope[i] -= b.slope[i];
    }
    return a;
  }
  friend constexpr Jet operator*(double a, Jet b) {
    b.value *= a;
    for (double& s : b.slope) {
      s *= a;
    }
    return b;
  }
  friend constexpr Jet operator*(const Jet& a, const Jet& b) {
    Jet r(a.value * b.value);
    for (std::size_t i = 0; i < N; ++i) {
      r.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
    }
    return r;
  }
  friend constexpr Jet operator/(const Jet& a, const Jet& b) {
    Jet r(a.value / b.value);
    for (std::size_t i = 0; i < N; ++i) {
      r.slope[i] = (a.slope[i] - r.value * b.slope[i]) / b.value;
    }
    return r;
  }
  friend constexpr bool operator<(const Jet& a, double b) { return a.value < b; }
};

}  // namespace sanatrix::healing
