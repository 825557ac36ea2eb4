#include "healing/five_species.hpp"

#include <cmath>

#include "core/error.hpp"
#include "healing/jet.hpp"

namespace sanatrix::healing {

FiveSpecies::FiveSpecies(const Parameters& parameters) : p_(parameters), d_{} {
  d_.h1 = (1.0 - p_.h2) * (1.0 + p_.chi * p_.chi) / (2.0 * p_.chi);
  d_.k_zeta = p_.k / (mitosis(1.0) * p_.eta0);
  d_.l_eta = p_.l * p_.zeta0 / p_.eta0;
  d_.lambda_o = p_.lambda / p_.v0;
}

FiveSpecies FiveSpecies::from(Values& v) {
  const bool activator = v.word("regulation", {"activator", "inhibitor"}) == "activator";
  return FiveSpecies({
      .regulation = activator ? Regulation::Activator : Regulation::Inhibitor,
      .eta0 = v.positive("eta0"),
      .zeta0 = v.positive("zeta0"),
      .v0 = v.positive("v0"),
      .mu0 = v.positive("mu0"),
      .eta_init = v.number("eta_init", 0.0, 1.0),
      .zeta_init = v.number("zeta_init", 0.0, 1.0),
      .xi_init = v.number("xi_init", 0.0, 1.0),
      .healthy_clamp = v.number("healthy_clamp", 0.0, 1.0) > 0.5,
      .d_eta = v.number("D_eta", 0.0),
      .d_zeta = v.number("D_zeta", 0.0),
      .d_v = v.number("D_v", 0.0),
      .d_xi = v.number("D_xi", 0.0),
      .d_mu = v.number("D_mu", 0.0),
      .k = v.positive("k"),
      .chi = v.positive("chi"),
      .h2 = v.number("h2", std::nextafter(0.5, 1.0), 1.0),  // at 1/2 no wound can start to heal
      .h0 = v.number("h0", 1.0),
      .l = v.positive("l"),
      .beta_v0 = v.number("beta_v0", 0.0),
      .lambda = v.positive("lambda"),
      .xi_tilde = v.number("xi_tilde", 1e-6, 1.0),  // above 1 healthy tissue would starve
      .xi_hat = v.number("xi_hat", 1e-6, 1.0),      // above 1 healthy tissue would sprout
      .phi = v.positive("phi"),
      .phi_xi = v.number("phi_xi", 0.0),
      .wound = {.c1 = v.number("c1_wound", 0.0),
                .c2 = v.number("c2_wound", 0.0),
                .kappa = v.positive("kappa_wound"),
                .active_stress = v.number("T0", 0.0),
                .integrity_floor = v.number("integrity_floor", 1e-9, 1.0)},
  });
}

std::array<Species, FiveSpecies::n> FiveSpecies::species() const {
  const bool clamp = p_.healthy_clamp;
  return {{
      {"eta", "cell density", 1.0, p_.eta_init, clamp, p_.d_eta},
      {"zeta", "mitosis regulator", p_.zeta_init, 0.0, false, p_.d_zeta},
      {"nu", "capillary density", 1.0, 0.0, clamp, p_.d_v},
      {"xi", "oxygen", 1.0, p_.xi_init, clamp, p_.d_xi},
      {"mu", "macrophage-derived growth factor", 0.0, 0.0, false, p_.d_mu},
  }};
}

void FiveSpecies::check() const {
  ensure(p_.xi_tilde <= 1.0 && p_.xi_hat <= 1.0,
         "oxygen thresholds {} and {} must not exceed the healthy level 1", p_.xi_tilde, p_.xi_hat);
  const Jet<1> s = mitosis(Jet<1>::variable(1.0, 0));
  ensure(s.slope[0] < s.value, "healthy tissue is unstable: zeta0 S'(zeta0) = {} >= S(zeta0) = {}",
         s.slope[0], s.value);
  const double fresh = mitosis(0.0);
  ensure(fresh > 0.5 * mitosis(1.0),
         "a wound cannot start to heal: S(0) = {} is not above half of S(zeta0)", fresh);
}

}  // namespace sanatrix::healing
