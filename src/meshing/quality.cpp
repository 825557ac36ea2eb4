// Angles, edge lengths and smoothness of a breast mesh.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "meshing/breast_mesh.hpp"

namespace sanatrix::meshing {
namespace {

double quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return 0.0;
  }
  const auto at = values.begin() + static_cast<long>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

bool in_focus(const Focus& focus, const Vec3& p) {
  const Vec3 axis = focus.b - focus.a;
  const double t = std::clamp(dot(p - focus.a, axis) / std::max(dot(axis, axis), 1e-12), 0.0, 1.0);
  return norm(p - (focus.a + t * axis)) <= focus.radius;
}

/// Angle between the normals of skin faces that share an edge, 95th percentile [degree].
double skin_roughness(const TetMesh& mesh) {
  const int skin = boundary_index(mesh, "skin");
  std::map<std::pair<int, int>, Vec3> first;
  std::vector<double> angles;
  for (const BoundaryFace& face : mesh.faces) {
    if (face.name != skin) {
      continue;
    }
    std::array<Vec3, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = mesh.points[static_cast<std::size_t>(face.vertex[i])];
    }
    const Vec3 n = normalised(cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [entry, fresh] =
          first.try_emplace(std::minmax(face.vertex[i], face.vertex[(i + 1) % 3]), n);
      if (!fresh) {
        angles.push_back(std::acos(std::clamp(dot(entry->second, n), -1.0, 1.0)) * 180.0 /
                         std::numbers::pi);
      }
    }
  }
  return quantile(std::move(angles), 0.95);
}

}  // namespace

MeshQuality measure_quality(const BreastModel& model, const std::optional<Focus>& focus) {
  const TetMesh& mesh = model.mesh;
  MeshQuality quality{};
  std::vector<double> angles = min_dihedral_angles(mesh, mesh.points);
  quality.min_dihedral_deg = *std::min_element(angles.begin(), angles.end());
  quality.p01_dihedral_deg = quantile(std::move(angles), 0.01);

  std::set<std::pair<int, int>> edges;
  for (const auto& cell : mesh.cells) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        edges.insert(std::minmax(cell[i], cell[j]));
      }
    }
  }
  double sum = 0.0;
  double focus_sum = 0.0;
  double focus_count = 0.0;
  quality.min_edge_m = 1e9;
  for (const auto& [a, b] : edges) {
    const Vec3& p = mesh.points[static_cast<std::size_t>(a)];
    const Vec3& q = mesh.points[static_cast<std::size_t>(b)];
    const double length = norm(p - q);
    quality.min_edge_m = std::min(quality.min_edge_m, length);
    quality.max_edge_m = std::max(quality.max_edge_m, length);
    sum += length;
    if (focus && in_focus(*focus, 0.5 * (p + q))) {
      focus_sum += length;
      focus_count += 1.0;
    }
  }
  quality.mean_edge_m = sum / static_cast<double>(edges.size());
  quality.mean_edge_in_focus_m = focus_count > 0.0 ? focus_sum / focus_count : 0.0;
  quality.skin_roughness_deg = skin_roughness(mesh);
  return quality;
}

}  // namespace sanatrix::meshing
