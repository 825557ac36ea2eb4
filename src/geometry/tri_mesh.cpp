// Areas, normals and extraction of triangulated surfaces.
#include "geometry/tri_mesh.hpp"

#include <algorithm>

#include <fmt/ranges.h>

#include "core/error.hpp"

namespace sanatrix {

double area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * norm(cross(b - a, c - a));
}

double surface_area(const TriMesh& surface) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    sum += area(surface.points[static_cast<std::size_t>(a)],
                surface.points[static_cast<std::size_t>(b)],
                surface.points[static_cast<std::size_t>(c)]);
  }
  return sum;
}

std::vector<Vec3> vertex_normals(const TriMesh& surface) {
  std::vector<Vec3> normals(surface.points.size(), Vec3{0, 0, 0});
  for (const auto& triangle : surface.triangles) {
    const Vec3& a = surface.points[static_cast<std::size_t>(triangle[0])];
    const Vec3& b = surface.points[static_cast<std::size_t>(triangle[1])];
    const Vec3& c = surface.points[static_cast<std::size_t>(triangle[2])];
    const Vec3 weighted = cross(b - a, c - a);
    for (const int v : triangle) {
      normals[static_cast<std::size_t>(v)] += weighted;
    }
  }
  for (Vec3& normal : normals) {
    if (norm(normal) > 0) {
      normal = normalised(normal);
    }
  }
  return normals;
}

Surface extract_surface(const TetMesh& mesh, std::span<const Vec3> points,
                        const std::vector<std::string>& boundary_names) {
  std::vector<bool> wanted(mesh.boundary_names.size(), false);
  for (const std::string& name : boundary_names) {
    if (const int index = boundary_index(mesh, name); index >= 0) {
      wanted[static_cast<std::size_t>(index)] = true;
    }
  }
  Surface surface;
  for (const BoundaryFace& face : mesh.faces) {
    if (wanted[static_cast<std::size_t>(face.name)]) {
      surface.mesh.triangles.push_back(face.vertex);
      surface.vertex.insert(surface.vertex.end(), face.vertex.begin(), face.vertex.end());
    }
  }
  require(!surface.vertex.empty(), "the mesh has no boundary faces named {}; it has {}",
          fmt::join(boundary_names, ", "), fmt::join(mesh.boundary_names, ", "));
  std::sort(surface.vertex.begin(), surface.vertex.end());
  surface.vertex.erase(std::unique(surface.vertex.begin(), surface.vertex.end()),
                       surface.vertex.end());
  for (const int v : surface.vertex) {
    surface.mesh.points.push_back(points[static_cast<std::size_t>(v)]);
  }
  for (auto& triangle : surface.mesh.triangles) {
    for (int& v : triangle) {
      v = static_cast<int>(std::lower_bound(surface.vertex.begin(), surface.vertex.end(), v) -
                           surface.vertex.begin());
    }
  }
  return surface;
}

}  // namespace sanatrix
