#include "mechanics/dead_loads.hpp"

#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

template <std::size_t Nodes>
void add_body_force(const Body& body, const fem::EdgeTable& edges, std::span<const Vec3> reference,
                    std::vector<Vec3>& force) {
  const TetMesh& mesh = *body.mesh;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    std::array<std::size_t, Nodes> node{};
    for (std::size_t a = 0; a < Nodes; ++a) {
      node[a] =
          a < 4 ? index(mesh.cells[c][a]) : mesh.points.size() + index(edges.cell_edges[c][a - 4]);
    }
    for (const auto& q : tet_degree5()) {
      const TetBasis<Nodes> basis(q.lambda);
      Vec3 X{};
      Mat3 jacobian{};
      for (std::size_t a = 0; a < Nodes; ++a) {
        X += basis.value[a] * reference[node[a]];
        for (std::size_t i = 0; i < 3; ++i) {
          jacobian[i] += reference[node[a]][i] * basis.derivative[a];
        }
      }
      const Vec3 b = q.weight * determinant(jacobian) / 6.0 * body.loads.body_force(X);
      for (std::size_t a = 0; a < Nodes; ++a) {
        force[node[a]] += basis.value[a] * b;
      }
    }
  }
}

template <std::size_t Nodes>
void add_traction(const Body& body, const fem::EdgeTable& edges, std::span<const Vec3> reference,
                  std::vector<Vec3>& force) {
  for (const BoundaryFace& face : body.loads.traction_faces) {
    const auto& v = face.vertex;
    std::array<std::size_t, Nodes> node{};
    for (std::size_t a = 0; a < Nodes; ++a) {
      node[a] = a < 3 ? index(v[a])
                      : body.mesh->points.size() + index(edges.find(v[a - 3], v[(a - 2) % 3]));
    }
    for (const auto& q : triangle_degree4()) {
      const TriangleBasis<Nodes> basis(q.lambda);
      Vec3 X{};
      Vec3 g1{};
      Vec3 g2{};
      for (std::size_t a = 0; a < Nodes; ++a) {
        X += basis.value[a] * reference[node[a]];
        g1 += basis.derivative[a][0] * reference[node[a]];
        g2 += basis.derivative[a][1] * reference[node[a]];
      }
      const Vec3 t = 0.5 * q.weight * norm(cross(g1, g2)) * body.loads.traction(X);
      for (std::size_t a = 0; a < Nodes; ++a) {
        force[node[a]] += basis.value[a] * t;
      }
    }
  }
}

}  // namespace

std::vector<Vec3> dead_forces(const Body& body, const fem::EdgeTable& edges,
                              std::span<const Vec3> reference_nodes) {
  std::vector<Vec3> force(reference_nodes.size(), Vec3{});
  const bool linear = body.element != Element::P2P1;
  if (body.loads.body_force) {
    (linear ? add_body_force<4> : add_body_force<10>)(body, edges, reference_nodes, force);
  }
  if (body.loads.traction) {
    (linear ? add_traction<3> : add_traction<6>)(body, edges, reference_nodes, force);
  }
  return force;
}

}  // namespace sanatrix::mechanics
