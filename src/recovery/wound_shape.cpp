#include "recovery/wound_shape.hpp"

#include <algorithm>

namespace sanatrix::recovery {

WoundShape::WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
                       std::span<const Vec3> reference_points,
                       std::span<const mechanics::Tissue> healthy)
    : mesh_(&mesh), volumes_(cell_volumes(mesh, reference_points)) {
  // The boundary of the sub-mesh of wound cells: faces that only one of them has.
  TetMesh wound;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (wound_fraction[c] >= 0.5) {
      wound.cells.push_back(mesh.cells[c]);
    }
    at_rest_ += wound_fraction[c] * volumes_[c];
    compliance_.push_back((1.0 - wound_fraction[c]) * volumes_[c] / healthy[c].kappa);
  }
  wound.points = mesh.points;
  wall_ = boundary_of(wound);
}

double WoundShape::volume(std::span<const double> jacobians,
                          std::span<const double> pressure) const {
  double sum = at_rest_;
  for (std::size_t c = 0; c < volumes_.size(); ++c) {
    sum += volumes_[c] * (jacobians[c] - 1.0);
    if (!pressure.empty()) {
      for (const int v : mesh_->cells[c]) {
        sum -= 0.25 * compliance_[c] * pressure[static_cast<std::size_t>(v)];
      }
    }
  }
  return std::max(sum, 0.0);
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
