// VALIDATION.md C3: healthy tissue stays as it is, and the paper's zeta = 0 makes it dip.
#include <algorithm>
#include <cmath>

#include "geometry/structured_mesh.hpp"
#include "healing/reaction_diffusion.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

constexpr double day = 86400.0;

Findings healthy_tissue(const Context& ctx) {
  Findings found;
  const TetMesh mesh = bar(6, 0.012, 0.002);
  const std::vector<double> no_wound(mesh.cells.size(), 0.0);
  for (const auto& preset : healing::preset_names()) {
    const auto model = healing::make_model(preset, std::vector<std::string>{"healthy_clamp=0"});
    healing::ReactionDiffusion rd(mesh, mesh.points, no_wound, *model, {});
    rd.advance(90 * day, ctx);
    double most = 0.0;
    for (std::size_t k = 0; k < rd.state().size(); ++k) {
      most = std::max(most, std::abs(rd.state()[k] - (k % 5 == 4 ? 0.0 : 1.0)));
    }
    found.checks.push_back(
        within("drift of " + preset + " in 90 days", 0.0, 1e-13, most, "", "round-off only"));
  }
  return found;
}

Findings dip(const Context& ctx) {
  const TetMesh mesh = bar(2, 0.004, 0.002);
  const std::vector<double> no_wound(mesh.cells.size(), 0.0);
  const auto model = healing::make_model(
      "vavourakis2016", std::vector<std::string>{"healthy_clamp=0", "zeta_init=0"});
  healing::ReactionDiffusion rd(mesh, mesh.points, no_wound, *model, {});
  std::vector<double> times;
  for (int i = 1; i <= 40; ++i) {
    times.push_back(0.05 * i * day);
  }
  double least = 1.0;
  double when = 0.0;
  rd.advance(2 * day, ctx, times, [&] {
    if (rd.state()[0] < least) {
      least = rd.state()[0];
      when = rd.time_s() / day;
    }
  });
  Findings found;
  found.checks.push_back(
      near("smallest eta/eta0", 0.987, least, 5e-4, "", "reference given with three digits"));
  found.checks.push_back(near("day of the minimum", 0.5, when, 0.15, "d", "flat minimum"));
  found.checks.push_back(
      near("eta/eta0 after 2 days", 0.993, rd.state()[0], 5e-4, "", "three digits"));
  found.checks.push_back(within("minimum above the bound 1 - (1 - h2) k/l",
                                1.0 - (1.0 - 0.8) * 6.3e-6 / 8.3e-5, 1.0, least, "",
                                "exact bound"));
  return found;
}

}  // namespace

void add_healthy_tissue(std::vector<Case>& cases) {
  cases.push_back(
      {"healthy-tissue", "Healthy tissue is steady (C3)", Chapter::CodeVerification, Cost::Fast,
       "Uniform healthy tissue, all presets, without clamping, for 90 days.", healthy_tissue});
  cases.push_back({"healthy-dip", "The dip of a regulator that starts at zero (C3)",
                   Chapter::CodeVerification, Cost::Fast,
                   "The paper's zeta(0) = 0 contradicts its healthy state; reference computed "
                   "independently.",
                   dip});
}

}  // namespace sanatrix::verification
