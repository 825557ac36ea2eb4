// How long the edges should be where: fine in the focus and in thin tissue, coarse elsewhere.
#pragma once

#include <optional>

#include "meshing/anatomy.hpp"
#include "meshing/breast_mesh.hpp"

namespace sanatrix::meshing {

/// All lengths in mm.
class Sizing {
 public:
  Sizing(const Anatomy& anatomy, const MeshOptions& options);

  /// Wanted edge length.
  [[nodiscard]] double edge_mm(const Vec3& p_mm) const;
  /// Tells how many vertices a mesh of the present sizes has.
  void learn(int count);
  /// Chooses the scale of the edges so that about this many vertices are needed.
  void aim_at(int target);
  /// Edge length in the focus; larger than asked for when the target leaves no other way.
  [[nodiscard]] double near_mm() const { return near_mm_; }
  [[nodiscard]] double far_mm() const { return far_mm_; }

 private:
  void set_scale(double scale);
  /// Sum of volume / edge^3: the number of vertices is about linear in it.
  [[nodiscard]] double edge_cubes() const;

  struct Sample {
    double thickness, beyond_focus;
  };
  [[nodiscard]] double edge_mm(const Sample& s) const;
  [[nodiscard]] double beyond_focus_mm(const Vec3& p_mm) const;

  const Image3<float>& thickness_;
  std::optional<Focus> focus_;  ///< [m]
  double asked_near_mm_, asked_far_mm_;
  double near_mm_ = 0.0, far_mm_ = 0.0;
  double thin_part_ = 0.0;       ///< edge length / thickness of tissue where it is thin
  std::vector<Sample> samples_;  ///< spread evenly over the domain
  double volume_per_sample_mm3_ = 0.0;
  double vertices_per_cube_;
  double other_vertices_ = 0.0;  ///< needed by the surface whatever the edge length
  struct Known {
    double cubes, count;
  };
  std::optional<Known> known_;  ///< of the latest mesh
};

}  // namespace sanatrix::meshing
