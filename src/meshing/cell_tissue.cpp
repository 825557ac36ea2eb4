// Integrates the fibroglandular fraction over the cells and marks the two breasts.
#include "meshing/cell_tissue.hpp"

#include <limits>

namespace sanatrix::meshing {
namespace {

/// Barycentric coordinates of points spread evenly over a tetrahedron. Cells of 8 mm edges hold
/// about 20 voxels, so 35 points see them all.
std::vector<std::array<double, 4>> even_points() {
  constexpr int n = 4;
  std::vector<std::array<double, 4>> points;
  const auto at = [](int i) {
    return (i + 0.25) / (n + 1.0);
  };
  for (int a = 0; a <= n; ++a) {
    for (int b = 0; a + b <= n; ++b) {
      for (int c = 0; a + b + c <= n; ++c) {
        points.push_back({at(a), at(b), at(c), at(n - a - b - c)});
      }
    }
  }
  return points;
}

int nearest_vertex(const TetMesh& mesh, const std::vector<int>& candidates, const Vec3& p) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const int v : candidates) {
    if (const double d = norm(mesh.points[static_cast<std::size_t>(v)] - p); d < least) {
      least = d;
      best = v;
    }
  }
  return best;
}

}  // namespace

void assign_tissue(BreastModel& model, const Image3<float>& fibroglandular,
                   const BreastMap& breasts, const std::array<Vec3, 2>& nipple_mm) {
  const std::vector<std::array<double, 4>> points = even_points();
  for (const auto& cell : model.mesh.cells) {
    std::array<Vec3, 4> x_mm{};
    for (std::size_t i = 0; i < 4; ++i) {
      x_mm[i] = 1e3 * model.mesh.points[static_cast<std::size_t>(cell[i])];
    }
    double fraction = 0.0;
    for (const auto& b : points) {
      fraction +=
          sample(fibroglandular, b[0] * x_mm[0] + b[1] * x_mm[1] + b[2] * x_mm[2] + b[3] * x_mm[3]);
    }
    model.fibroglandular.push_back(fraction / static_cast<double>(points.size()));
    const Vec3 centre = 0.25 * (x_mm[0] + x_mm[1] + x_mm[2] + x_mm[3]);
    model.side.push_back(centre[0] > 1e3 * model.midline_x_m ? 1 : -1);
    const std::size_t column = breasts.base.nearest(centre[0], centre[2]);
    model.in_breast.push_back(breasts.side[column] == model.side.back() &&
                              centre[1] < breasts.base.value[column] + breasts.behind_base_mm);
  }
  const std::vector<int> skin = vertices_on(model.mesh, "skin");
  for (std::size_t side = 0; side < 2; ++side) {
    model.nipple_vertex[side] = nearest_vertex(model.mesh, skin, 1e-3 * nipple_mm[side]);
  }
}

}  // namespace sanatrix::meshing
