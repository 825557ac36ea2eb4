#include "recovery/wound_shape.hpp"

#include <algorithm>

namespace sanatrix::recovery {

WoundShape::WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
                       std::span<const Vec3> reference_points)
    : mesh_(&mesh), fraction_(wound_fraction.begin(), wound_fraction.end()) {
  // The boundary of the sub-mesh of wound cells: faces that only one of them has.
  TetMesh wound;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (fraction_[c] >= 0.5) {
      wound.cells.push_back(mesh.cells[c]);
    }
  }
  wound.points = mesh.points;
  wall_ = boundary_of(wound);
  healthy_share_ = cell_volumes(mesh, reference_points);
  for (std::size_t c = 0; c < fraction_.size(); ++c) {
    healthy_share_[c] *= 1.0 - fraction_[c];
  }
}

double WoundShape::volume(std::span<const Vec3> points) const {
  const std::vector<double> volumes = cell_volumes(*mesh_, points);
  double sum = 0.0;
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    sum += fraction_[c] > 0.0 ? std::max(volumes[c] - healthy_share_[c], 0.0) : 0.0;
  }
  return sum;
}

double WoundShape::mean_inward_displacement(std::span<const Vec3> before,
                                            std::span<const Vec3> after) const {
  double moved = 0.0;
  double area = 0.0;
  for (const auto& face : wall_) {
    const auto a = static_cast<std::size_t>(face[0]);
    const auto b = static_cast<std::size_t>(face[1]);
    const auto c = static_cast<std::size_t>(face[2]);
    const Vec3 normal = 0.5 * cross(before[b] - before[a], before[c] - before[a]);
    const Vec3 mean =
        (1.0 / 3.0) * ((after[a] - before[a]) + (after[b] - before[b]) + (after[c] - before[c]));
    moved -= dot(mean, normal);
    area += norm(normal);
  }
  return area > 0.0 ? moved / area : 0.0;
}

}  // namespace sanatrix::recovery
