// States of a discrete body: steps, how far they may go, and what is measured on them.
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.hpp"
#include "fem/mesh_share.hpp"
#include "fem/session.hpp"
#include "mechanics/discrete_body.hpp"
#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

std::string DiscreteBody::worst_place() const {
  std::string place = "no cell";
  if (fem::rank() == worst_rank_ && worst_.cell >= 0) {
    const TetMesh& mesh = *body_.mesh;
    const std::size_t c = index(worst_.cell);
    const Vec3 corner = 1e3 * mesh.points[index(mesh.cells[c][0])];
    place = fmt::format("cell {} of region '{}' near ({:.1f}, {:.1f}, {:.1f}) mm",
                        body_.share != nullptr ? body_.share->cell()[c] : worst_.cell,
                        mesh.region_names[index(mesh.region[c])], corner[0], corner[1], corner[2]);
  }
  fem::broadcast(place, worst_rank_);
  return place;
}

State DiscreteBody::moved(const State& state, std::span<const double> d, double alpha) const {
  State next = state;
  for (std::size_t n = 0; n < node_count_; ++n) {
    const std::size_t first = fem::block * n;
    next.nodes[n] += alpha * Vec3{d[first], d[first + 1], d[first + 2]};
    if (n < next.pressure.size()) {
      next.pressure[n] += alpha * d[first + 3];
    }
  }
  return next;
}

double DiscreteBody::share_within(const State& state, std::span<const double> d,
                                  double kept) const {
  double share = 1.0;
  for (const auto& cell : body_.mesh->cells) {
    Mat3 edges{};
    Mat3 change{};
    const std::size_t first = index(cell[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t n = index(cell[k + 1]);
      edges[k] = state.nodes[n] - state.nodes[first];
      for (std::size_t i = 0; i < 3; ++i) {
        change[k][i] = d[fem::block * n + i] - d[fem::block * first + i];
      }
    }
    const double least = kept * determinant(edges);
    const auto volume = [&] {
      Mat3 moved = edges;
      for (std::size_t k = 0; k < 3; ++k) {
        moved[k] += share * change[k];
      }
      return determinant(moved);
    };
    while (share > 1e-3 && volume() < least) {
      share *= 0.9;
    }
  }
  return -fem::largest(-share);
}

double DiscreteBody::norm(std::span<const double> r) const {
  double mine = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double force = i % fem::block == 3 ? pressure_scale_ * r[i] : r[i];
    mine += force * force;
  }
  return std::sqrt(fem::sum(mine));
}

std::vector<double> DiscreteBody::jacobians(std::span<const Vec3> reference,
                                            std::span<const Vec3> deformed) const {
  const std::size_t cells = body_.mesh->cells.size();
  if (body_.element != Element::P2P1) {
    const std::vector<double> V = cell_volumes(*body_.mesh, reference);
    std::vector<double> J = cell_volumes(*body_.mesh, deformed);
    std::ranges::transform(J, V, J.begin(), std::divides<>());
    return J;
  }
  std::vector<double> J(cells, 0.0);
  for (std::size_t c = 0; c < cells; ++c) {
    for (const auto& q : tet_degree2()) {
      const TetBasis<10> basis(q.lambda);
      Mat3 X{};
      Mat3 x{};
      for (std::size_t a = 0; a < 10; ++a) {
        const std::size_t node =
            a < 4 ? index(body_.mesh->cells[c][a])
                  : body_.mesh->points.size() + index(edges_.cell_edges[c][a - 4]);
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t d = 0; d < 3; ++d) {
            X[i][d] += reference[node][i] * basis.derivative[a][d];
            x[i][d] += deformed[node][i] * basis.derivative[a][d];
          }
        }
      }
      J[c] += q.weight * determinant(x) / determinant(X);
    }
  }
  return J;
}

}  // namespace sanatrix::mechanics
