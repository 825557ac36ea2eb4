// Tangents against central differences, block by block, for both unknowns and both elements; an
// overall norm would be blind to the small pressure rows.
#include "mechanics/elements.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "fem/layout.hpp"
#include "mechanics/membrane.hpp"
#include "mechanics/mooney_rivlin.hpp"

namespace sanatrix::mechanics {
namespace {

using Nodes = std::vector<Vec3>;

Nodes with_midpoints(Nodes vertices) {
  for (const auto& [a, b] : fem::EdgeTable::local) {
    vertices.push_back(
        0.5 * (vertices[static_cast<std::size_t>(a)] + vertices[static_cast<std::size_t>(b)]));
  }
  return vertices;
}

void shake(Nodes& nodes, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> d(-by, by);
  for (Vec3& p : nodes) {
    p += Vec3{d(random), d(random), d(random)};
  }
}

const Tissue wounded{120.0, 80.0, 2e3, 1000.0, 0.3, 250.0, 0.05};
const Vec3 gravity{1.0, -9.0, 3.0};

/// Largest difference between K and the central difference of R, per block, relative to the block.
struct BlockErrors {
  double uu, up, pu, pp;
};

template <std::size_t N>
BlockErrors cell_errors(Unknown unknown) {
  Nodes known = {{0, 0, 0}, {0.011, 0.001, 0}, {0.002, 0.009, 0.001}, {0.001, 0.002, 0.012}};
  Nodes sought = known;
  if (N == 10) {
    known = with_midpoints(known);
    sought = known;
    shake(known, 2e-4, 7);
  }
  shake(sought, 9e-4, 3);
  constexpr std::size_t n = 3 * N + 4;
  std::array<double, 4> p{30.0, -80.0, 120.0, 10.0};
  const auto evaluate = [&](std::span<double> r, std::span<double> K) {
    const CellInput in{unknown, known, sought, p, wounded, gravity};
    ASSERT_GT(cell_element<N>(in, r, K), 0.0);
  };
  std::vector<double> r(n);
  std::vector<double> K(n * n);
  evaluate(r, K);
  std::vector<double> difference(n * n);
  for (std::size_t c = 0; c < n; ++c) {
    const double h = c < 3 * N ? 1e-8 : 1e-2;
    double& x = c < 3 * N ? sought[c / 3][c % 3] : p[c - 3 * N];
    const double x0 = x;
    std::vector<double> plus(n);
    std::vector<double> minus(n);
    x = x0 + h;
    evaluate(plus, {});
    x = x0 - h;
    evaluate(minus, {});
    x = x0;
    for (std::size_t i = 0; i < n; ++i) {
      difference[i * n + c] = (plus[i] - minus[i]) / (2.0 * h);
    }
  }
  const auto block = [&](bool row_p, bool column_p) {
    double error = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        if ((i >= 3 * N) == row_p && (j >= 3 * N) == column_p) {
          error = std::max(error, std::abs(K[i * n + j] - difference[i * n + j]));
          size = std::max(size, std::abs(K[i * n + j]));
        }
      }
    }
    return error / size;
  };
  return {block(false, false), block(false, true), block(true, false), block(true, true)};
}

template <std::size_t N>
void expect_consistent_cell(Unknown unknown) {
  const BlockErrors e = cell_errors<N>(unknown);
  EXPECT_LT(e.uu, 2e-6);  // step 1e-8 m on stresses of 1e3 Pa: round-off of the difference
  EXPECT_LT(e.up, 2e-6);
  EXPECT_LT(e.pu, 2e-6);
  EXPECT_LT(e.pp, 2e-6);
}

TEST(ACell, OfP1P1HasAConsistentForwardTangent) {
  expect_consistent_cell<4>(Unknown::Deformed);
}
TEST(ACell, OfP1P1HasAConsistentInverseTangent) {
  expect_consistent_cell<4>(Unknown::Reference);
}
TEST(ACell, OfP2P1HasAConsistentForwardTangent) {
  expect_consistent_cell<10>(Unknown::Deformed);
}
TEST(ACell, OfP2P1HasAConsistentInverseTangent) {
  expect_consistent_cell<10>(Unknown::Reference);
}

TEST(ACell, GivesTheSameResidualWhicheverShapeIsCalledKnown) {
  Nodes X = {{0, 0, 0}, {0.011, 0.001, 0}, {0.002, 0.009, 0.001}, {0.001, 0.002, 0.012}};
  Nodes x = X;
  shake(x, 9e-4, 3);
  const std::array<double, 4> p{30.0, -80.0, 120.0, 10.0};
  std::vector<double> forward(16);
  std::vector<double> inverse(16);
  cell_element<4>({Unknown::Deformed, X, x, p, wounded, gravity}, forward, {});
  cell_element<4>({Unknown::Reference, x, X, p, wounded, gravity}, inverse, {});
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_NEAR(forward[i], inverse[i], 1e-12 * (1.0 + std::abs(forward[0])));
  }
}

// Four cells around the inner edge of an octahedron: all nodes of a smoothing domain move.
struct Octahedron {
  Nodes known{{0, 0, -9e-3}, {0, 0, 1e-2},    {9e-3, 0, 0},
              {0, 1e-2, 0},  {-1.1e-2, 0, 0}, {0, -8e-3, 0}};
  Nodes sought = known;
  std::vector<double> p{30.0, -80.0, 120.0, 10.0, 60.0, -40.0};
  std::array<Tissue, 4> tissue;
  std::vector<DomainCell> cells;
  Octahedron() {
    shake(known, 5e-4, 11);
    shake(sought, 9e-4, 3);
    for (int c = 0; c < 4; ++c) {
      Tissue& t = tissue.at(static_cast<std::size_t>(c));
      t = wounded;
      t.c1 += 40.0 * c;
      t.c2 -= 15.0 * c;
      t.active_stress += 30.0 * c;
      t.shrinkage -= 0.01 * c;
      cells.push_back({{0, 1, 2 + c, 2 + (c + 1) % 4}, &t});
    }
  }
  double operator()(Unknown unknown, std::span<double> r, std::span<double> K) const {
    return domain_element({unknown, known, sought, p, cells}, r, K);
  }
};

void expect_consistent_domain(Unknown unknown) {
  Octahedron domain;
  constexpr std::size_t n = 24;
  std::vector<double> r(n);
  std::vector<double> K(n * n);
  ASSERT_GT(domain(unknown, r, K), 0.0);
  std::array<double, 4> error{};  // uu, up, pu, pp
  std::array<double, 4> size{};
  for (std::size_t c = 0; c < n; ++c) {
    const bool is_p = c % 4 == 3;
    const double h = is_p ? 1e-2 : 1e-8;
    double& x = is_p ? domain.p[c / 4] : domain.sought[c / 4][c % 4];
    const double x0 = x;
    std::vector<double> plus(n);
    std::vector<double> minus(n);
    x = x0 + h;
    domain(unknown, plus, {});
    x = x0 - h;
    domain(unknown, minus, {});
    x = x0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t block = 2 * (i % 4 == 3 ? 1U : 0U) + (is_p ? 1U : 0U);
      const double k = K[16 * (6 * (i / 4) + c / 4) + 4 * (c % 4) + i % 4];
      error.at(block) = std::max(error.at(block), std::abs(k - (plus[i] - minus[i]) / (2.0 * h)));
      size.at(block) = std::max(size.at(block), std::abs(k));
    }
  }
  for (const std::size_t block : {0U, 1U, 2U}) {
    EXPECT_LT(error.at(block), 2e-6 * size.at(block)) << block;
  }
  EXPECT_EQ(size[3], 0.0);
}

TEST(ASmoothingDomain, HasAConsistentForwardTangent) {
  expect_consistent_domain(Unknown::Deformed);
}
TEST(ASmoothingDomain, HasAConsistentInverseTangent) {
  expect_consistent_domain(Unknown::Reference);
}

TEST(ASmoothingDomain, GivesTheSameResidualWhicheverShapeIsCalledKnown) {
  Octahedron domain;
  std::vector<double> forward(24);
  std::vector<double> inverse(24);
  ASSERT_GT(domain(Unknown::Deformed, forward, {}), 0.0);
  std::swap(domain.known, domain.sought);
  ASSERT_GT(domain(Unknown::Reference, inverse, {}), 0.0);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_NEAR(forward[i], inverse[i], 1e-12 * std::abs(forward[0]));
  }
}

// In a homogeneous state all cells have the same strain, and averaging may change nothing: six
// times a domain's residual is the sum of what its cells say themselves, but for the pressure's own
// terms, which vanish without pressure.
TEST(ASmoothingDomain, OfAHomogeneousStateIsASixthOfItsCells) {
  Octahedron domain;
  const Mat3 F{{{1.1, 0.2, -0.1}, {0.05, 0.9, 0.15}, {-0.2, 0.1, 1.05}}};
  std::ranges::transform(domain.known, domain.sought.begin(), [&](const Vec3& X) { return F * X; });
  domain.tissue.fill({});
  for (Tissue& t : domain.tissue) {
    t.guard = 0.0;
  }
  domain.p.assign(6, 0.0);
  std::vector<double> r(24);
  ASSERT_GT(domain(Unknown::Deformed, r, {}), 0.0);
  std::vector<double> sum(24);
  for (const DomainCell& cell : domain.cells) {
    Nodes X;
    Nodes x;
    for (const int a : cell.node) {
      X.push_back(domain.known[static_cast<std::size_t>(a)]);
      x.push_back(domain.sought[static_cast<std::size_t>(a)]);
    }
    std::vector<double> own(16);
    cell_element<4>({Unknown::Deformed, X, x, {}, *cell.tissue, {}}, own, {});
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(cell.node[a]);
      for (std::size_t i = 0; i < 3; ++i) {
        sum[4 * node + i] += own[3 * a + i] / 6.0;
      }
      sum[4 * node + 3] += own[12 + a] / 6.0;
    }
  }
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_NEAR(r[i], sum[i], 1e-12 * std::abs(sum[i % 4 == 3 ? 3 : 0]));
  }
}

TEST(ACell, TurnedInsideOutIsReported) {
  const Nodes X = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Nodes x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  std::vector<double> r(16);
  EXPECT_LE(cell_element<4>({Unknown::Deformed, X, x, {}, {}, gravity}, r, {}), 0.0);
  EXPECT_LE(cell_element<4>({Unknown::Reference, x, X, {}, {}, gravity}, r, {}), 0.0);
}

template <std::size_t N>
double face_error(Unknown unknown, const std::array<double, 3>& stretch, bool relaxed) {
  Nodes known = {{0, 0, 0}, {0.011, 0.001, 0}, {0.002, 0.009, 0.001}};
  if (N == 6) {
    known.push_back(0.5 * (known[0] + known[1]));
    known.push_back(0.5 * (known[1] + known[2]));
    known.push_back(0.5 * (known[2] + known[0]));
  }
  Nodes sought = known;
  for (Vec3& s : sought) {
    for (std::size_t i = 0; i < 3; ++i) {
      s[i] *= unknown == Unknown::Deformed ? stretch[i] : 1.0 / stretch[i];
    }
  }
  shake(sought, 5e-5, 5);
  Skin skin;
  skin.tension_field = relaxed;
  constexpr std::size_t n = 3 * N;
  std::vector<double> r(n);
  std::vector<double> K(n * n);
  const auto evaluate = [&](std::span<double> out, std::span<double> matrix) {
    face_element<N>({unknown, known, sought, skin, gravity}, out, matrix);
  };
  evaluate(r, K);
  double error = 0.0;
  double size = 1e-30;
  for (std::size_t c = 0; c < n; ++c) {
    double& x = sought[c / 3][c % 3];
    const double x0 = x;
    std::vector<double> plus(n);
    std::vector<double> minus(n);
    x = x0 + 1e-8;
    evaluate(plus, {});
    x = x0 - 1e-8;
    evaluate(minus, {});
    x = x0;
    for (std::size_t i = 0; i < n; ++i) {
      error = std::max(error, std::abs(K[i * n + c] - (plus[i] - minus[i]) / 2e-8));
      size = std::max(size, std::abs(K[i * n + c]));
    }
  }
  return error / size;
}

TEST(AFace, HasConsistentTangentsInEveryMembraneState) {
  const std::array<double, 3> taut{1.15, 1.1, 1.0};
  const std::array<double, 3> wrinkled{1.2, 0.8, 1.0};
  for (const Unknown unknown : {Unknown::Deformed, Unknown::Reference}) {
    for (const auto& s : {taut, wrinkled}) {
      EXPECT_LT(face_error<3>(unknown, s, true), 1e-5);
      EXPECT_LT(face_error<6>(unknown, s, true), 1e-5);
    }
    EXPECT_LT(face_error<3>(unknown, wrinkled, false), 1e-5);
  }
}

TEST(ALaw, HasTheStressThatItsEnergySays) {
  Mat3 F{{{1.1, 0.2, -0.1}, {0.05, 0.9, 0.15}, {-0.2, 0.1, 1.05}}};
  const StressPoint s = stress(wounded, F, 0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t J = 0; J < 3; ++J) {
      const double f0 = F[i][J];
      F[i][J] = f0 + 1e-6;
      const double plus = energy(wounded, F);
      F[i][J] = f0 - 1e-6;
      const double minus = energy(wounded, F);
      F[i][J] = f0;
      EXPECT_NEAR(s.P[i][J], (plus - minus) / 2e-6, 1e-6 * 1e3);
    }
  }
}

TEST(ALaw, DamageLeavesTheVolumetricPartAlone) {
  const Mat3 F{{{1.1, 0, 0}, {0, 1.1, 0}, {0, 0, 1.1}}};
  Tissue t;
  const StressPoint intact = stress(t, F, 500.0);
  t.integrity = 0.01;
  const StressPoint damaged = stress(t, F, 500.0);
  EXPECT_NEAR(intact.P[0][0], damaged.P[0][0], 1e-9);
}

// Closed forms of VALIDATION.md C7: c1 = c2 = 100 Pa at stretch 1.2, and the skin at 1.1 and 1.2.
TEST(ALaw, AgreesWithHomogeneousClosedForms) {
  const Tissue t{100.0, 100.0, 1e9, 0.0, 1.0, 0.0};
  const double l = 1.2;
  const Mat3 uniaxial{{{l, 0, 0}, {0, 1 / std::sqrt(l), 0}, {0, 0, 1 / std::sqrt(l)}}};
  const Mat3 biaxial{{{l, 0, 0}, {0, l, 0}, {0, 0, 1 / (l * l)}}};
  const auto cauchy_difference = [&](const Mat3& F) {  // sigma_1 - sigma_3, free of pressure
    const StressPoint s = stress(t, F, 0.0);
    return s.P[0][0] * F[0][0] - s.P[2][2] * F[2][2];
  };
  EXPECT_NEAR(cauchy_difference(uniaxial), 222.44, 0.01);
  EXPECT_NEAR(cauchy_difference(biaxial), 467.38, 0.01);
}

TEST(TheMembrane, AgreesWithHomogeneousClosedForms) {
  Skin skin;
  skin.c2 = -9909.1;
  const auto cauchy = [&](double l1, double l2) {
    const Metrics m{{l1 * l1, 0.0, l2 * l2}, {1.0, 0.0, 1.0}};
    // dW/d(a11) = 1/2 P1 / l1 per area and thickness; sigma1 = P1 l1 (incompressible, l2 l3 = 1/l1)
    return 2.0 * membrane_energy(skin, m).gradient[0] / skin.thickness * l1 * l1;
  };
  EXPECT_NEAR(cauchy(1.1, 1.0 / std::sqrt(1.1)), 8.3e3, 50.0);
  EXPECT_NEAR(cauchy(1.1, 1.1), 22.4e3, 50.0);
  EXPECT_NEAR(cauchy(1.2, 1.0 / std::sqrt(1.2)), 31.1e3, 50.0);
  EXPECT_NEAR(cauchy(1.2, 1.2), 207.5e3, 50.0);
  EXPECT_EQ(cauchy(0.95, 0.9), 0.0);                      // slack
  EXPECT_NEAR(cauchy(1.1, 0.7), cauchy(1.1, 0.6), 1e-6);  // wrinkled: the width does not matter
}

}  // namespace
}  // namespace sanatrix::mechanics
