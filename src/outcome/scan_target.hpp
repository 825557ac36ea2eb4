// A scan prepared for closest points: with normals, and knowing where it ends.
#pragma once

#include <optional>

#include "geometry/distance.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::outcome {

class ScanTarget {
 public:
  explicit ScanTarget(TriMesh surface);

  struct Hit {
    Vec3 point, normal;
    double distance;  ///< [m]
    int triangle;
    bool on_border;  ///< at a hole or at the end of the scan: nothing may be concluded from it
  };
  [[nodiscard]] Hit closest(const Vec3& p) const;
  /// Whether the scan ends, or has a hole, nearly as near to p as its closest point is: on a jagged
  /// rim that point need not lie on the border. Costs a second search.
  [[nodiscard]] bool ends_near(const Vec3& p, const Hit& hit) const;
  [[nodiscard]] const TriMesh& surface() const { return surface_; }

 private:
  TriMesh surface_;
  SurfaceTree tree_;
  std::vector<Vec3> normals_;       ///< per vertex
  std::vector<bool> border_;        ///< per vertex
  std::optional<SurfaceTree> rim_;  ///< of triangles with vertices on the border
};

/// A third of the area of the triangles around each vertex [m2].
std::vector<double> vertex_areas(const TriMesh& surface);
/// Vertices on edges that belong to one triangle only.
std::vector<bool> border_vertices(const TriMesh& surface);
/// Weights of a point of a triangle's plane at its corners.
std::array<double, 3> weights_in(const TriMesh& surface, int triangle, const Vec3& p);
/// One vertex per occupied cube of this edge length; for scans with more triangles than a search
/// needs.
TriMesh coarsened(const TriMesh& surface, double edge_m);

}  // namespace sanatrix::outcome
