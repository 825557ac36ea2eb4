// Moving without changing shape: x -> R x + t.
#pragma once

#include "geometry/tri_mesh.hpp"

namespace sanatrix {

struct Rigid {
  Mat3 rotation = identity3;  ///< proper: determinant +1
  Vec3 shift{};               ///< [m]

  [[nodiscard]] Vec3 operator()(const Vec3& p) const { return rotation * p + shift; }
};

inline Rigid inverse(const Rigid& move) {
  const Mat3 back = transpose(move.rotation);
  return {back, -1.0 * (back * move.shift)};
}
/// First b, then a.
inline Rigid operator*(const Rigid& a, const Rigid& b) {
  return {a.rotation * b.rotation, a(b.shift)};
}
inline TriMesh moved(TriMesh surface, const Rigid& move) {
  for (Vec3& p : surface.points) {
    p = move(p);
  }
  return surface;
}

}  // namespace sanatrix
