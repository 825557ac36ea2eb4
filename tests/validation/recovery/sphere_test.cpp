// A spherical wound in a ball of healthy tissue: contraction against the closed form (VALIDATION.md
// C5) and against the grid-converged 1-D histories of the default presets (C4, A1-A6).
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "octant_mesh.hpp"
#include "recovery/recovery.hpp"
#include "shared_data.hpp"

namespace sanatrix::recovery {
namespace {

struct Sphere {
  TetMesh mesh;
  mechanics::Body body;
  std::vector<double> wound;
};

/// c1 = c2 = 112.5 Pa and kappa = 5e5 Pa around a wound of radius R in a ball of 3 R.
Sphere make_sphere(double radius, double near) {
  Sphere s;
  s.mesh = testing::octant_mesh({radius, 3.0 * radius}, near, 4.0 * near);
  s.body.mesh = &s.mesh;
  s.body.fixed = testing::symmetry_supports(s.mesh);
  s.body.tissue.assign(s.mesh.cells.size(), {112.5, 112.5, 5e5, 1000.0, 1.0, 0.0});
  for (const int region : s.mesh.region) {
    s.wound.push_back(region == 0 ? 1.0 : 0.0);
  }
  return s;
}

double wound_volume(const Sphere& s, std::span<const Vec3> points) {
  const auto volumes = cell_volumes(s.mesh, points);
  double sum = 0.0;
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    sum += s.wound[c] * volumes[c];
  }
  return sum;
}

// PARAMETERS.md 4.1: T = lam (kappa_w (1 - lam^3) - P(lam)) in an incompressible shell of 3 R.
TEST(AContractingSphere, ReachesTheVolumeOfTheClosedForm) {
  const Sphere s = make_sphere(0.022, 0.002);
  const auto contracted = [&](double active, double kappa_wound, double c_wound) {
    auto tissue = s.body.tissue;
    for (std::size_t c = 0; c < tissue.size(); ++c) {
      if (s.wound[c] > 0.0) {
        tissue[c] = {c_wound, c_wound, kappa_wound, 1000.0, 1.0, active};
      }
    }
    mechanics::Solver solver(s.body);
    solver.set_tissue(tissue);
    Silent silent;
    const auto shape = solver.forward(s.mesh.points, {}, nullptr, Context("test", silent));
    return wound_volume(s, shape.nodes) / wound_volume(s, s.mesh.points);
  };
  // 3 % of the contraction: one pressure field across the wall of the wound is first order in h.
  EXPECT_NEAR(contracted(826.0, 1e4, 200.0), 0.92, 0.0024);
  EXPECT_NEAR(contracted(3938.3, 5e4, 200.0), 0.92, 0.0024);
  EXPECT_NEAR(contracted(4366.7, 1e4, 200.0), 0.50, 0.015);
}

std::map<std::string, std::vector<double>> read_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) {
    names.push_back(name);
  }
  std::map<std::string, std::vector<double>> columns;
  while (std::getline(in, line)) {
    std::istringstream row(line);
    std::string cell;
    for (const auto& name : names) {
      std::getline(row, cell, ',');
      columns[name].push_back(std::stod(cell));
    }
  }
  return columns;
}

double at(const std::vector<double>& t, const std::vector<double>& y, double when) {
  std::size_t i = 1;
  while (i + 1 < t.size() && t[i] < when) {
    ++i;
  }
  const double s = (when - t[i - 1]) / (t[i] - t[i - 1]);
  return y[i - 1] + s * (y[i] - y[i - 1]);
}

double time_of(const std::vector<double>& t, const std::vector<double>& y, double value) {
  for (std::size_t i = 1; i < t.size(); ++i) {
    if ((y[i - 1] - value) * (y[i] - value) <= 0.0) {
      return t[i - 1] + (value - y[i - 1]) / (y[i] - y[i - 1]) * (t[i] - t[i - 1]);
    }
  }
  return -1.0;
}

struct Curve {
  std::vector<double> day, volume, eta;
  std::vector<double> mechanics_day, centre_v;  // at the centre of the ball
};

Curve heal_sphere(double radius, const std::string& preset, double near = 0.002) {
  const Sphere s = make_sphere(radius, near);
  const auto model = healing::make_model(preset);
  Problem problem;
  problem.body = &s.body;
  problem.reference_nodes = s.mesh.points;
  problem.start = {s.mesh.points, {}};
  problem.species_points = s.mesh.points;
  problem.wound_fraction = s.wound;
  problem.model = model.get();
  std::size_t nu = 0;
  while (model->species()[nu].key != "nu") {
    ++nu;
  }
  std::size_t centre = 0;
  for (std::size_t v = 0; v < s.mesh.points.size(); ++v) {
    centre = norm(s.mesh.points[v]) < norm(s.mesh.points[centre]) ? v : centre;
  }
  Curve curve;
  const auto observe = [&](double day, std::span<const double> species, const mechanics::Shape&) {
    curve.mechanics_day.push_back(day);
    curve.centre_v.push_back(species[centre * model->species().size() + nu]);
  };
  Silent silent;
  const Result result = heal(
      problem, {}, [](const Checkpoint&) {}, observe, Context("heal", silent));
  for (const HistoryRow& row : result.history) {
    curve.day.push_back(row.species.t_day);
    curve.volume.push_back(row.volume_ratio);
    curve.eta.push_back(row.species.mean[0]);
  }
  return curve;
}

void expect_history(const Curve& curve, const std::filesystem::path& file) {
  auto reference = read_csv(file);
  double worst = 0.0;
  for (double day = 0.0; day <= 90.0; day += 0.5) {
    worst = std::max(worst, std::abs(at(curve.day, curve.volume, day) -
                                     at(reference["t_day"], reference["V_over_V0"], day)));
  }
  ::testing::Test::RecordProperty("worst_volume_ratio_difference", std::to_string(worst));
  EXPECT_LT(worst, 0.003);  // C4
  const double half = 0.5 * (1.0 + reference["V_over_V0"].back());
  EXPECT_NEAR(time_of(curve.day, curve.volume, half),
              time_of(reference["t_day"], reference["V_over_V0"], half), 0.7);  // C4
}

TEST(AHealingSphere, FollowsTheReferenceHistoryOfTheDefaultPreset) {
  SANATRIX_REQUIRE_SHARED("science/histories/timehist_R22_activator.csv");
  const Curve curve = heal_sphere(0.022, "vavourakis2016");
  expect_history(curve, shared_file);

  const double end = curve.volume.back();
  EXPECT_GE(end, 0.91);  // A1
  EXPECT_LE(end, 0.93);
  const auto gained = [&](double day) {
    return (1.0 - at(curve.day, curve.volume, day)) / (1.0 - end);
  };
  EXPECT_LE(gained(8.0), 0.30);  // A2
  EXPECT_GE(gained(16.0) - gained(8.0), 0.45);
  EXPECT_GE(gained(24.0), 0.95);
  EXPECT_GE(gained(30.0), 0.98);
  const double restored = time_of(curve.mechanics_day, curve.centre_v, 0.9);
  EXPECT_GE(restored, 45.0);  // A3
  EXPECT_LE(restored, 55.0);
  EXPECT_GE(at(curve.day, curve.eta, 30.0), 0.95);  // A4
}

TEST(AHealingSphere, FollowsTheReferenceHistoryOfTheInhibitor) {
  SANATRIX_REQUIRE_SHARED("science/histories/timehist_R22_inhibitor.csv");
  expect_history(heal_sphere(0.022, "vavourakis2016_inhibitor"), shared_file);
}

}  // namespace
}  // namespace sanatrix::recovery
