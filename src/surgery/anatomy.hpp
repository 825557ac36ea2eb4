// What plans meet in one pose: skin, chest wall and the tissue between them, ready to be searched.
#pragma once

#include <span>
#include <vector>

#include "geometry/distance.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::surgery {

/// Search trees cost more than a plan: made once, they serve every change of it. Shared by threads.
class Anatomy {
 public:
  /// Mesh and vertex positions [m] must outlive it. Error{Input} without skin or chest boundary.
  Anatomy(const TetMesh& mesh, std::span<const Vec3> points, double midline_x_m);

  [[nodiscard]] const TetMesh& mesh() const { return *mesh_; }
  [[nodiscard]] std::span<const Vec3> points() const { return points_; }
  [[nodiscard]] double midline_x_m() const { return midline_x_m_; }
  [[nodiscard]] const Surface& skin() const { return skin_; }
  [[nodiscard]] const Surface& chest() const { return chest_; }
  [[nodiscard]] const SurfaceTree& skin_tree() const { return skin_tree_; }
  [[nodiscard]] const SurfaceTree& chest_tree() const { return chest_tree_; }
  [[nodiscard]] const TetLocator& body() const { return body_; }
  /// Per vertex of skin(): the vertices at the other ends of its edges.
  [[nodiscard]] const std::vector<std::vector<int>>& skin_edges() const { return skin_edges_; }

 private:
  const TetMesh* mesh_;
  std::span<const Vec3> points_;
  double midline_x_m_;
  Surface skin_, chest_;
  SurfaceTree skin_tree_, chest_tree_;
  TetLocator body_;
  std::vector<std::vector<int>> skin_edges_;
};

}  // namespace sanatrix::surgery
