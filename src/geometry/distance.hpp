// Closest point and point location queries, by bounding-volume trees of our geometry only.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "geometry/tri_mesh.hpp"

namespace sanatrix {

/// Closest points on a triangulated surface. Keeps its own copy of the surface.
class SurfaceTree {
 public:
  explicit SurfaceTree(const TriMesh& surface);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  struct Hit {
    Vec3 point;
    double distance;  ///< [m]
    int triangle;
  };
  [[nodiscard]] Hit closest(const Vec3& p) const;
  /// The distance, or `reach` when the surface is farther. `near` is a triangle to look at first
  /// (-1: none) and becomes the closest one: in a row of neighbouring points each search is short.
  [[nodiscard]] double distance(const Vec3& p, double reach, int& near) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Finds the tetrahedron that contains a point. Keeps its own copy of the mesh.
class TetLocator {
 public:
  TetLocator(const TetMesh& mesh, std::span<const Vec3> points);
  ~TetLocator();
  TetLocator(TetLocator&&) noexcept;
  TetLocator& operator=(TetLocator&&) noexcept;

  struct Place {
    int cell;
    std::array<double, 4> barycentric;
  };
  /// Nothing when p is outside the mesh.
  [[nodiscard]] std::optional<Place> locate(const Vec3& p) const;
  /// The cell that contains p, or else the one whose barycentric coordinates are least negative
  /// among the nearest cells; for points that rounding put just outside.
  [[nodiscard]] Place nearest(const Vec3& p) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix
