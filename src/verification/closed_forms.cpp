// Closed forms of mechanics: thick walls (VALIDATION.md C6), the contracting wound (C5) and the
// hanging column (C10).
#include <cmath>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/problem.hpp"
#include "recovery/wound_shape.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Body;
using mechanics::Element;
using mechanics::Shape;
using mechanics::Solver;
using mechanics::Tissue;

const Tissue c100{100.0, 100.0, 5e5, 1000.0, 1.0, 0.0};
constexpr double inner_radius = 0.010, outer_radius = 0.020;

double integrate(const std::function<double(double)>& f, double a, double b) {
  double sum = 0.0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    sum += f(a + (b - a) * (i + 0.5) / n) * (b - a) / n;
  }
  return sum;
}

/// Cauchy stress difference sigma_t - sigma_r for principal stretches, from the shipped law.
double hoop_minus_radial(double radial, double hoop, double third) {
  const Mat3 F{{{radial, 0, 0}, {0, hoop, 0}, {0, 0, third}}};
  const mechanics::StressPoint s = mechanics::stress(c100, F, 0.0);
  return s.P[1][1] * hoop - s.P[0][0] * radial;
}

enum class Wall { Sphere, Cylinder };
struct WallPoint {
  double stretch, sphere, cylinder;  // of the inner radius; pressures [Pa]
};
constexpr std::array<WallPoint, 5> wall_table{{{0.9, -165.233, -69.351},
                                               {1.1, 121.366, 52.625},
                                               {1.25, 252.622, 110.285},
                                               {1.5, 394.167, 171.291},
                                               {2.0, 549.674, 229.621}}};

/// P = int k (sigma_t - sigma_r)/r dr, k = 2 sphere, 1 cylinder.
double wall_pressure(Wall wall, double stretch) {
  const double A = inner_radius;
  return integrate(
      [&](double R) {
        if (wall == Wall::Sphere) {
          const double r = std::cbrt(R * R * R + A * A * A * (stretch * stretch * stretch - 1.0));
          const double l = r / R;
          return 2.0 * hoop_minus_radial(1.0 / (l * l), l, l) / r * (R * R) / (r * r);
        }
        const double r = std::sqrt(R * R + A * A * (stretch * stretch - 1.0));
        const double l = r / R;
        return hoop_minus_radial(1.0 / l, l, 1.0) / r * R / r;
      },
      A, outer_radius);
}

Findings wall_law(const Context&) {
  Findings found;
  for (const WallPoint& row : wall_table) {
    found.checks.push_back(near(fmt::format("sphere, stretch {}", row.stretch), row.sphere,
                                wall_pressure(Wall::Sphere, row.stretch), 0.01, "Pa",
                                "reference given to 0.001; quadrature"));
    found.checks.push_back(near(fmt::format("cylinder, stretch {}", row.stretch), row.cylinder,
                                wall_pressure(Wall::Cylinder, row.stretch), 0.01, "Pa",
                                "reference given to 0.001; quadrature"));
  }
  return found;
}

/// Stretch of the inner radius in finite elements under the closed form's pressure. Pressure
/// follows the wall; at the solution it is the dead traction P lambda^2 (sphere) or P lambda
/// (cylinder).
double wall_stretch(Wall wall, Element element, int layers, const WallPoint& point,
                    const Context& ctx) {
  std::vector<double> radii{0.0};
  for (int i = 1; i <= 2 * layers; ++i) {
    radii.push_back(outer_radius * i / (2 * layers));
  }
  const TetMesh mesh = wall == Wall::Sphere
                           ? ball_octant(radii, layers)
                           : tube_quarter(inner_radius, outer_radius, outer_radius / (2 * layers),
                                          layers, 2 * layers);
  Body body;
  body.mesh = &mesh;
  body.element = element;
  body.tissue.assign(mesh.cells.size(), c100);
  body.fixed = symmetry_supports(mesh);
  if (wall == Wall::Cylinder) {
    for (const int v : vertices_on(mesh, "z1")) {
      body.fixed[static_cast<std::size_t>(v)] |= 4;
    }
  }
  const int inner = boundary_index(mesh, "inner");
  for (const BoundaryFace& face : mesh.faces) {
    if (face.name == inner) {
      body.loads.traction_faces.push_back(face);
    }
  }
  const double l = point.stretch;
  const double pull = wall == Wall::Sphere ? point.sphere * l * l : point.cylinder * l;
  body.loads.traction = [=](const Vec3& X) {
    return pull * normalised({X[0], X[1], wall == Wall::Sphere ? X[2] : 0.0});
  };
  Solver solver(body);
  const Shape shape = solver.forward(solver.straight_nodes(mesh.points), {}, nullptr, ctx);
  double sum = 0.0;
  const std::vector<int> wall_vertices = vertices_on(mesh, "inner");
  for (const int v : wall_vertices) {
    const auto i = static_cast<std::size_t>(v);
    const Vec3 at =
        wall == Wall::Sphere ? shape.nodes[i] : Vec3{shape.nodes[i][0], shape.nodes[i][1], 0.0};
    sum += norm(at) / inner_radius;
  }
  return sum / static_cast<double>(wall_vertices.size());
}

Findings walls(Element element, const std::vector<int>& layers, double tolerance,
               const Context& ctx) {
  Findings found;
  Table table{"Stretch of the inner radius", {"wall", "stretch wanted"}, {}};
  for (const int n : layers) {
    table.header.push_back(fmt::format("{} layers", n));
  }
  for (const Wall wall : {Wall::Sphere, Wall::Cylinder}) {
    const std::string name = wall == Wall::Sphere ? "sphere" : "cylinder";
    for (const WallPoint& point : wall_table) {
      std::vector<std::string> row{name, fmt::format("{}", point.stretch)};
      std::vector<double> stretch;
      for (const int n : layers) {
        stretch.push_back(wall_stretch(wall, element, n, point, ctx));
        row.push_back(fmt::format("{:.5f}", stretch.back()));
      }
      table.rows.push_back(row);
      const double displacement = std::abs(point.stretch - 1.0);
      const std::string at = fmt::format("{}, stretch {}", name, point.stretch);
      found.checks.push_back(near(fmt::format("{}, {} layers", at, layers[1]), point.stretch,
                                  stretch[1], tolerance * displacement, "",
                                  fmt::format("{:.0f} % of the displacement", 100 * tolerance)));
      // Straight edges on a round wall and the elements themselves: both second order in h.
      const double ratio = static_cast<double>(layers[1]) / layers[0];
      const double limit = stretch[1] + (stretch[1] - stretch[0]) / (ratio * ratio - 1.0);
      found.checks.push_back(near(at + ", extrapolated", point.stretch, limit,
                                  0.25 * tolerance * displacement, "",
                                  "a quarter of that: second order in h"));
    }
  }
  found.tables.push_back(std::move(table));
  return found;
}

/// lambda - lambda^-2 = rho g s / mu, s the reference length below the section.
double stretch_under(double length_below) {
  const double load = 970.0 * 9.81 * length_below / 500.0;
  double l = 1.0;
  for (int i = 0; i < 60; ++i) {
    l -= (l - 1.0 / (l * l) - load) / (1.0 + 2.0 / (l * l * l));
  }
  return l;
}

/// A quarter of a hanging square bar, neo-Hookean mu = 500 Pa, rho = 970, fixed only along z at the
/// top. It is slender (1:12 with its mirror images), so sections stay almost flat.
Findings column(Element element, double tolerance, const Context& ctx) {
  const TetMesh mesh = block({0.003, 0.003, 0.070}, {2, 2, 40});
  Body body;
  body.mesh = &mesh;
  body.element = element;
  body.tissue.assign(mesh.cells.size(), {250.0, 0.0, 5e5, 970.0, 1.0, 0.0});
  body.fixed.assign(mesh.points.size(), 0);
  const std::array<std::pair<const char*, int>, 3> planes{{{"x0", 1}, {"y0", 2}, {"z1", 4}}};
  for (const auto& [name, bit] : planes) {
    for (const int v : vertices_on(mesh, name)) {
      body.fixed[static_cast<std::size_t>(v)] |= static_cast<std::uint8_t>(bit);
    }
  }
  const double lengthening = integrate([](double s) { return stretch_under(s) - 1.0; }, 0.0, 0.070);
  Solver solver(body);
  const auto rest = solver.straight_nodes(mesh.points);
  const Vec3 down{0.0, 0.0, -9.81};
  const Shape hung = solver.forward(rest, down, nullptr, ctx);
  const auto tip = static_cast<std::size_t>(vertices_on(mesh, "z0").front());
  const Shape back = solver.inverse(hung.nodes, down, ctx);
  double worst = 0.0;
  for (std::size_t n = 0; n < rest.size(); ++n) {
    worst = std::max(worst, norm(back.nodes[n] - rest[n]));
  }
  Findings found;
  found.checks.push_back(near("stretch at the top, closed form", 1.68, stretch_under(0.070), 0.005,
                              "", "reference given with three digits"));
  found.checks.push_back(
      near("lengthening", 1e3 * lengthening, 1e3 * (rest[tip] - hung.nodes[tip])[2],
           1e3 * tolerance * lengthening, "mm",
           fmt::format("{:.1f} %: sections are not quite flat", 100 * tolerance)));
  found.checks.push_back(within("inverse of forward, largest distance / lengthening", 0.0, 1e-6,
                                worst / lengthening, "", "both solve the same discrete equations"));
  return found;
}

struct Contraction {
  double active, kappa, volume;  // [Pa], [Pa], V/V0
};

/// A wound of 22 mm in a ball of three times its radius, PARAMETERS.md 4.1:
/// T = lambda (kappa_w (1 - lambda^3) - P(lambda)).
Findings contraction(const Context& ctx) {
  const double radius = 0.022;
  const TetMesh mesh = ball_octant(graded_radii(radius, 14, 3.0 * radius, 1.35));
  Body body;
  body.mesh = &mesh;
  body.fixed = symmetry_supports(mesh);
  body.tissue.assign(mesh.cells.size(), {112.5, 112.5, 5e5, 1000.0, 1.0, 0.0});
  const std::vector<double> wound =
      cells_where(mesh, [=](const Vec3& p) { return norm(p) < radius; });
  const recovery::WoundShape shape_of_wound(mesh, wound, mesh.points, body.tissue);
  Findings found;
  for (const Contraction& c : {Contraction{826.0, 1e4, 0.92}, Contraction{3938.3, 5e4, 0.92},
                               Contraction{4366.7, 1e4, 0.50}}) {
    auto tissue = body.tissue;
    for (std::size_t cell = 0; cell < tissue.size(); ++cell) {
      if (wound[cell] > 0.0) {
        tissue[cell] = {200.0, 200.0, c.kappa, 1000.0, 1.0, c.active};
      }
    }
    Solver solver(body);
    solver.set_tissue(tissue);
    const Shape shape = solver.forward(mesh.points, {}, nullptr, ctx);
    const double ratio =
        shape_of_wound.volume(solver.jacobians(mesh.points, shape.nodes), shape.pressure) /
        shape_of_wound.volume(std::vector<double>(mesh.cells.size(), 1.0), {});
    found.checks.push_back(
        near(fmt::format("V/V0 at T = {} Pa, kappa = {:.0f} Pa", c.active, c.kappa), c.volume,
             ratio, 0.03 * (1.0 - c.volume), "",
             "3 % of the contraction: one pressure field across the wall of "
             "the wound is first order in h"));
  }
  return found;
}

}  // namespace

void add_closed_forms(std::vector<Case>& cases) {
  cases.push_back({"thick-wall-law", "Thick walls, the law integrated (C6)",
                   Chapter::CodeVerification, Cost::Fast,
                   "Pressure in a thick incompressible sphere and cylinder (A = 10, B = 20, c1 = "
                   "c2 = 100 Pa) from the shipped stress by quadrature, against the closed form.",
                   wall_law});
  for (const auto& [element, layers, tolerance, cost] :
       {std::tuple{Element::P1P1, std::vector{4, 6}, 0.08, Cost::Fast},
        std::tuple{Element::Smoothed, std::vector{4, 6}, 0.04, Cost::Fast},
        std::tuple{Element::P2P1, std::vector{2, 4}, 0.04, Cost::Full}}) {
    cases.push_back({"thick-wall-" + name_of(element),
                     fmt::format("Thick sphere and cylinder, {} (C6)", title_of(element)),
                     Chapter::CodeVerification, cost,
                     "An octant of the sphere and a quarter of the cylinder in plane strain under "
                     "the closed form's pressure; the stretch of the inner radius has to come out.",
                     [=](const Context& ctx) {
                       return walls(element, layers, tolerance, ctx);
                     }});
  }
  for (const auto& [element, tolerance] :
       {std::pair{Element::P1P1, 0.02}, std::pair{Element::Smoothed, 0.01},
        std::pair{Element::P2P1, 0.005}}) {
    cases.push_back({"column-" + name_of(element),
                     fmt::format("Hanging column, {} (C10)", title_of(element)),
                     Chapter::CodeVerification, Cost::Fast,
                     "A slender incompressible bar under its own weight: lambda - lambda^-2 = rho "
                     "g s / mu; and unloading it again.",
                     [=](const Context& ctx) {
                       return column(element, tolerance, ctx);
                     }});
  }
  cases.push_back({"contraction", "Contracting spherical wound (C5)", Chapter::CodeVerification,
                   Cost::Fast,
                   "Active stress in a compressible wound inside an incompressible shell; closed "
                   "form of PARAMETERS.md 4.1. P1/P1 as shipped, ten layers in the wound.",
                   contraction});
}

}  // namespace sanatrix::verification
