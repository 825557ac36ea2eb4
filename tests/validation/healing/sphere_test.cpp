// VALIDATION.md C4, C11 and A2-A6: spherical wounds against the reference histories, and how little
// the mesh matters to them.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "geometry/structured_mesh.hpp"
#include "healing/reaction_diffusion.hpp"
#include "shared_data.hpp"

namespace sanatrix::healing {
namespace {

constexpr double day = 86400.0;
using Columns = std::map<std::string, std::vector<double>>;

Columns read_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(in, line);
  std::erase(line, '\r');
  for (std::istringstream row(line); std::getline(row, cell, ',');) {
    names.push_back(cell);
  }
  Columns columns;
  while (std::getline(in, line)) {
    std::istringstream row(line);
    for (const auto& name : names) {
      std::getline(row, cell, ',');
      columns[name].push_back(std::stod(cell));
    }
  }
  return columns;
}

/// Value of a column at a time, interpolated.
double at(const Columns& c, const std::string& name, double t) {
  const auto& times = c.at("t_day");
  const auto& values = c.at(name);
  const auto next = std::ranges::lower_bound(times, t) - times.begin();
  if (next == 0) {
    return values.front();
  }
  const double share = (t - times[next - 1]) / (times[next] - times[next - 1]);
  return values[next - 1] + share * (values[next] - values[next - 1]);
}

/// First time a rising column reaches a level.
double time_of(const Columns& c, const std::string& name, double level) {
  const auto& times = c.at("t_day");
  const auto& values = c.at(name);
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] >= level) {
      return times[i - 1] +
             (level - values[i - 1]) / (values[i] - values[i - 1]) * (times[i] - times[i - 1]);
    }
  }
  return std::numeric_limits<double>::infinity();
}

/// 90 days of a spherical wound in a ball of three times its radius, restarted every 6 days as
/// recovery does, recorded every half day.
Columns history(const std::string& preset, double radius, int layers) {
  const TetMesh mesh = ball_octant(graded_radii(radius, layers, 3.0 * radius, 1.4));
  const auto fraction = cells_where(mesh, [=](const Vec3& p) { return norm(p) < radius; });
  const auto model = make_model(preset, std::vector<std::string>{"zeta_init=0"});
  ReactionDiffusion rd(mesh, mesh.points, fraction, *model, {});
  Silent silent;
  Columns c;
  const auto add = [&] {
    const SpeciesRecord r = record(rd, mesh, mesh.points, fraction, *model);
    c["t_day"].push_back(r.t_day);
    c["zeta_far"].push_back(r.far_field_second);
    for (std::size_t s = 0; s < r.mean.size(); ++s) {
      c[model->species()[s].key + "_mean"].push_back(r.mean[s]);
      // The centre of the ball, not of the octant.
      c[model->species()[s].key + "_centre"].push_back(rd.state()[s]);
    }
  };
  for (int step = 0; step < 15; ++step) {
    std::vector<double> times;
    for (double t = 6.0 * step; t < 6.0 * (step + 1); t += 0.5) {
      times.push_back(t * day);
    }
    rd.advance(6.0 * (step + 1) * day, Context("heal", silent), times, add);
  }
  add();
  return c;
}

double greatest_difference(const Columns& a, const Columns& b, const std::string& name,
                           double from_day = 0.0) {
  double most = 0.0;
  for (double t = from_day; t <= 90.0; t += 0.5) {
    most = std::max(most, std::abs(at(a, name, t) - at(b, name, t)));
  }
  return most;
}

struct SphereCase {
  std::string name, preset;
  double radius;
};

class ASphericalWound : public ::testing::TestWithParam<SphereCase> {};
INSTANTIATE_TEST_SUITE_P(Reference, ASphericalWound,
                         ::testing::Values(SphereCase{"R20_activator", "vavourakis2016", 0.020},
                                           SphereCase{"R22_activator", "vavourakis2016", 0.022},
                                           SphereCase{"R22_inhibitor", "vavourakis2016_inhibitor",
                                                      0.022}),
                         [](const auto& parameter) { return parameter.param.name; });

TEST_P(ASphericalWound, FollowsItsReferenceHistory) {
  SANATRIX_REQUIRE_SHARED("science/histories/timehist_" + GetParam().name + ".csv");
  const Columns reference = read_csv(shared_file);
  const int layers = static_cast<int>(std::round(GetParam().radius / 0.002));  // h = 2 mm
  const Columns ours = history(GetParam().preset, GetParam().radius, layers);
  // C4 allows 0.003 in V/V0, which is 0.0803 times the mean cell density: 0.037; and 0.7 d.
  EXPECT_LT(greatest_difference(ours, reference, "eta_mean"), 0.02);
  EXPECT_NEAR(time_of(ours, "eta_mean", 0.5), time_of(reference, "eta_mean", 0.5), 0.25);
  // A day passes until the layer next to healthy tissue, thinner than a cell, is resolved; that of
  // the regulator (1.2 mm) never is, but its integral grows with the cells.
  EXPECT_LT(greatest_difference(ours, reference, "nu_mean", 1.0), 0.02);
  EXPECT_LT(greatest_difference(ours, reference, "xi_mean", 1.0), 0.02);
  EXPECT_LT(greatest_difference(ours, reference, "zeta_mean", 1.0), 0.06);
  EXPECT_LT(greatest_difference(ours, reference, "mu_mean", 1.0), 0.25);
  EXPECT_NEAR(time_of(ours, "nu_centre", 0.9), time_of(reference, "nu_centre", 0.9), 2.0);
  // The reference's own steps of 300 s leave 0.0012 at half a day: exact is 1 - exp(-l t) = 0.9722.
  EXPECT_LT(greatest_difference(ours, reference, "zeta_far", 0.5), 2e-3);
}

TEST(TheDefaultPreset, HealsAsThePaperDescribes) {
  const Columns c = history("vavourakis2016", 0.022, 8);
  // A2: the contraction follows the mean cell density, PARAMETERS.md section 4.
  EXPECT_LE(at(c, "eta_mean", 8.0), 0.30);
  EXPECT_GE(at(c, "eta_mean", 16.0) - at(c, "eta_mean", 8.0), 0.45);
  EXPECT_GE(at(c, "eta_mean", 24.0), 0.95);
  EXPECT_GE(at(c, "eta_mean", 30.0), 0.98);       // and A4
  EXPECT_GE(time_of(c, "nu_centre", 0.9), 45.0);  // A3: capillaries after about 50 d
  EXPECT_LE(time_of(c, "nu_centre", 0.9), 55.0);
  for (const char* species : {"eta_mean", "nu_mean", "xi_mean"}) {  // A5
    EXPECT_NEAR(at(c, species, 90.0), 1.0, 0.02) << species;
  }
  // A6: activator and inhibitor recover alike, 0.01 in V/V0.
  const Columns inhibitor = history("vavourakis2016_inhibitor", 0.022, 8);
  EXPECT_LT(0.0803 * greatest_difference(c, inhibitor, "eta_mean"), 0.01);
}

TEST(TheClinicalPreset, FillsTheWoundAsItWasCalibrated) {
  SANATRIX_REQUIRE_SHARED("science/histories/timehist_clinical_kader.csv");
  const Columns reference = read_csv(shared_file);
  const Columns ours = history("clinical_kader", 0.0245, 8);
  EXPECT_LT(greatest_difference(ours, reference, "eta_mean", 0.5), 0.03);
}

// C11: with interface vertices clamped at eta0 the mean would begin at 0.14 on 2 mm and 0.27 on
// 4.4 mm, and with free ones t50 would shift by 0.9 d; the exchange with healthy tissue across the
// wound's surface leaves neither.
TEST(TheInterface, BringsNoSpuriousCellsAndHardlyAnyDelayOnCoarseMeshes) {
  const Columns reference = history("vavourakis2016", 0.022, 11);
  for (const int layers : {3, 5, 8}) {  // h = 7.3, 4.4, 2.8 mm
    const Columns c = history("vavourakis2016", 0.022, layers);
    EXPECT_NEAR(c.at("eta_mean").front(), 0.01, 1e-14) << layers;
    EXPECT_NEAR(time_of(c, "eta_mean", 0.5), time_of(reference, "eta_mean", 0.5), 0.2) << layers;
  }
}

}  // namespace
}  // namespace sanatrix::healing
