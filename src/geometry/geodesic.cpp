#include "geometry/geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include "geometry/distance.hpp"

namespace sanatrix {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Ways =
    CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>>;

/// The mesh with points at equal places joined, and the face of each triangle; triangles that
/// cannot be joined (edges of three) are left out and have no face.
struct Joined {
  Mesh mesh;
  std::vector<Mesh::Face_index> face;
};

Joined joined(const TriMesh& surface) {
  Joined result;
  std::map<std::array<double, 3>, Mesh::Vertex_index> known;
  std::vector<Mesh::Vertex_index> vertex;
  for (const Vec3& p : surface.points) {
    const auto [place, is_new] = known.try_emplace(std::array<double, 3>{p[0], p[1], p[2]});
    if (is_new) {
      place->second = result.mesh.add_vertex({p[0], p[1], p[2]});
    }
    vertex.push_back(place->second);
  }
  for (const auto& [a, b, c] : surface.triangles) {
    result.face.push_back(result.mesh.add_face(vertex[static_cast<std::size_t>(a)],
                                               vertex[static_cast<std::size_t>(b)],
                                               vertex[static_cast<std::size_t>(c)]));
  }
  return result;
}

/// Weights of a point at the corners of a triangle, in their order. Never quite on an edge or a
/// corner: CGAL 5.5 takes sources there for their mirror images on the edge.
std::array<double, 3> weights_at(const std::array<Vec3, 3>& t, const Vec3& p) {
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  const double area = dot(n, n);
  constexpr double inside = 1e-7;  // of the edges, which are millimetres long
  std::array<double, 3> w{1.0 / 3, 1.0 / 3, 1.0 / 3};
  for (std::size_t k = 0; k < 3 && area > 0; ++k) {
    w[k] = std::max(dot(n, cross(t[(k + 1) % 3] - p, t[(k + 2) % 3] - p)) / area, inside);
  }
  const double sum = w[0] + w[1] + w[2];
  return {w[0] / sum, w[1] / sum, w[2] / sum};
}

/// What a way of at most lengths[i] from a point to another, to[i], can cross: it stays within the
/// ellipsoid with these foci, and so does some point of every triangle that it crosses.
TriMesh piece_between(const TriMesh& surface, const Vec3& from, std::span<const Vec3> to,
                      std::span<const double> lengths) {
  const auto within = [&](const std::array<int, 3>& t) {
    const auto corner = [&](std::size_t k) {
      return surface.points[static_cast<std::size_t>(t[k % 3])];
    };
    double edge = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      edge = std::max(edge, norm(corner(k + 1) - corner(k)));
    }
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (norm(corner(0) - from) + norm(corner(0) - to[i]) <= lengths[i] + 2.0 * edge) {
        return true;
      }
    }
    return false;
  };
  TriMesh piece = surface;
  std::erase_if(piece.triangles, [&](const std::array<int, 3>& t) { return !within(t); });
  return piece;
}

std::vector<double> lengths_on(const TriMesh& surface, const Vec3& from, std::span<const Vec3> to) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  const Joined body = joined(surface);
  const SurfaceTree tree(surface);
  const auto locate = [&](const Vec3& p) -> std::optional<Ways::Face_location> {
    const SurfaceTree::Hit hit = tree.closest(p);
    const Mesh::Face_index face = body.face[static_cast<std::size_t>(hit.triangle)];
    if (face == Mesh::null_face()) {
      return std::nullopt;
    }
    // CGAL counts corners from the source of the face's halfedge.
    std::array<Vec3, 3> corners;
    auto h = body.mesh.halfedge(face);
    for (Vec3& corner : corners) {
      const auto& q = body.mesh.point(body.mesh.source(h));
      corner = {q.x(), q.y(), q.z()};
      h = body.mesh.next(h);
    }
    const std::array<double, 3> w = weights_at(corners, hit.point);
    return Ways::Face_location{face, {w[0], w[1], w[2]}};
  };
  std::vector<double> lengths(to.size(), nothing);
  const auto source = locate(from);
  if (!source) {
    return lengths;
  }
  Ways ways(body.mesh);
  ways.add_source_point(*source);
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (const auto target = locate(to[i])) {
      const double length =
          ways.shortest_distance_to_source_points(target->first, target->second).first;
      lengths[i] = length >= 0 ? length : nothing;
    }
  }
  return lengths;
}

}  // namespace

std::vector<double> lengths_along(const TriMesh& surface, const Vec3& from,
                                  std::span<const Vec3> to) {
  // Most of a body need not be searched: ways are seldom longer than this.
  for (const double detour : {1.15, 1.5}) {
    std::vector<double> reach;
    for (const Vec3& p : to) {
      reach.push_back(detour * norm(p - from));
    }
    const TriMesh piece = piece_between(surface, from, to, reach);
    if (piece.triangles.empty()) {
      break;
    }
    std::vector<double> lengths = lengths_on(piece, from, to);
    if (std::ranges::equal(lengths, reach, std::ranges::less_equal{})) {
      return lengths;
    }
  }
  return lengths_on(surface, from, to);
}

}  // namespace sanatrix
