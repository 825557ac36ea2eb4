// The solver's promises: where it begins, how it records, resumes, stops and refuses.
#include "healing/reaction_diffusion.hpp"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "geometry/structured_mesh.hpp"

namespace sanatrix::healing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;

constexpr double day = 86400.0;

/// A block of 24 mm with a wound of 12 mm in its middle.
struct AWound : ::testing::Test {
  TetMesh mesh = lattice({8, 8, 8}, [](int i, int j, int k) {
    return Vec3{0.003 * i, 0.003 * j, 0.003 * k};
  });
  std::vector<double> fraction = cells_where(mesh, [](const Vec3& p) {
    return std::ranges::all_of(p, [](double x) { return x > 0.006 && x < 0.018; });
  });
  std::unique_ptr<Model> model = make_model("vavourakis2016");
  Silent silent;
  Context ctx{"heal", silent};

  [[nodiscard]] ReactionDiffusion solver(RdOptions options = {}) const {
    return {mesh, mesh.points, fraction, *model, options};
  }
  [[nodiscard]] SpeciesRecord recorded(const ReactionDiffusion& rd) const {
    return record(rd, mesh, mesh.points, fraction, *model);
  }
};

TEST_F(AWound, IsFreshAtTheStartAndHealthyAround) {
  const auto rd = solver();
  // 5 x 5 x 5 vertices of the wound, its interface included (PARAMETERS.md 5.3).
  EXPECT_EQ(std::ranges::count(rd.wound_vertices(), true), 125);
  const SpeciesRecord r = recorded(rd);
  EXPECT_NEAR(r.mean[0], 0.01, 1e-15);  // no spurious cells from interpolation
  EXPECT_THAT(r.mean, ::testing::Pointwise(::testing::DoubleNear(1e-15),
                                           std::vector{0.01, 0.0, 0.0, 0.0, 0.0}));
  EXPECT_EQ(r.eta_healthy_min, 1.0);
  EXPECT_EQ(r.eta_healthy_max, 1.0);
  EXPECT_EQ(r.far_field_second, 1.0);
  const auto density = rd.cell_density();
  for (std::size_t c = 0; c < density.size(); ++c) {
    if (fraction[c] == 1.0) {
      EXPECT_DOUBLE_EQ(density[c], 0.01);
    }
  }
}

/// A bar of 12 x 12 mm, so many mm long, with a wound in its first 12 mm.
struct ABar {
  TetMesh mesh;
  std::vector<double> fraction;
  explicit ABar(int length)
      : mesh(lattice({4, 4, length / 3},
                     [](int i, int j, int k) {
                       return Vec3{0.003 * i, 0.003 * j, 0.003 * k};
                     })),
        fraction(cells_where(mesh, [](const Vec3& p) { return p[2] < 0.012; })) {}
};

TEST_F(AWound, HealsTheSameHoweverMuchHealthyTissueIsAround) {
  // The longest decay length is 3.2 mm: 48 mm of the long bar's 108 are within reach of the wound,
  // and all of the other's. The bound is what the tolerance of the steps leaves.
  std::array<std::vector<double>, 2> state;
  for (const int length : {48, 120}) {
    const ABar bar(length);
    std::vector<double>& mine = state[length == 48 ? 0 : 1];
    ReactionDiffusion rd(bar.mesh, bar.mesh.points, bar.fraction, *model,
                         {.relative_tolerance = 1e-8});
    rd.advance(12 * day, ctx);
    for (std::size_t v = 0; v < bar.mesh.points.size(); ++v) {
      const auto q = std::span(rd.state()).subspan(5 * v, 5);
      const double z = bar.mesh.points[v][2];
      if (z < 0.0125) {
        mine.insert(mine.end(), q.begin(), q.end());
      } else if (z > 0.06) {
        EXPECT_THAT(q, ::testing::ElementsAre(1.0, 1.0, 1.0, 1.0, 0.0));
      }
    }
  }
  EXPECT_THAT(state[1], ::testing::Pointwise(::testing::DoubleNear(1e-6), state[0]));
}

TEST_F(AWound, HealsWithinTheBoundsOfEverySpecies) {
  auto rd = solver();
  double least = 1.0, most = 0.0;
  std::vector<double> times;
  for (double t = 0.5; t <= 30.0; t += 0.5) {
    times.push_back(t * day);
  }
  rd.advance(30 * day, ctx, times, [&] {
    for (std::size_t k = 0; k < rd.state().size(); ++k) {
      least = std::min(least, rd.state()[k]);
      most = k % 5 == 4 ? most : std::max(most, rd.state()[k]);
    }
  });
  // Lattice tetrahedra have no obtuse dihedral angles, so that the maximum principle holds for the
  // equations; the integrator adds its tolerance.
  EXPECT_GE(least, -1e-4);
  EXPECT_LE(most, 1.0 + 1e-4);
  EXPECT_GT(recorded(rd).mean[0], 0.99);
}

TEST_F(AWound, RepeatsAnUndisturbedRunToTheLastBitWhenResumed) {
  auto undisturbed = solver();
  undisturbed.advance(6 * day, ctx);
  const auto checkpoint = undisturbed.state();
  undisturbed.advance(12 * day, ctx);
  auto resumed = solver();
  resumed.restore(6 * day, checkpoint);
  resumed.advance(12 * day, ctx);
  EXPECT_EQ(resumed.time_s(), 12 * day);
  EXPECT_EQ(resumed.state(), undisturbed.state());
}

TEST_F(AWound, IsRecordedOnTheWayWithoutDisturbingTheRun) {
  auto plain = solver(), watched = solver();
  plain.advance(2 * day, ctx);
  const auto at_two = plain.state();
  plain.advance(6 * day, ctx);
  watched.advance(2 * day, ctx);
  std::vector<double> times, seen;
  double difference = 0.0;
  watched.advance(6 * day, ctx, std::vector{1 * day, 2 * day, 4 * day, 6 * day, 7 * day}, [&] {
    seen.push_back(watched.time_s());
    if (watched.time_s() == 2 * day) {
      for (std::size_t k = 0; k < at_two.size(); ++k) {
        difference = std::max(difference, std::abs(at_two[k] - watched.state()[k]));
      }
    }
  });
  EXPECT_EQ(seen, (std::vector{2 * day, 4 * day, 6 * day}));
  EXPECT_EQ(difference, 0.0);
  EXPECT_EQ(watched.state(), plain.state());
}

TEST_F(AWound, StopsWhenAsked) {
  std::stop_source stop;
  struct Presser final : Listener {
    explicit Presser(std::stop_source& s) : source(s) {}
    void on(const Event& e) override {
      if (e.fraction > 0.3) {
        source.request_stop();
      }
    }
    std::stop_source& source;
  } presser(stop);
  auto rd = solver();
  EXPECT_THROW(rd.advance(90 * day, Context("heal", presser, stop.get_token())), Cancelled);
}

TEST_F(AWound, RefusesAnExplicitStepBeyondTheLimitAndNamesOneThatWorks) {
  try {
    const auto rd = solver({.scheme = Scheme::Explicit, .dt_s = 3000.0});
    FAIL() << "3000 s was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Input);
    // Oxygen on 3 mm: 2 h^2 / (12 D) = 750 s inside, a third at the wound's surface.
    EXPECT_THAT(e.one_line(), AllOf(HasSubstr("oxygen"), HasSubstr("use dt_s=")));
    const std::string hint = e.hint();
    const double works = std::stod(hint.substr(hint.find('=') + 1));
    EXPECT_GT(works, 100.0);
    auto rd = solver({.scheme = Scheme::Explicit, .dt_s = works});
    rd.advance(2 * day, ctx);
    EXPECT_THAT(recorded(rd).mean, Each(AllOf(Ge(0.0), Le(20.0))));
  }
}

TEST_F(AWound, RefusesAStateOfAnotherMesh) {
  auto rd = solver();
  EXPECT_THROW(rd.restore(0.0, std::vector<double>(7)), Error);
}

TEST_F(AWound, KeepsHealthyCellsOutOfTheMeanOfAPartlyCutRim) {
  for (double& f : fraction) {  // a wound whose rim covers a third of the next cells
    f = f == 1.0 ? 1.0 : 0.33;
  }
  const auto rd = solver();
  EXPECT_NEAR(recorded(rd).mean[0], 0.01, 1e-15);
}

}  // namespace
}  // namespace sanatrix::healing
