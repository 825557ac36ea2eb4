// Points and 3x3 matrices as plain arrays, with the few operations the kernels need.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace sanatrix {

using Vec3 = std::array<double, 3>;
using Mat3 = std::array<std::array<double, 3>, 3>;  ///< row-major, m[row][column]

inline constexpr Mat3 identity3{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
constexpr Vec3 operator*(double s, const Vec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
constexpr Vec3& operator+=(Vec3& a, const Vec3& b) {
  return a = a + b;
}
constexpr double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
/// Unit vector along a; a must not be zero.
inline Vec3 normalised(const Vec3& a) {
  return (1.0 / norm(a)) * a;
}

constexpr double determinant(const Mat3& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}
constexpr Mat3 inverse(const Mat3& m) {
  const double d = 1.0 / determinant(m);
  return {
      {{d * (m[1][1] * m[2][2] - m[1][2] * m[2][1]), d * (m[0][2] * m[2][1] - m[0][1] * m[2][2]),
        d * (m[0][1] * m[1][2] - m[0][2] * m[1][1])},
       {d * (m[1][2] * m[2][0] - m[1][0] * m[2][2]), d * (m[0][0] * m[2][2] - m[0][2] * m[2][0]),
        d * (m[0][2] * m[1][0] - m[0][0] * m[1][2])},
       {d * (m[1][0] * m[2][1] - m[1][1] * m[2][0]), d * (m[0][1] * m[2][0] - m[0][0] * m[2][1]),
        d * (m[0][0] * m[1][1] - m[0][1] * m[1][0])}}};
}
constexpr Vec3 operator*(const Mat3& m, const Vec3& v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 r{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      r[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    }
  }
  return r;
}
constexpr Mat3 transpose(const Mat3& m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}

}  // namespace sanatrix
