// A run that was stopped ends like one that was not, whatever its last checkpoint; equilibria that
// are left out where nothing happens are not missed.
#include "recovery/recovery.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "geometry/structured_mesh.hpp"

namespace sanatrix::recovery {
namespace {

/// A block of 24 mm on a fixed base with a wound of 12 mm in its middle, for 18 days.
struct AHealingBlock : ::testing::Test {
  TetMesh mesh = block({0.024, 0.024, 0.024}, {6, 6, 6});
  std::unique_ptr<healing::Model> model = healing::make_model("vavourakis2016");
  mechanics::Body body;
  Problem problem;
  Silent silent;
  Context ctx{"heal", silent};

  AHealingBlock() {
    body.mesh = &mesh;
    body.tissue.assign(mesh.cells.size(), mechanics::tissue_preset("vavourakis2016").adipose);
    body.fixed.assign(mesh.points.size(), 0);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      body.fixed[v] = mesh.points[v][2] == 0.0 ? 7 : 0;
    }
    problem.body = &body;
    problem.reference_nodes = mesh.points;
    problem.start = {mesh.points, std::vector<double>(mesh.points.size(), 0.0)};
    problem.species_points = mesh.points;
    problem.wound_fraction = cells_where(mesh, [](const Vec3& p) {
      return std::ranges::all_of(p, [](double x) { return x > 0.006 && x < 0.018; });
    });
    problem.model = model.get();
    problem.schedule.days = 18.0;
  }

  [[nodiscard]] Result healed(const std::optional<Checkpoint>& from,
                              std::vector<Checkpoint>& kept) const {
    return heal(
        problem, from, [&](const Checkpoint& c) { kept.push_back(c); },
        [](double, std::span<const double>, const mechanics::Shape&) {}, ctx);
  }
};

TEST_F(AHealingBlock, EndsTheSameFromEveryCheckpointTheLastOneIncluded) {
  std::vector<Checkpoint> kept, unused;
  const Result whole = healed({}, kept);
  ASSERT_EQ(kept.size(), 3U);  // days 6, 12 and 18
  ASSERT_EQ(whole.tissue.size(), mesh.cells.size());
  EXPECT_GT(whole.history.back().max_displacement_mm, 0.1);
  for (const Checkpoint& checkpoint : kept) {
    const Result rest = healed(checkpoint, unused);
    EXPECT_EQ(rest.species, whole.species);
    ASSERT_EQ(rest.tissue.size(), whole.tissue.size());
    for (std::size_t c = 0; c < rest.tissue.size(); ++c) {
      EXPECT_EQ(rest.tissue[c].integrity, whole.tissue[c].integrity);
      EXPECT_EQ(rest.tissue[c].active_stress, whole.tissue[c].active_stress);
    }
    // A solver that starts anew has another preconditioner: equal to the solver's tolerance.
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      EXPECT_LT(norm(rest.healed.nodes[v] - whole.healed.nodes[v]), 1e-9 * 0.024);
    }
  }
}

TEST_F(AHealingBlock, LeavesOutEquilibriaButNoDayAndNoAccuracy) {
  problem.schedule.days = 60.0;
  std::vector<Checkpoint> kept;
  const auto history_with = [&](double change, std::vector<double>& days) {
    problem.schedule.mechanics_density_change = change;
    kept.clear();
    return heal(
               problem, {}, [&](const Checkpoint& c) { kept.push_back(c); },
               [&](double day, std::span<const double>, const mechanics::Shape&) {
                 days.push_back(day);
               },
               ctx)
        .history;
  };
  std::vector<double> all_days, days;
  const std::vector<HistoryRow> all = history_with(0.0, all_days);
  EXPECT_EQ(kept.size(), 10U);
  const std::vector<HistoryRow> few = history_with(0.05, days);
  EXPECT_LT(kept.size(), 8U);
  EXPECT_EQ(days, all_days);
  ASSERT_EQ(few.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(few[i].species.t_day, all[i].species.t_day);
    // A change of volume that is not proportional to that of density is of second order: less than
    // 0.05^2 of the whole loss, which is a tenth. Measured: 1e-5.
    EXPECT_NEAR(few[i].volume_ratio, all[i].volume_ratio, 0.05 * 0.05 * 0.1)
        << few[i].species.t_day;
  }
}

}  // namespace
}  // namespace sanatrix::recovery
