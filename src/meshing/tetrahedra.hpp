// Fills a closed surface with graded tetrahedra.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "meshing/domain_surface.hpp"

namespace sanatrix::meshing {

/// Wanted edge length [mm] at a position [mm]. May throw to stop the work.
using SizeField = std::function<double(const Vec3&)>;

struct Tetrahedra {
  std::vector<Vec3> points_mm;
  std::vector<std::array<int, 4>> cells;  ///< positive volume
  struct Face {
    std::array<int, 3> vertex;  ///< outwards
    Patch patch;
  };
  std::vector<Face> faces;  ///< the whole boundary
};

/// Delaunay refinement that keeps the edges between patches sharp (CGAL Mesh_3).
class Refinement {
 public:
  explicit Refinement(const DomainSurface& surface);
  ~Refinement();
  Refinement(const Refinement&) = delete;
  Refinement& operator=(const Refinement&) = delete;

  /// A new mesh of the domain, always the same for the same sizes; returns its number of vertices.
  int refine(const SizeField& edge_mm, double surface_distance_mm);
  /// Moves and reweights vertices of flat cells until all dihedral angles exceed the bound, nothing
  /// helps any more or the time is over.
  void improve_angles(double bound_deg, double seconds);
  [[nodiscard]] Tetrahedra mesh() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::meshing
