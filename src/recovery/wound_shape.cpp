#include "recovery/wound_shape.hpp"

#include <algorithm>

namespace sanatrix::recovery {

namespace {

/// Of a face's vertices the first in the whole mesh decides. Its owner knows all cells around it
/// and therefore which faces are wall; others may take the rim of their share for one.
bool owns_face(const fem::MeshShare* share, const std::array<int, 3>& face) {
  if (share == nullptr) {
    return true;
  }
  return share->owns_vertex(*std::ranges::min_element(
      face, {}, [&](int v) { return share->vertex()[static_cast<std::size_t>(v)]; }));
}

}  // namespace

WoundShape::WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
                       std::span<const Vec3> reference_points,
                       std::span<const mechanics::Tissue> healthy, const fem::MeshShare* share)
    : mesh_(&mesh), share_(share), volumes_(cell_volumes(mesh, reference_points)) {
  // The boundary of the sub-mesh of wound cells: faces that only one of them has.
  TetMesh wound;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (wound_fraction[c] >= 0.5) {
      wound.cells.push_back(mesh.cells[c]);
    }
    volumes_[c] = fem::owns_cell(share, c) ? volumes_[c] : 0.0;
    at_rest_ += wound_fraction[c] * volumes_[c];
    compliance_.push_back((1.0 - wound_fraction[c]) * volumes_[c] / healthy[c].kappa);
  }
  wound.points = mesh.points;
  wall_ = boundary_of(wound);
  std::erase_if(wall_, [&](const std::array<int, 3>& face) { return !owns_face(share, face); });
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
  return std::max(fem::sum(share_, sum), 0.0);
}

double WoundShape::mean_inward_displacement(std::span<const Vec3> before,
                                            std::span<const Vec3> after) const {
  std::array<double, 2> sums{};
  auto& [moved, area] = sums;
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
  fem::sum_each(share_, sums);
  return area > 0.0 ? moved / area : 0.0;
}

}  // namespace sanatrix::recovery
