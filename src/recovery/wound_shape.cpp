#include "recovery/wound_shape.hpp"

#include <algorithm>

namespace sanatrix::recovery {

WoundShape::WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
                       std::span<const Vec3> reference_points)
    : mesh_(&mesh) {
  // The boundary of the sub-mesh of wound cells: faces that only one of them has.
  TetMesh wound;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (wound_fraction[c] >= 0.5) {
      wound.cells.push_back(mesh.cells[c]);
    }
  }
  wound.points = mesh.points;
  wall_ = boundary_of(wound);
  std::vector<bool> wounded(mesh.points.size(), false);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const int v : mesh.cells[c]) {
      wounded[static_cast<std::size_t>(v)] =
          wounded[static_cast<std::size_t>(v)] || wound_fraction[c] > 0.0;
    }
  }
  const std::vector<double> volumes = cell_volumes(mesh, reference_points);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (std::ranges::any_of(mesh.cells[c],
                            [&](int v) { return wounded[static_cast<std::size_t>(v)]; })) {
      touching_.push_back(c);
      healthy_share_.push_back((1.0 - wound_fraction[c]) * volumes[c]);
    }
  }
}

double WoundShape::volume(std::span<const Vec3> points) const {
  const std::vector<double> volumes = cell_volumes(*mesh_, points);
  double sum = 0.0;
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    sum += volumes[touching_[i]] - healthy_share_[i];
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
