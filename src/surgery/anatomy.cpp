#include "surgery/anatomy.hpp"

namespace sanatrix::surgery {
namespace {

std::vector<std::vector<int>> edges_of(const TriMesh& surface) {
  std::vector<std::vector<int>> result(surface.points.size());
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      result[static_cast<std::size_t>(a)].push_back(b);
      result[static_cast<std::size_t>(b)].push_back(a);
    }
  }
  return result;
}

}  // namespace

Anatomy::Anatomy(const TetMesh& mesh, std::span<const Vec3> points, double midline_x_m)
    : mesh_(&mesh),
      points_(points),
      midline_x_m_(midline_x_m),
      skin_(extract_surface(mesh, points, {"skin"})),
      chest_(extract_surface(mesh, points, {"chest"})),
      skin_tree_(skin_.mesh),
      chest_tree_(chest_.mesh),
      body_(mesh, points),
      skin_edges_(edges_of(skin_.mesh)) {}

}  // namespace sanatrix::surgery
