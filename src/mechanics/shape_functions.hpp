// Lagrange basis functions of degree 1 and 2 on tetrahedra and triangles, and quadrature rules.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "fem/layout.hpp"
#include "geometry/vec3.hpp"

namespace sanatrix::mechanics {

/// Barycentric point and weight; weights add up to 1 (times the simplex's measure).
template <std::size_t Vertices>
struct QuadraturePoint {
  std::array<double, Vertices> lambda;
  double weight;
};

/// Exact for degree 1.
inline constexpr std::array<QuadraturePoint<4>, 1> tet_centroid{{{{0.25, 0.25, 0.25, 0.25}, 1.0}}};
/// Exact for degree 2, 4 points: what the gradients of quadratic elements need (as C3D10 does; 14
/// points of degree 5 changed the hemisphere's apex by less than 0.1 % at three times the cost).
std::span<const QuadraturePoint<4>> tet_degree2();
/// Exact for degree 5, 14 points (Walkington 2000), for given functions of the position.
std::span<const QuadraturePoint<4>> tet_degree5();
inline constexpr std::array<QuadraturePoint<3>, 1> triangle_centroid{
    {{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 1.0}}};
/// Exact for degree 4, 6 points (Dunavant 1985, doi:10.1002/nme.1620210612).
std::span<const QuadraturePoint<3>> triangle_degree4();

/// Nodes of the tetrahedron: 4 vertices, then the mid-edges in the order of fem::EdgeTable::local.
/// Values and derivatives with respect to lambda1, lambda2, lambda3 (lambda0 = 1 - sum).
template <std::size_t Nodes>
struct TetBasis {
  std::array<double, Nodes> value;
  std::array<Vec3, Nodes> derivative;
  explicit TetBasis(const std::array<double, 4>& lambda);
};

/// Nodes of the triangle: 3 vertices, then mid-edges 01, 12, 20.
/// Derivatives with respect to lambda1 and lambda2.
template <std::size_t Nodes>
struct TriangleBasis {
  std::array<double, Nodes> value;
  std::array<std::array<double, 2>, Nodes> derivative;
  explicit TriangleBasis(const std::array<double, 3>& lambda);
};

}  // namespace sanatrix::mechanics
