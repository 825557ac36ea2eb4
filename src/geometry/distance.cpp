// Closest point on triangles and tetrahedra, driven by the box tree.
#include "geometry/distance.hpp"

#include "core/error.hpp"
#include "geometry/box_tree.hpp"

namespace sanatrix {
namespace {

using Corners3 = std::array<Vec3, 3>;

double ratio(double part, double whole) {
  return whole > 0 ? part / whole : 0.0;
}

/// By the Voronoi regions of the triangle's corners and edges; Ericson, Real-Time Collision
/// Detection (2005), section 5.1.5. Works for triangles without area too.
Vec3 closest_on_triangle(const Vec3& p, const Corners3& t) {
  const auto& [a, b, c] = t;
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const double d1 = dot(ab, p - a);
  const double d2 = dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) {
    return a;
  }
  const double d3 = dot(ab, p - b);
  const double d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) {
    return b;
  }
  const double d5 = dot(ab, p - c);
  const double d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) {
    return c;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    return a + ratio(d1, d1 - d3) * ab;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    return a + ratio(d2, d2 - d6) * ac;
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return b + ratio(d4 - d3, (d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double sum = va + vb + vc;
  return a + ratio(vb, sum) * ab + ratio(vc, sum) * ac;
}

template <class Corners>
Box box_of(const Corners& corners) {
  Box box;
  for (const Vec3& x : corners) {
    box.include(x);
  }
  return box;
}

template <class Corners>
std::vector<Box> boxes_of(const std::vector<Corners>& all) {
  std::vector<Box> boxes;
  boxes.reserve(all.size());
  for (const Corners& corners : all) {
    boxes.push_back(box_of(corners));
  }
  return boxes;
}

std::vector<Corners3> corners_of(const TriMesh& surface) {
  require(!surface.triangles.empty(), "a surface to measure distances to has no triangles");
  std::vector<Corners3> corners;
  corners.reserve(surface.triangles.size());
  for (const auto& [a, b, c] : surface.triangles) {
    corners.push_back({surface.points[static_cast<std::size_t>(a)],
                       surface.points[static_cast<std::size_t>(b)],
                       surface.points[static_cast<std::size_t>(c)]});
  }
  return corners;
}

using Corners4 = std::array<Vec3, 4>;

std::vector<Corners4> corners_of(const TetMesh& mesh, std::span<const Vec3> points) {
  require(!mesh.cells.empty(), "a mesh to locate points in has no tetrahedra");
  std::vector<Corners4> corners;
  corners.reserve(mesh.cells.size());
  for (const auto& [a, b, c, d] : mesh.cells) {
    corners.push_back({points[static_cast<std::size_t>(a)], points[static_cast<std::size_t>(b)],
                       points[static_cast<std::size_t>(c)], points[static_cast<std::size_t>(d)]});
  }
  return corners;
}

std::array<double, 4> barycentric(const Vec3& p, const Corners4& x) {
  const Vec3 b = x[1] - x[0];
  const Vec3 c = x[2] - x[0];
  const Vec3 d = x[3] - x[0];
  const Vec3 r = p - x[0];
  const Vec3 cd = cross(c, d);
  const Vec3 rb = cross(r, b);
  const double scale = 1.0 / dot(b, cd);
  const double l1 = scale * dot(r, cd);
  const double l2 = -scale * dot(d, rb);
  const double l3 = scale * dot(c, rb);
  return {1.0 - l1 - l2 - l3, l1, l2, l3};
}

double smallest(const std::array<double, 4>& b) {
  return std::min({b[0], b[1], b[2], b[3]});
}

/// Rounding of barycentric coordinates, relative to 1: a point on a common face is in a cell.
constexpr double on_face = -1e-12;

double squared_distance(const Vec3& p, const Corners4& x) {
  double best = std::numeric_limits<double>::max();
  for (const Corners3& face : {Corners3{x[1], x[2], x[3]}, Corners3{x[0], x[3], x[2]},
                               Corners3{x[0], x[1], x[3]}, Corners3{x[0], x[2], x[1]}}) {
    const Vec3 r = p - closest_on_triangle(p, face);
    best = std::min(best, dot(r, r));
  }
  return best;
}

}  // namespace

struct SurfaceTree::Impl {
  explicit Impl(const TriMesh& surface) : corners(corners_of(surface)), tree(boxes_of(corners)) {}
  std::vector<Corners3> corners;
  BoxTree tree;
};

SurfaceTree::SurfaceTree(const TriMesh& surface) : impl_(std::make_unique<Impl>(surface)) {}
SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

SurfaceTree::Hit SurfaceTree::closest(const Vec3& p) const {
  Hit hit{p, 0.0, -1};
  double best = std::numeric_limits<double>::max();
  impl_->tree.within(p, best, [&](int triangle) {
    const Vec3 q = closest_on_triangle(p, impl_->corners[static_cast<std::size_t>(triangle)]);
    const double distance2 = dot(p - q, p - q);
    if (distance2 < best) {
      best = distance2;
      hit = {q, std::sqrt(distance2), triangle};
    }
  });
  return hit;
}

double SurfaceTree::distance(const Vec3& p, double reach, int& near) const {
  double best = std::isfinite(reach) ? reach * reach : std::numeric_limits<double>::max();
  const auto look = [&](int triangle) {
    const Vec3 r = p - closest_on_triangle(p, impl_->corners[static_cast<std::size_t>(triangle)]);
    if (dot(r, r) < best) {
      best = dot(r, r);
      near = triangle;
    }
  };
  if (near >= 0) {
    look(near);
  }
  impl_->tree.within(p, best, look);
  return std::sqrt(best);
}

struct TetLocator::Impl {
  Impl(const TetMesh& mesh, std::span<const Vec3> points)
      : corners(corners_of(mesh, points)), tree(boxes_of(corners)) {}
  std::vector<Corners4> corners;
  BoxTree tree;
};

TetLocator::TetLocator(const TetMesh& mesh, std::span<const Vec3> points)
    : impl_(std::make_unique<Impl>(mesh, points)) {}
TetLocator::~TetLocator() = default;
TetLocator::TetLocator(TetLocator&&) noexcept = default;
TetLocator& TetLocator::operator=(TetLocator&&) noexcept = default;

std::optional<TetLocator::Place> TetLocator::locate(const Vec3& p) const {
  std::optional<Place> place;
  double reach2 = 0;
  impl_->tree.within(p, reach2, [&](int cell) {
    if (place) {
      return;
    }
    const auto coordinates = barycentric(p, impl_->corners[static_cast<std::size_t>(cell)]);
    if (smallest(coordinates) >= on_face) {
      place = Place{cell, coordinates};
      reach2 = -1;
    }
  });
  return place;
}

TetLocator::Place TetLocator::nearest(const Vec3& p) const {
  if (const auto inside = locate(p)) {
    return *inside;
  }
  // Cells around the closest vertex or edge are equally near up to rounding; reach2 keeps them all.
  constexpr double equal = 1 + 1e-9;
  Place place{-1, {}};
  double best = std::numeric_limits<double>::max();
  double reach2 = best;
  impl_->tree.within(p, reach2, [&](int cell) {
    const Corners4& x = impl_->corners[static_cast<std::size_t>(cell)];
    const double distance2 = squared_distance(p, x);
    if (distance2 > best * equal) {
      return;
    }
    const auto coordinates = barycentric(p, x);
    if (distance2 * equal < best || smallest(coordinates) > smallest(place.barycentric)) {
      place = {cell, coordinates};
    }
    best = std::min(best, distance2);
    reach2 = best * equal;
  });
  return place;
}

}  // namespace sanatrix
