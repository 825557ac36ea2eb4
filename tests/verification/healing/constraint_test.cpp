// VALIDATION.md C3: healthy tissue stays as it is, and the paper's zeta = 0 makes it dip.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "geometry/structured_mesh.hpp"
#include "healing/reaction_diffusion.hpp"

namespace sanatrix::healing {
namespace {

constexpr double day = 86400.0;

TEST(HealthyTissue, StaysHealthyToRoundOffForAllPresets) {
  const TetMesh mesh = bar(6, 0.012, 0.002);
  const std::vector<double> no_wound(mesh.cells.size(), 0.0);
  Silent silent;
  for (const auto& preset : preset_names()) {
    const auto model = make_model(preset, std::vector<std::string>{"healthy_clamp=0"});
    ReactionDiffusion rd(mesh, mesh.points, no_wound, *model, {});
    rd.advance(90 * day, Context("heal", silent));
    for (std::size_t k = 0; k < rd.state().size(); ++k) {
      EXPECT_NEAR(rd.state()[k], k % 5 == 4 ? 0.0 : 1.0, 1e-13) << preset << ' ' << k;
    }
  }
}

TEST(HealthyTissue, DipsWhenTheRegulatorStartsAtZero) {
  const TetMesh mesh = bar(2, 0.004, 0.002);
  const std::vector<double> no_wound(mesh.cells.size(), 0.0);
  const auto model =
      make_model("vavourakis2016", std::vector<std::string>{"healthy_clamp=0", "zeta_init=0"});
  ReactionDiffusion rd(mesh, mesh.points, no_wound, *model, {});
  Silent silent;
  std::vector<double> times;
  for (int i = 1; i <= 40; ++i) {
    times.push_back(0.05 * i * day);
  }
  double least = 1.0, when = 0.0;
  rd.advance(2 * day, Context("heal", silent), times, [&] {
    if (rd.state()[0] < least) {
      least = rd.state()[0];
      when = rd.time_s() / day;
    }
  });
  EXPECT_NEAR(least, 0.987, 5e-4);  // printed with three digits
  EXPECT_NEAR(when, 0.5, 0.15);
  EXPECT_NEAR(rd.state()[0], 0.993, 5e-4);
  EXPECT_GT(least, 1.0 - (1.0 - 0.8) * 6.3e-6 / 8.3e-5);  // the bound (1 - h2) k / l
}

}  // namespace
}  // namespace sanatrix::healing
