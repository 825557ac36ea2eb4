// Residual and matrix of a discrete body: cells, skin faces and smoothing domains, in threads.
#include <algorithm>
#include <limits>

#include <mpi.h>

#include "core/parallel.hpp"
#include "fem/session.hpp"
#include "mechanics/discrete_body.hpp"

namespace sanatrix::mechanics {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Incomplete factors are made of a stiffer body, which keeps them stable on fine meshes
/// (docs/adr, 8): no cell has less than this integrity.
constexpr double factored_integrity = 0.05;

}  // namespace

/// Vector and matrix of one element.
struct DiscreteBody::Buffer {
  std::vector<double> vector, matrix;
  Buffer(std::size_t size, bool with_matrix)
      : vector(size), matrix(with_matrix ? size * size : 0) {}
};

template <std::size_t Nodes>
double DiscreteBody::compute_cell(int e, const State& state, const Tissue& tissue, double share,
                                  Buffer& to) const {
  const auto nodes = elements_.of(e);
  std::array<Vec3, Nodes> known;
  std::array<Vec3, Nodes> sought;
  std::array<double, 4> p{};
  for (std::size_t a = 0; a < Nodes; ++a) {
    known[a] = known_[index(nodes[a])];
    sought[a] = state.nodes[index(nodes[a])];
  }
  for (std::size_t a = 0; a < 4; ++a) {
    p[a] = state.pressure[index(nodes[a])];
  }
  return cell_element<Nodes>({unknown_, known, sought, p, tissue, gravity_, share}, to.vector,
                             to.matrix);
}

/// What the factors have beside the system: of a soft cell the difference to a stiffer one; in
/// smoothed elements all of the linear cell, which is close to them and has fewer neighbours.
template <std::size_t Nodes>
void DiscreteBody::add_for_factors(int e, const State& state, Tissue tissue,
                                   const Buffer& in_system, Buffer& stiff, fem::RowPart rows) {
  const bool smoothed = body_.element == Element::Smoothed;
  if (tissue.integrity >= factored_integrity && !smoothed) {
    return;
  }
  tissue.integrity = std::max(tissue.integrity, factored_integrity);
  compute_cell<Nodes>(e, state, tissue, 1.0, stiff);
  if (!smoothed) {
    std::ranges::transform(stiff.matrix, in_system.matrix, stiff.matrix.begin(), std::minus<>());
  }
  system_->add_for_factors(e, 4, stiff.matrix, rows);
}

/// Computes and adds one smoothing domain. Its det F, infinite where it is empty.
double DiscreteBody::add_domain(int e, const State& state, Buffer& to, fem::RowPart rows) {
  const int domain = domains_[index(e) - cells_.size() - faces_.size()];
  const auto nodes = smoothing_.nodes(domain);
  const auto inside = smoothing_.inside(domain);
  std::array<Vec3, most_domain_nodes> known;
  std::array<Vec3, most_domain_nodes> sought;
  std::array<double, most_domain_nodes> p;
  std::array<DomainCell, most_domain_nodes> cells;
  const std::size_t n = nodes.size();
  for (std::size_t a = 0; a < n; ++a) {
    known[a] = known_[index(nodes[a])];
    sought[a] = state.nodes[index(nodes[a])];
    p[a] = state.pressure[index(nodes[a])];
  }
  std::size_t count = 0;
  for (std::size_t c = 0; c < inside.size(); ++c) {
    if (inside[c] != 0) {
      cells[count++] = {smoothing_.corners(domain)[c],
                        &body_.tissue[index(smoothing_.cells(domain)[c])]};
    }
  }
  if (count == 0) {
    return std::numeric_limits<double>::infinity();
  }
  const auto vector = std::span(to.vector).first(4 * n);
  const auto matrix = std::span(to.matrix).first(to.matrix.empty() ? 0 : 16 * n * n);
  const double J = domain_element({unknown_, std::span(known).first(n), std::span(sought).first(n),
                                   std::span(p).first(n), std::span(cells).first(count)},
                                  vector, matrix);
  if (J > 0.0) {
    system_->add_blocks(e, vector, matrix, rows);
  }
  return J;
}

template <std::size_t Nodes>
void DiscreteBody::compute_face(int f, const State& state, bool at_rest, Buffer& to) const {
  const auto nodes = elements_.of(static_cast<int>(cells_.size()) + f);
  std::array<Vec3, Nodes> known;
  std::array<Vec3, Nodes> sought;
  for (std::size_t a = 0; a < Nodes; ++a) {
    known[a] = known_[index(nodes[a])];
    sought[a] = state.nodes[index(nodes[a])];
  }
  const Skin& skin = body_.skins[index(body_.skin_faces[index(faces_[index(f)])].law)];
  face_element<Nodes>({unknown_, known, sought, skin, gravity_, at_rest}, to.vector, to.matrix);
}

template <std::size_t CellNodes, std::size_t FaceNodes>
Worst DiscreteBody::evaluate_part(const Part& part, const State& state, bool with_matrix,
                                  bool at_rest) {
  const auto cells = static_cast<int>(cells_.size());
  const auto faces = cells + static_cast<int>(faces_.size());
  const bool smoothed = body_.element == Element::Smoothed;
  Worst worst{std::numeric_limits<double>::infinity(), -1};
  const auto note = [&](double J, int cell) {
    if (!(J >= worst.J)) {
      worst = {std::isnan(J) ? -1.0 : J, cell};
    }
  };
  Buffer cell(3 * CellNodes + 4, with_matrix);
  Buffer stiff(3 * CellNodes + 4, with_matrix);
  Buffer face(3 * FaceNodes, with_matrix);
  Buffer domain(smoothed ? 4 * most_domain_nodes : 0, with_matrix);
  for (const int e : part.elements) {
    if (e < cells) {
      const int c = cells_[index(e)];
      const Tissue& tissue = body_.tissue[index(c)];
      const double share = smoothed ? smoothing_.left_out(c) : 1.0;
      note(compute_cell<CellNodes>(e, state, tissue, share, cell), c);
      system_->add(e, 4, cell.vector, cell.matrix, part.rows);
      if (with_matrix) {
        add_for_factors<CellNodes>(e, state, tissue, cell, stiff, part.rows);
      }
    } else if (e < faces) {
      compute_face<FaceNodes>(e - cells, state, at_rest, face);
      system_->add(e, 0, face.vector, face.matrix, part.rows);
      if (with_matrix && smoothed) {
        system_->add_for_factors(e, 0, face.matrix, part.rows);
      }
    } else {
      const double J = add_domain(e, state, domain, part.rows);
      note(J, smoothing_.cells(domains_[index(e - faces)]).front());
    }
  }
  return worst;
}

template <std::size_t CellNodes, std::size_t FaceNodes>
bool DiscreteBody::evaluate(const State& state, bool with_matrix, bool at_rest) {
  system_->clear(with_matrix);
  std::vector<Worst> worst(parts_.size());
  side_by_side(static_cast<int>(parts_.size()), [&](int p) {
    worst[index(p)] =
        evaluate_part<CellNodes, FaceNodes>(parts_[index(p)], state, with_matrix, at_rest);
  });
  worst_ = *std::ranges::min_element(worst, {}, &Worst::J);
  const struct {
    double J;
    int rank;
  } mine{worst_.J, fem::rank()};
  auto all = mine;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MINLOC, MPI_COMM_WORLD);
  worst_.J = all.J;
  worst_rank_ = all.rank;
  return worst_.J > 0.0;
}

bool DiscreteBody::run(const State& state, bool with_matrix, bool at_rest) {
  return body_.element == Element::P2P1 ? evaluate<10, 6>(state, with_matrix, at_rest)
                                        : evaluate<4, 3>(state, with_matrix, at_rest);
}

bool DiscreteBody::residual(const State& state, std::vector<double>& r) {
  if (!run(state, false, false)) {
    return false;
  }
  r = system_->vector();
  subtract_dead_forces(r);
  return true;
}

bool DiscreteBody::residual_and_matrix(const State& state, std::vector<double>& r, bool at_rest) {
  if (!run(state, true, at_rest)) {
    return false;
  }
  r = system_->vector();
  subtract_dead_forces(r);
  system_->add_for_factors(pressure_diagonal_);
  system_->finish_matrix();
  return true;
}

}  // namespace sanatrix::mechanics
