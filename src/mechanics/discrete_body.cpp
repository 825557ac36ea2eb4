#include "mechanics/discrete_body.hpp"

#include <algorithm>
#include <limits>

#include <mpi.h>

#include "core/error.hpp"
#include "mechanics/dead_loads.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/shape_functions.hpp"

namespace sanatrix::mechanics {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

std::vector<Vec3> with_midpoints(std::span<const Vec3> vertices, const fem::EdgeTable& edges) {
  std::vector<Vec3> nodes(vertices.begin(), vertices.end());
  for (const auto& [a, b] : edges.edges) {
    nodes.push_back(0.5 * (vertices[index(a)] + vertices[index(b)]));
  }
  return nodes;
}

void check_body(const Body& body) {
  ensure(body.mesh != nullptr, "a body without a mesh");
  const std::size_t cells = body.mesh->cells.size();
  ensure(body.tissue.size() == cells, "{} cells but {} tissues", cells, body.tissue.size());
  ensure(body.fixed.size() == body.mesh->points.size(), "{} vertices but {} supports",
         body.mesh->points.size(), body.fixed.size());
  require(std::ranges::any_of(body.fixed, [](std::uint8_t f) { return f != 0; }),
          "nothing holds the body: no vertex is fixed - name a boundary under \"fixed\"");
}

}  // namespace

DiscreteBody::DiscreteBody(const Body& body) : body_(body) {
  check_body(body_);
  const TetMesh& mesh = *body_.mesh;
  node_count_ = mesh.points.size();
  if (body_.element == Element::P2P1) {
    edges_ = fem::make_edges(mesh.cells);
    node_count_ += edges_.edges.size();
    for (const auto& face : body_.skin_faces) {
      const auto& v = face.vertex;
      face_edges_.push_back(
          {edges_.find(v[0], v[1]), edges_.find(v[1], v[2]), edges_.find(v[2], v[0])});
    }
  }
  std::vector<int> node_dofs(node_count_, 3);
  std::fill_n(node_dofs.begin(), mesh.points.size(), 4);
  layout_ = fem::make_layout(with_midpoints(mesh.points, edges_), std::move(node_dofs));
  is_pressure_.assign(index(layout_.dofs), false);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    is_pressure_[index(layout_.first_dof[v] + 3)] = true;
  }
  for (std::size_t n = 0; n < node_count_; ++n) {
    std::uint8_t held = 0;
    if (n < mesh.points.size()) {
      held = body_.fixed[n];
    } else {  // a mid-edge node is held where both ends are
      const auto& [a, b] = edges_.edges[n - mesh.points.size()];
      held = body_.fixed[index(a)] & body_.fixed[index(b)];
    }
    for (int i = 0; i < 3; ++i) {
      if ((held >> i & 1) != 0) {
        fixed_dofs_.push_back(layout_.first_dof[n] + i);
      }
    }
  }
  list_elements();
}

int DiscreteBody::node_of_cell(std::size_t cell, std::size_t local) const {
  return local < 4
             ? body_.mesh->cells[cell][local]
             : static_cast<int>(body_.mesh->points.size()) + edges_.cell_edges[cell][local - 4];
}

int DiscreteBody::node_of_face(std::size_t face, std::size_t local) const {
  return local < 3 ? body_.skin_faces[face].vertex[local]
                   : static_cast<int>(body_.mesh->points.size()) + face_edges_[face][local - 3];
}

/// An element belongs to the rank that owns the smallest of its unknowns.
void DiscreteBody::list_elements() {
  std::vector<bool> held(index(layout_.dofs), false);
  for (const int d : fixed_dofs_) {
    held[index(d)] = true;
  }
  const bool quadratic = body_.element == Element::P2P1;
  std::vector<int> dofs;
  const auto add_if_mine = [&](std::vector<int>& mine, std::size_t e) {
    if (layout_.owns(*std::ranges::min_element(dofs))) {
      for (int& d : dofs) {
        d = held[index(d)] ? -1 : d;
      }
      mine.push_back(static_cast<int>(e));
      elements_.add(dofs);
    }
  };
  for (std::size_t c = 0; c < body_.mesh->cells.size(); ++c) {
    dofs.clear();
    for (std::size_t a = 0; a < (quadratic ? 10U : 4U); ++a) {
      const int first = layout_.first_dof[index(node_of_cell(c, a))];
      dofs.insert(dofs.end(), {first, first + 1, first + 2});
    }
    for (const int v : body_.mesh->cells[c]) {
      dofs.push_back(layout_.first_dof[index(v)] + 3);
    }
    add_if_mine(cells_, c);
  }
  for (std::size_t f = 0; f < body_.skin_faces.size(); ++f) {
    dofs.clear();
    for (std::size_t a = 0; a < (quadratic ? 6U : 3U); ++a) {
      const int first = layout_.first_dof[index(node_of_face(f, a))];
      dofs.insert(dofs.end(), {first, first + 1, first + 2});
    }
    add_if_mine(faces_, f);
  }
}

void DiscreteBody::set_tissue(std::span<const Tissue> tissue) {
  ensure(tissue.size() == body_.tissue.size(), "{} cells but {} tissues", body_.tissue.size(),
         tissue.size());
  body_.tissue.assign(tissue.begin(), tissue.end());
}

void DiscreteBody::begin(Unknown unknown, std::span<const Vec3> known, const Vec3& gravity) {
  ensure(known.size() == node_count_, "{} nodes expected, {} given", node_count_, known.size());
  unknown_ = unknown;
  known_.assign(known.begin(), known.end());
  gravity_ = gravity;
  double volume_all = 0.0;
  double shear = 0.0;
  double mass = 0.0;
  const std::vector<double> volumes =
      cell_volumes(*body_.mesh, std::span(known_).first(body_.mesh->points.size()));
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    const Tissue& t = body_.tissue[c];
    volume_all += volumes[c];
    shear += volumes[c] * 2.0 * (t.c1 + t.c2);
    mass += volumes[c] * t.density;
  }
  const double n = static_cast<double>(body_.mesh->points.size());
  const double h = std::cbrt(volume_all / n);
  const double mu = shear / volume_all;
  pressure_scale_ = mu / h;
  const double own = 1e-3 * mu * h * h * std::sqrt(n);
  load_scale_ = std::max(sanatrix::norm(gravity_) * mass / std::sqrt(n), own);
  if (body_.loads.any()) {
    begin_dead_loads();
  }
}

void DiscreteBody::begin_dead_loads() {
  require(unknown_ == Unknown::Deformed, "dead loads belong to forward problems only");
  const auto& prescribed = body_.loads.prescribed;
  ensure(prescribed.empty() || prescribed.size() == node_count_,
         "{} prescribed displacements for {} nodes", prescribed.size(), node_count_);
  dead_force_.assign(index(layout_.dofs), 0.0);
  const std::vector<Vec3> force = dead_forces(body_, edges_, known_);
  for (std::size_t n = 0; n < node_count_; ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      dead_force_[index(layout_.first_dof[n]) + i] = force[n][i];
    }
  }
  for (const int d : fixed_dofs_) {
    dead_force_[index(d)] = 0.0;
  }
  load_scale_ = std::max(load_scale_, norm(dead_force_));
}

void DiscreteBody::subtract_dead_forces(std::vector<double>& r) const {
  for (std::size_t i = 0; i < dead_force_.size(); ++i) {
    r[i] -= dead_force_[i];
  }
}

void DiscreteBody::place_supports(State& state) const {
  if (body_.loads.prescribed.empty()) {
    return;
  }
  std::vector<bool> held(index(layout_.dofs), false);
  for (const int d : fixed_dofs_) {
    held[index(d)] = true;
  }
  for (std::size_t n = 0; n < node_count_; ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (held[index(layout_.first_dof[n]) + i]) {
        state.nodes[n][i] = known_[n][i] + body_.loads.prescribed[n][i];
      }
    }
  }
}

template <std::size_t CellNodes, std::size_t FaceNodes>
bool DiscreteBody::evaluate(const State& state, bool with_matrix, bool at_rest) {
  fem::SparseSystem& sparse = system();
  const int n_cells = static_cast<int>(cells_.size());
  const int n_faces = static_cast<int>(faces_.size());
  std::vector<double> min_J(index(n_cells));
#pragma omp parallel for schedule(static)
  for (int e = 0; e < n_cells; ++e) {
    const std::size_t c = index(cells_[index(e)]);
    std::array<Vec3, CellNodes> known;
    std::array<Vec3, CellNodes> sought;
    std::array<double, 4> p{};
    for (std::size_t a = 0; a < CellNodes; ++a) {
      const std::size_t node = index(node_of_cell(c, a));
      known[a] = known_[node];
      sought[a] = state.nodes[node];
    }
    for (std::size_t a = 0; a < 4; ++a) {
      p[a] = state.pressure[index(body_.mesh->cells[c][a])];
    }
    const CellInput in{unknown_, known, sought, p, body_.tissue[c], gravity_};
    min_J[index(e)] = cell_element<CellNodes>(
        in, sparse.vector_block(e), with_matrix ? sparse.matrix_block(e) : std::span<double>{});
  }
#pragma omp parallel for schedule(static)
  for (int f = 0; f < n_faces; ++f) {
    const std::size_t s = index(faces_[index(f)]);
    std::array<Vec3, FaceNodes> known;
    std::array<Vec3, FaceNodes> sought;
    for (std::size_t a = 0; a < FaceNodes; ++a) {
      const std::size_t node = index(node_of_face(s, a));
      known[a] = known_[node];
      sought[a] = state.nodes[node];
    }
    const FaceInput in{unknown_, known,  sought, body_.skins[index(body_.skin_faces[s].law)],
                       gravity_, at_rest};
    face_element<FaceNodes>(in, sparse.vector_block(n_cells + f),
                            with_matrix ? sparse.matrix_block(n_cells + f) : std::span<double>{});
  }
  struct {
    double J;
    int cell;
  } mine{std::numeric_limits<double>::infinity(), -1}, all{};
  for (int e = 0; e < n_cells; ++e) {
    if (min_J[index(e)] < mine.J || std::isnan(min_J[index(e)])) {
      mine = {std::isnan(min_J[index(e)]) ? -1.0 : min_J[index(e)], cells_[index(e)]};
    }
  }
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MINLOC, MPI_COMM_WORLD);
  worst_ = {all.J, all.cell};
  return worst_.J > 0.0;
}

bool DiscreteBody::run(const State& state, bool with_matrix, bool at_rest) {
  return body_.element == Element::P1P1 ? evaluate<4, 3>(state, with_matrix, at_rest)
                                        : evaluate<10, 6>(state, with_matrix, at_rest);
}

bool DiscreteBody::residual(const State& state, std::vector<double>& r) {
  if (!run(state, false, false)) {
    return false;
  }
  system().assemble_vector(r);
  subtract_dead_forces(r);
  return true;
}

bool DiscreteBody::residual_and_matrix(const State& state, std::vector<double>& r, bool at_rest) {
  if (!run(state, true, at_rest)) {
    return false;
  }
  system().assemble_vector(r);
  subtract_dead_forces(r);
  system().assemble_matrix();
  return true;
}

fem::SparseSystem& DiscreteBody::system() {
  auto& wanted = unknown_ == Unknown::Deformed ? forward_ : inverse_;
  if (!wanted) {
    wanted = std::make_unique<fem::SparseSystem>(
        layout_, elements_, fixed_dofs_, is_pressure_,
        unknown_ == Unknown::Deformed ? fem::Symmetry::Symmetric : fem::Symmetry::General);
  }
  return *wanted;
}

fem::LinearReport DiscreteBody::solve(std::span<const double> b, double relative_tolerance,
                                      std::vector<double>& x) {
  return system().solve(b, relative_tolerance, x);
}

void DiscreteBody::forget_factorisation() {
  system().forget_factorisation();
}

State DiscreteBody::moved(const State& state, std::span<const double> d, double alpha) const {
  State next = state;
  for (std::size_t n = 0; n < node_count_; ++n) {
    const std::size_t first = index(layout_.first_dof[n]);
    next.nodes[n] += alpha * Vec3{d[first], d[first + 1], d[first + 2]};
    if (n < next.pressure.size()) {
      next.pressure[n] += alpha * d[first + 3];
    }
  }
  return next;
}

double DiscreteBody::norm(std::span<const double> r) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double force = is_pressure_[i] ? pressure_scale_ * r[i] : r[i];
    sum += force * force;
  }
  return std::sqrt(sum);
}

std::vector<double> DiscreteBody::jacobians(std::span<const Vec3> reference,
                                            std::span<const Vec3> deformed) const {
  const std::size_t cells = body_.mesh->cells.size();
  if (body_.element == Element::P1P1) {
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
        const std::size_t node = index(node_of_cell(c, a));
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
