// Closed forms of VALIDATION.md C6 and C10 that need no shared data.
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "block_mesh.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/problem.hpp"
#include "octant_mesh.hpp"

namespace sanatrix::mechanics {
namespace {

const Tissue c100{100.0, 100.0, 5e5, 1000.0, 1.0, 0.0};

double integrate(const std::function<double(double)>& f, double a, double b) {
  double sum = 0.0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    sum += f(a + (b - a) * (i + 0.5) / n) * (b - a) / n;
  }
  return sum;
}

/// Cauchy stress difference sigma_t - sigma_r for principal stretches, from our law.
double hoop_minus_radial(double radial, double hoop, double third) {
  const Mat3 F{{{radial, 0, 0}, {0, hoop, 0}, {0, 0, third}}};
  const StressPoint s = stress(c100, F, 0.0);
  return s.P[1][1] * hoop - s.P[0][0] * radial;
}

// Thick walls A = 10, B = 20: P = int k (sigma_t - sigma_r)/r dr, k = 2 sphere, 1 cylinder.
TEST(AThickWall, NeedsThePressureOfTheClosedForm) {
  const double A = 10.0;
  const double B = 20.0;
  const auto sphere = [&](double la) {
    return integrate(
        [&](double R) {
          const double r = std::cbrt(R * R * R + A * A * A * (la * la * la - 1.0));
          const double l = r / R;
          return 2.0 * hoop_minus_radial(1.0 / (l * l), l, l) / r * (R * R) / (r * r);
        },
        A, B);
  };
  const auto cylinder = [&](double la) {
    return integrate(
        [&](double R) {
          const double r = std::sqrt(R * R + A * A * (la * la - 1.0));
          const double l = r / R;
          return hoop_minus_radial(1.0 / l, l, 1.0) / r * R / r;
        },
        A, B);
  };
  const std::vector<std::array<double, 3>> table{{0.9, -165.233, -69.351},
                                                 {1.1, 121.366, 52.625},
                                                 {1.25, 252.622, 110.285},
                                                 {1.5, 394.167, 171.291},
                                                 {2.0, 549.674, 229.621}};
  for (const auto& [la, p_sphere, p_cylinder] : table) {
    EXPECT_NEAR(sphere(la), p_sphere, 0.01);
    EXPECT_NEAR(cylinder(la), p_cylinder, 0.01);
  }
}

// The same sphere in finite elements: a core without shear stiffness of its own pulls with T, where
// T/lambda + kappa (lambda^3 - 1) = -P(lambda), P(0.9) = -165.233 Pa.
TEST(AThickSphere, IsPulledInByItsCoreAsTheClosedFormSays) {
  const double l = 0.9;
  const double kappa = 1e4;
  const double T = l * (165.233 - kappa * (l * l * l - 1.0));
  const TetMesh mesh = testing::octant_mesh({0.010, 0.020}, 0.0012, 0.0024);
  Body body;
  body.mesh = &mesh;
  body.fixed = testing::symmetry_supports(mesh);
  for (const int region : mesh.region) {
    body.tissue.push_back(region == 0 ? Tissue{1e-3, 1e-3, kappa, 1000.0, 1.0, T} : c100);
  }
  Silent silent;
  Solver solver(body);
  const Shape shape = solver.forward(mesh.points, {}, nullptr, Context("test", silent));
  double sum = 0.0;
  int n = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (std::abs(norm(mesh.points[v]) - 0.010) < 1e-6) {
      sum += norm(shape.nodes[v]) / norm(mesh.points[v]);
      ++n;
    }
  }
  EXPECT_NEAR(sum / n, l, 0.004);  // 4 % of the displacement at 8 elements per radius
}

struct Column {
  TetMesh mesh;
  Body body;
};

/// A quarter of a hanging square bar, neo-Hookean mu = 500 Pa, rho = 970, fixed only along z at the
/// top.
Column make_column(Element element) {
  Column c;
  c.mesh = testing::block_mesh({0.003, 0.003, 0.070}, {2, 2, 40});
  c.body.mesh = &c.mesh;
  c.body.element = element;
  c.body.tissue.assign(c.mesh.cells.size(), {250.0, 0.0, 5e5, 970.0, 1.0, 0.0});
  c.body.fixed.assign(c.mesh.points.size(), 0);
  const std::array<std::pair<const char*, int>, 3> planes{{{"x0", 1}, {"y0", 2}, {"z1", 4}}};
  for (const auto& [name, bit] : planes) {
    for (const int v : vertices_on(c.mesh, name)) {
      c.body.fixed[static_cast<std::size_t>(v)] |= static_cast<std::uint8_t>(bit);
    }
  }
  return c;
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

void expect_hanging_column(Element element, double tolerance) {
  EXPECT_NEAR(stretch_under(0.070), 1.68, 0.005);  // the number of C10
  const Column c = make_column(element);
  const double lengthening = integrate([](double s) { return stretch_under(s) - 1.0; }, 0.0, 0.070);
  Silent silent;
  const Context ctx("test", silent);
  Solver solver(c.body);
  const auto rest = solver.straight_nodes(c.mesh.points);
  const Vec3 down{0.0, 0.0, -9.81};
  const Shape hung = solver.forward(rest, down, nullptr, ctx);
  const auto tip = static_cast<std::size_t>(vertices_on(c.mesh, "z0").front());
  EXPECT_NEAR((rest[tip] - hung.nodes[tip])[2] / lengthening, 1.0, tolerance);

  const Shape back = solver.inverse(hung.nodes, down, ctx);
  double worst = 0.0;
  for (std::size_t n = 0; n < rest.size(); ++n) {
    worst = std::max(worst, norm(back.nodes[n] - rest[n]));
  }
  EXPECT_LT(worst / lengthening, 1e-6);
}

// The bar is slender (1:12 with its mirror images), so sections stay almost flat.
TEST(AHangingColumn, StretchesAsTheClosedFormAndUnloadsExactly) {
  expect_hanging_column(Element::P2P1, 0.005);
  expect_hanging_column(Element::P1P1, 0.02);
}

}  // namespace
}  // namespace sanatrix::mechanics
