#include "mechanics/discrete_body.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include <mpi.h>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "fem/mesh_share.hpp"
#include "fem/session.hpp"
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

/// Indices of the cells in the order of their first rows: neighbours in the matrix are filled one
/// after another.
std::vector<std::size_t> by_place(std::span<const std::array<int, 4>> cells,
                                  const fem::Layout& layout) {
  std::vector<int> first;
  first.reserve(cells.size());
  for (const auto& cell : cells) {
    int row = layout.total;
    for (const int v : cell) {
      row = std::min(row, layout.global[index(v)]);
    }
    first.push_back(row);
  }
  std::vector<std::size_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return first[c]; });
  return order;
}

void check_body(const Body& body) {
  ensure(body.mesh != nullptr, "a body without a mesh");
  const std::size_t cells = body.mesh->cells.size();
  ensure(body.tissue.size() == cells, "{} cells but {} tissues", cells, body.tissue.size());
  ensure(body.fixed.size() == body.mesh->points.size(), "{} vertices but {} supports",
         body.mesh->points.size(), body.fixed.size());
  const bool holds = std::ranges::any_of(body.fixed, [](std::uint8_t f) { return f != 0; });
  require(fem::largest(holds ? 1.0 : 0.0) > 0.0,
          "nothing holds the body: no vertex is fixed - name a boundary under \"fixed\"");
}

/// A fresh wound resists shear a hundred times less than the tissue around it. Below this
/// integrity (for about a fortnight after surgery) factors have fill; the limit is not tuned.
constexpr double soft_integrity = 0.5;
/// For stable incomplete factors (docs/adr, 8) pressures have this share of minus a pressure mass
/// over mu, which is spectrally equivalent to their Schur complement, beside what is in the system:
/// next to nothing in Taylor-Hood.
constexpr double factored_mass_p1 = 0.05;
constexpr double factored_mass_p2 = 0.2;

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
  const std::vector<Vec3> positions = with_midpoints(mesh.points, edges_);
  layout_ = body_.share != nullptr ? body_.share->layout(edges_) : fem::make_layout(positions);
  hold_nodes();
  list_elements();
  std::optional<int> narrow;
  if (body_.element == Element::Smoothed) {
    narrow = elements_.size();
    list_domains();
  }
  system_ = std::make_unique<fem::SparseSystem>(layout_, elements_, fixed_, positions, narrow);
  system_->set_smoothed(body_.element == Element::P1P1 ? fem::Smoothed::System
                                                       : fem::Smoothed::Factored);
  list_parts();
}

/// A mid-edge node is held where both ends are; it has no pressure.
void DiscreteBody::hold_nodes() {
  fixed_.assign(body_.fixed.begin(), body_.fixed.end());
  if (body_.share != nullptr) {  // a support's face may lie on the owner's side only
    body_.share->fetch(fixed_);
  }
  for (const auto& [a, b] : edges_.edges) {
    fixed_.push_back(static_cast<std::uint8_t>((fixed_[index(a)] & fixed_[index(b)]) | 8));
  }
}

/// An element that several ranks evaluate is counted by the one that owns its first node.
bool DiscreteBody::is_mine(std::span<const int> nodes) const {
  return layout_.owns(nodes.front());
}

void DiscreteBody::list_elements() {
  const TetMesh& mesh = *body_.mesh;
  const auto vertices = static_cast<int>(mesh.points.size());
  std::vector<int> nodes;
  const auto add_if_touched = [&](std::vector<int>& mine, std::size_t e) {
    if (std::ranges::any_of(nodes, [&](int n) { return layout_.owns(n); })) {
      mine.push_back(static_cast<int>(e));
      elements_.add(nodes);
    }
  };
  for (const std::size_t c : by_place(mesh.cells, layout_)) {
    nodes.assign(mesh.cells[c].begin(), mesh.cells[c].end());
    if (body_.element == Element::P2P1) {
      for (const int e : edges_.cell_edges[c]) {
        nodes.push_back(vertices + e);
      }
    }
    add_if_touched(cells_, c);
  }
  for (std::size_t f = 0; f < body_.skin_faces.size(); ++f) {
    const auto& v = body_.skin_faces[f].vertex;
    nodes.assign(v.begin(), v.end());
    if (body_.element == Element::P2P1) {
      for (const int e : face_edges_[f]) {
        nodes.push_back(vertices + e);
      }
    }
    add_if_touched(faces_, f);
  }
}

void DiscreteBody::list_domains() {
  const auto& cells = body_.mesh->cells;
  smoothing_ = SmoothingDomains(cells, fem::make_edges(cells));
  std::vector<int> first;
  for (int d = 0; d < smoothing_.size(); ++d) {
    int row = layout_.total;
    bool mine = false;
    for (const int v : smoothing_.nodes(d)) {
      row = std::min(row, layout_.global[index(v)]);
      mine = mine || layout_.owns(v);
    }
    first.push_back(row);
    if (mine) {
      domains_.push_back(d);
    }
  }
  std::ranges::stable_sort(domains_, {}, [&](int d) { return first[index(d)]; });
  for (const int d : domains_) {
    elements_.add(smoothing_.nodes(d));
  }
}

/// Every thread evaluates all elements that touch its rows and writes nothing else: no barriers,
/// and sums that do not depend on the number of threads. The elements between two parts are
/// computed twice.
void DiscreteBody::list_parts() {
  parts_.resize(index(threads()));
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    Part& part = parts_[p];
    part.rows = system_->part(static_cast<int>(p), static_cast<int>(parts_.size()));
    for (int e = 0; e < elements_.size(); ++e) {
      if (std::ranges::any_of(elements_.of(e), [&](int node) {
            const int row = layout_.global[index(node)] - layout_.own_begin;
            return row >= part.rows.begin && row < part.rows.end;
          })) {
        part.elements.push_back(e);
      }
    }
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
  set_scales();
  system_->forget_factorisation();
  const bool soft_here = std::ranges::any_of(
      body_.tissue, [](const Tissue& t) { return t.integrity < soft_integrity; });
  soft_ = fem::largest(body_.share, soft_here ? 1.0 : 0.0) > 0.0;
  system_->set_fill(soft_ ? 1 : 0);
  set_pressure_diagonal();
  smoothing_.leave_out_soft(body_.tissue);
  if (body_.loads.any()) {
    begin_dead_loads();
  }
}

void DiscreteBody::begin_dead_loads() {
  require(unknown_ == Unknown::Deformed, "dead loads belong to forward problems only");
  const auto& prescribed = body_.loads.prescribed;
  ensure(prescribed.empty() || prescribed.size() == node_count_,
         "{} prescribed displacements for {} nodes", prescribed.size(), node_count_);
  const std::vector<Vec3> force = dead_forces(body_, edges_, known_);
  dead_force_.assign(fem::block * node_count_, 0.0);
  for (std::size_t n = 0; n < node_count_; ++n) {
    for (std::size_t i = 0; i < 3 && layout_.owns(static_cast<int>(n)); ++i) {
      dead_force_[fem::block * n + i] = (fixed_[n] >> i & 1) != 0 ? 0.0 : force[n][i];
    }
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
  for (std::size_t n = 0; n < node_count_; ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      if ((fixed_[n] >> i & 1) != 0) {
        state.nodes[n][i] = known_[n][i] + body_.loads.prescribed[n][i];
      }
    }
  }
}

/// Typical sizes of a force and of a pressure residual, from the whole body.
void DiscreteBody::set_scales() {
  std::array<double, 4> mine{};  // volume, its shear modulus, mass, own vertices
  const std::vector<double> volumes =
      cell_volumes(*body_.mesh, std::span(known_).first(body_.mesh->points.size()));
  for (const int c : cells_) {
    if (is_mine(body_.mesh->cells[index(c)])) {
      const Tissue& t = body_.tissue[index(c)];
      mine[0] += volumes[index(c)];
      mine[1] += volumes[index(c)] * 2.0 * (t.c1 + t.c2);
      mine[2] += volumes[index(c)] * t.density;
    }
  }
  for (std::size_t v = 0; v < body_.mesh->points.size(); ++v) {
    mine[3] += layout_.owns(static_cast<int>(v)) ? 1.0 : 0.0;
  }
  std::array<double, 4> all = mine;
  fem::sum_each(all);
  const double n = all[3];
  const double h = std::cbrt(all[0] / n);
  const double mu = all[1] / all[0];
  pressure_scale_ = mu / h;
  const double own = 1e-3 * mu * h * h * std::sqrt(n);
  load_scale_ = std::max(sanatrix::norm(gravity_) * all[2] / std::sqrt(n), own);
}

/// A share of -int q / mu dV at the vertices (complete for own ones), for the factors.
void DiscreteBody::set_pressure_diagonal() {
  pressure_diagonal_.assign(node_count_, 0.0);
  const double share = body_.element == Element::P2P1 ? factored_mass_p2 : factored_mass_p1;
  const std::vector<double> volumes =
      cell_volumes(*body_.mesh, std::span(known_).first(body_.mesh->points.size()));
  for (const int c : cells_) {
    const Tissue& t = body_.tissue[index(c)];
    for (const int v : body_.mesh->cells[index(c)]) {
      pressure_diagonal_[index(v)] -= share * 0.25 * volumes[index(c)] / (2.0 * (t.c1 + t.c2));
    }
  }
}

fem::LinearReport DiscreteBody::solve(std::span<const double> b, double relative_tolerance,
                                      std::vector<double>& x) {
  return system_->solve(b, relative_tolerance, x);
}

void DiscreteBody::forget_factorisation() {
  system_->forget_factorisation();
}

}  // namespace sanatrix::mechanics
