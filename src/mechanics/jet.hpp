// A number that carries its exact gradient and Hessian with respect to N inputs.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace sanatrix::mechanics {

template <std::size_t N>
struct Jet {
  double value = 0.0;
  std::array<double, N> gradient{};
  std::array<std::array<double, N>, N> hessian{};

  static Jet input(std::size_t i, double v) {
    Jet x;
    x.value = v;
    x.gradient[i] = 1.0;
    return x;
  }
  /// f(x) given f, f' and f'' at x.value.
  [[nodiscard]] Jet chain(double f, double f1, double f2) const {
    Jet r;
    r.value = f;
    for (std::size_t i = 0; i < N; ++i) {
      r.gradient[i] = f1 * gradient[i];
      for (std::size_t j = 0; j < N; ++j) {
        r.hessian[i][j] = f1 * hessian[i][j] + f2 * gradient[i] * gradient[j];
      }
    }
    return r;
  }
  friend Jet operator+(const Jet& a, const Jet& b) {
    Jet r;
    r.value = a.value + b.value;
    for (std::size_t i = 0; i < N; ++i) {
      r.gradient[i] = a.gradient[i] + b.gradient[i];
      for (std::size_t j = 0; j < N; ++j) {
        r.hessian[i][j] = a.hessian[i][j] + b.hessian[i][j];
      }
    }
    return r;
  }
  friend Jet operator*(double s, const Jet& a) { return a.chain(s * a.value, s, 0.0); }
  friend Jet operator+(const Jet& a, double s) { return a.chain(a.value + s, 1.0, 0.0); }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + (-1.0) * b; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet r;
    r.value = a.value * b.value;
    for (std::size_t i = 0; i < N; ++i) {
      r.gradient[i] = a.gradient[i] * b.value + a.value * b.gradient[i];
      for (std::size_t j = 0; j < N; ++j) {
        r.hessian[i][j] = a.hessian[i][j] * b.value + a.gradient[i] * b.gradient[j] +
                          a.gradient[j] * b.gradient[i] + a.value * b.hessian[i][j];
      }
    }
    return r;
  }
};

template <std::size_t N>
Jet<N> reciprocal(const Jet<N>& x) {
  const double r = 1.0 / x.value;
  return x.chain(r, -r * r, 2.0 * r * r * r);
}
template <std::size_t N>
Jet<N> sqrt(const Jet<N>& x) {
  const double r = std::sqrt(x.value);
  return x.chain(r, 0.5 / r, -0.25 / (r * x.value));
}
template <std::size_t N>
Jet<N> exp(const Jet<N>& x) {
  const double e = std::exp(x.value);
  return x.chain(e, e, e);
}

}  // namespace sanatrix::mechanics
