// Manufactured solutions of mechanics: a smooth large deformation of a block is prescribed, its
// body force and traction follow from the law, and the solver has to find it again.
#include <numbers>

#include <fmt/format.h>

#include "core/error.hpp"
#include "geometry/structured_mesh.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/jet.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/problem.hpp"
#include "mechanics/shape_functions.hpp"
#include "outcome/discretisation.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Element;
using Jet = mechanics::Jet<3>;

/// Soft and nearly incompressible: kappa/mu = 500, as the hemisphere benchmark.
const mechanics::Tissue tissue{150.0, 100.0, 2.5e5, 1000.0, 1.0, 0.0};
constexpr double edge = 0.04;  // of the block [m]

Jet sine(const Jet& x) {
  return x.chain(std::sin(x.value), std::cos(x.value), -std::sin(x.value));
}

/// Two shears, each a function of what it does not move (det = 1), after a small change of volume
/// of 0.1 % that brings a pressure of half the shear modulus.
std::array<Jet, 3> motion(const Vec3& X) {
  constexpr double k = std::numbers::pi / edge;
  std::array<Jet, 3> x{Jet::input(0, X[0]), Jet::input(1, X[1]), Jet::input(2, X[2])};
  x[2] = x[2] + (1e-3 * edge / std::numbers::pi) * sine(k * x[2] + 0.4);
  x[0] = x[0] + (0.16 * edge) * sine(k * x[1]) * sine(0.5 * k * x[2] + 0.3);
  x[1] = x[1] + (0.12 * edge) * sine(0.8 * k * x[0] + 0.2);
  return x;
}

struct Exact {
  Vec3 x;
  double pressure;  // kappa (J - 1)
  Mat3 P;
  Vec3 body_force;  // -Div P
};

Exact exact_at(const Vec3& X) {
  const auto x = motion(X);
  const Mat3 F{x[0].gradient, x[1].gradient, x[2].gradient};
  const double p = tissue.kappa * (determinant(F) - 1.0);
  const auto at = mechanics::stress(tissue, F, p);
  mechanics::Tangent9 A{};
  mechanics::stress_tangent(tissue, F, p, tissue.kappa, at, A);
  Vec3 b{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t J = 0; J < 3; ++J) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t L = 0; L < 3; ++L) {
          b[i] -= A[3 * i + J][3 * k + L] * x[k].hessian[L][J];
        }
      }
    }
  }
  return {{x[0].value, x[1].value, x[2].value}, p, at.P, b};
}

/// The block, a little distorted inside so that nothing cancels by symmetry; x1 carries traction,
/// all other faces are held.
TetMesh distorted_block(int n) {
  TetMesh mesh = block({edge, edge, edge}, {n, n, n});
  for (Vec3& p : mesh.points) {
    constexpr double k = std::numbers::pi / edge;
    const double bump = 0.06 * edge * std::sin(k * p[0]) * std::sin(k * p[1]) * std::sin(k * p[2]);
    p += bump * Vec3{1.0, -0.7, 0.5};
  }
  return mesh;
}

mechanics::Body make_body(const TetMesh& mesh, Element element) {
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element;
  body.tissue.assign(mesh.cells.size(), tissue);
  body.fixed.assign(mesh.points.size(), 0);
  for (const BoundaryFace& face : mesh.faces) {
    if (mesh.boundary_names[static_cast<std::size_t>(face.name)] == "x1") {
      body.loads.traction_faces.push_back(face);
      continue;
    }
    for (const int v : face.vertex) {
      body.fixed[static_cast<std::size_t>(v)] = 7;
    }
  }
  body.loads.body_force = [](const Vec3& X) {
    return exact_at(X).body_force;
  };
  body.loads.traction = [](const Vec3& X) {
    return exact_at(X).P * Vec3{1.0, 0.0, 0.0};
  };
  return body;
}

struct Errors {
  double h;                       // [m]
  double displacement, gradient;  // L2 of u and of F, relative
  double pressure;                // L2, relative
  double estimated;               // relative error of the displacement, from the solution alone
};

/// L2 norms with a rule of degree 5, so that the quadrature does not hide the error.
template <std::size_t Nodes>
Errors integrate_errors(const TetMesh& mesh,
                        const std::vector<std::array<std::size_t, Nodes>>& node,
                        std::span<const Vec3> rest, const mechanics::Shape& shape) {
  const double share = Nodes == 4 ? 1.0 - mechanics::own_bulk_modulus(tissue) / tissue.kappa : 1.0;
  std::array<double, 3> error{};
  std::array<double, 3> size{};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const auto& q : mechanics::tet_degree5()) {
      const mechanics::TetBasis<Nodes> basis(q.lambda);
      Vec3 X{};
      Vec3 x{};
      Mat3 dX{};
      Mat3 dx{};
      double p = 0.0;
      for (std::size_t a = 0; a < Nodes; ++a) {
        X += basis.value[a] * rest[node[c][a]];
        x += basis.value[a] * shape.nodes[node[c][a]];
        for (std::size_t i = 0; i < 3; ++i) {
          dX[i] += rest[node[c][a]][i] * basis.derivative[a];
          dx[i] += shape.nodes[node[c][a]][i] * basis.derivative[a];
        }
      }
      for (std::size_t v = 0; v < 4; ++v) {
        p += q.lambda[v] * shape.pressure[node[c][v]];
      }
      const Exact exact = exact_at(X);
      const auto jets = motion(X);
      const Mat3 F = dx * inverse(dX);
      const double w = q.weight * determinant(dX);
      for (std::size_t i = 0; i < 3; ++i) {
        error[1] += w * dot(F[i] - jets[i].gradient, F[i] - jets[i].gradient);
        size[1] += w * dot(jets[i].gradient - identity3[i], jets[i].gradient - identity3[i]);
      }
      error[0] += w * dot(x - exact.x, x - exact.x);
      size[0] += w * dot(exact.x - X, exact.x - X);
      error[2] += w * std::pow(p - share * exact.pressure, 2);
      size[2] += w * std::pow(exact.pressure, 2);
    }
  }
  return {0.0, std::sqrt(error[0] / size[0]), std::sqrt(error[1] / size[1]),
          std::sqrt(error[2] / size[2]), 0.0};
}

template <std::size_t Nodes>
std::vector<std::array<std::size_t, Nodes>> cell_nodes(const TetMesh& mesh) {
  std::vector<std::array<std::size_t, Nodes>> nodes;
  const fem::EdgeTable edges = Nodes == 10 ? fem::make_edges(mesh.cells) : fem::EdgeTable{};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    nodes.emplace_back();
    for (std::size_t a = 0; a < Nodes; ++a) {
      nodes[c][a] = a < 4
                        ? static_cast<std::size_t>(mesh.cells[c][a])
                        : mesh.points.size() + static_cast<std::size_t>(edges.cell_edges[c][a - 4]);
    }
  }
  return nodes;
}

Errors solve(int n, Element element, const Context& ctx) {
  const TetMesh mesh = distorted_block(n);
  mechanics::Body body = make_body(mesh, element);
  const std::vector<Vec3> rest = mechanics::Solver(body).straight_nodes(mesh.points);
  mechanics::Shape guess;  // a start near the solution: its values at the nodes
  for (const Vec3& X : rest) {
    guess.nodes.push_back(exact_at(X).x);
    body.loads.prescribed.push_back(guess.nodes.back() - X);
  }
  for (const Vec3& X : mesh.points) {
    guess.pressure.push_back(exact_at(X).pressure);
  }
  mechanics::Solver solver(body);
  const mechanics::Shape shape = solver.forward(rest, {}, &guess, ctx);
  Errors e = element != Element::P2P1
                 ? integrate_errors<4>(mesh, cell_nodes<4>(mesh), rest, shape)
                 : integrate_errors<10>(mesh, cell_nodes<10>(mesh), rest, shape);
  e.h = edge / n;
  std::vector<Vec3> moved(mesh.points.size());
  for (std::size_t v = 0; v < moved.size(); ++v) {
    moved[v] = shape.nodes[v] - mesh.points[v];
  }
  e.estimated = outcome::relative_displacement_error(mesh, mesh.points, moved,
                                                     std::vector<bool>(mesh.cells.size(), true));
  return e;
}

struct Quantity {
  std::string name;
  double Errors::*value;
  double order;    // of theory
  double highest;  // of a smooth solution
};

Findings convergence(Element element, const std::vector<int>& meshes,
                     const std::vector<Quantity>& quantities, const Context& ctx) {
  std::vector<Errors> runs;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const double done = static_cast<double>(i) / static_cast<double>(meshes.size());
    runs.push_back(solve(meshes[i], element, ctx.part(done, done + 0.2)));
  }
  Findings found;
  std::vector<double> h;
  Table table{"Relative L2 errors", {"boxes per edge", "h [mm]"}, {}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    h.push_back(1e3 * runs[i].h);
    table.rows.push_back({fmt::format("{}", meshes[i]), fmt::format("{:.4g}", h.back())});
  }
  Plot plot{"", "h [mm]", "relative L2 error", {}, true, true};
  for (const Quantity& q : quantities) {
    std::vector<double> error;
    for (const Errors& run : runs) {
      error.push_back(run.*q.value);
    }
    const std::vector<double> orders = observed_orders(h, error);
    table.header.insert(table.header.end(), {q.name, "order"});
    for (std::size_t i = 0; i < runs.size(); ++i) {
      table.rows[i].push_back(fmt::format("{:.3e}", error[i]));
      table.rows[i].push_back(i == 0 ? "" : fmt::format("{:.2f}", orders[i - 1]));
    }
    plot.curves.push_back({q.name, h, error});
    found.checks.push_back(within("order of " + q.name + ", two finest meshes", q.order - 0.2,
                                  q.highest + 0.2, orders.back(), "",
                                  q.highest > q.order
                                      ? "theory promises the reference; the error passed on by the "
                                        "displacement decays one order faster"
                                      : "theory"));
    found.checks.back().reference = q.order;
  }
  found.tables.push_back(std::move(table));
  found.plots.push_back(std::move(plot));
  return found;
}

/// The estimate that `outcome.json` carries, where the true error is known.
Findings estimator(const Context& ctx) {
  Findings found;
  Table table{"", {"boxes per edge", "true relative error", "estimated", "ratio"}, {}};
  for (const int n : {4, 8, 12}) {
    const Errors e = solve(n, Element::P1P1, ctx);
    const double ratio = e.estimated / e.displacement;
    table.rows.push_back({fmt::format("{}", n), fmt::format("{:.3e}", e.displacement),
                          fmt::format("{:.3e}", e.estimated), fmt::format("{:.2f}", ratio)});
    found.checks.push_back(within(fmt::format("estimated / true error, {} boxes per edge", n), 0.5,
                                  2.0, ratio, "", "an estimate of the size, not a bound"));
  }
  found.tables.push_back(std::move(table));
  return found;
}

constexpr auto about =
    "A block of 40 mm takes a smooth deformation with shears of up to one half "
    "(amplitude 0.16 pi); the body force and one face's traction are computed from the law by "
    "exact derivatives, "
    "the other faces are held at their exact places; kappa/mu = 500, pressures of half mu. "
    "Errors of displacement, deformation gradient and pressure on distorted meshes. ";

}  // namespace

void add_mechanics_mms(std::vector<Case>& cases) {
  const std::vector<Quantity> linear{{"displacement", &Errors::displacement, 2.0, 2.0},
                                     {"deformation gradient", &Errors::gradient, 1.0, 1.0},
                                     {"pressure", &Errors::pressure, 1.0, 2.0}};
  const std::vector<Quantity> quadratic{{"displacement", &Errors::displacement, 3.0, 3.0},
                                        {"deformation gradient", &Errors::gradient, 2.0, 2.0},
                                        {"pressure", &Errors::pressure, 2.0, 3.0}};
  cases.push_back(
      {"mms-p1p1", "Manufactured solution, P1/P1", Chapter::CodeVerification, Cost::Fast,
       std::string(about) + "P1/P1 with pressure projection and the cells' own share of the bulk "
                            "modulus, as shipped; theory: orders 2, 1 and at least 1 "
                            "(doi:10.1137/S0036142905444482).",
       [=](const Context& ctx) {
         return convergence(Element::P1P1, {4, 8, 12, 16}, linear, ctx);
       }});
  cases.push_back({"mms-smoothed", "Manufactured solution, smoothed P1/P1",
                   Chapter::CodeVerification, Cost::Fast,
                   std::string(about) + "P1/P1 with strains averaged around edges; the orders of "
                                        "P1/P1 (doi:10.1002/nme.4472).",
                   [=](const Context& ctx) {
                     return convergence(Element::Smoothed, {4, 8, 12, 16}, linear, ctx);
                   }});
  cases.push_back({"mms-p2p1", "Manufactured solution, P2/P1", Chapter::CodeVerification,
                   Cost::Fast, std::string(about) + "Taylor-Hood; theory: orders 3, 2 and 2.",
                   [=](const Context& ctx) {
                     return convergence(Element::P2P1, {4, 6, 8, 12}, quadratic, ctx);
                   }});
  cases.push_back({"error-estimate", "The discretisation error in outcome.json",
                   Chapter::CalculationVerification, Cost::Fast,
                   "The error that is estimated from a solution alone (recovered gradients, "
                   "docs/theory/discretisation-error.md) against the true one of the manufactured "
                   "solution, P1/P1.",
                   estimator});
}

}  // namespace sanatrix::verification
