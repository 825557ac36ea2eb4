// What plans meet in one pose: skin, chest wall and the tissue between them, ready to be searched.
#pragma once

#include <array>
#include <atomic>
#include <span>
#include <vector>

#include "geometry/distance.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::surgery {

/// Distances to a surface on a grid over the body, measured where somebody first asks and kept:
/// while a plan is dragged nearly every question is answered by interpolation. Distances to a
/// smooth surface are nearly linear, so that it errs by less than 0.1 mm but within one step of the
/// surface itself.
class DistanceField {
 public:
  static constexpr double step = 2.5e-3;  ///< [m]
  /// The tree must outlive it.
  DistanceField(const SurfaceTree& tree, std::span<const Vec3> body);
  [[nodiscard]] double operator()(const Vec3& p) const;

 private:
  [[nodiscard]] float at(std::array<int, 3> node) const;
  const SurfaceTree* tree_;
  Vec3 low_;
  std::array<int, 3> size_{};
  mutable std::vector<std::atomic<float>> samples_;  ///< 0: not measured yet
};

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
  [[nodiscard]] const DistanceField& to_skin() const { return to_skin_; }
  [[nodiscard]] const DistanceField& to_chest() const { return to_chest_; }
  /// Per vertex of skin(): the vertices at the other ends of its edges.
  [[nodiscard]] const std::vector<std::vector<int>>& skin_edges() const { return skin_edges_; }

 private:
  const TetMesh* mesh_;
  std::span<const Vec3> points_;
  double midline_x_m_;
  Surface skin_, chest_;
  SurfaceTree skin_tree_, chest_tree_;
  DistanceField to_skin_, to_chest_;
  TetLocator body_;
  std::vector<std::vector<int>> skin_edges_;
};

}  // namespace sanatrix::surgery
