// Cells, mitosis regulator, capillaries, oxygen and macrophage-derived growth factor: Eqs. (2)-(6)
// of doi:10.1371/journal.pone.0159766, scaled by the healthy values.
#pragma once

#include <array>
#include <cstddef>

#include "healing/model.hpp"
#include "healing/values.hpp"

namespace sanatrix::healing {

class FiveSpecies {
 public:
  static constexpr std::size_t n = 5;
  enum Index : std::size_t { Eta, Zeta, Nu, Xi, Mu };
  enum class Regulation { Activator, Inhibitor };

  /// Values as in models/healing/*.json, SI; what they mean and where they come from stands there.
  struct Parameters {
    Regulation regulation;
    double eta0, zeta0, v0, mu0;
    double eta_init, zeta_init, xi_init;
    bool healthy_clamp;
    double d_eta, d_zeta, d_v, d_xi, d_mu;
    double k, chi, h2, h0, l, beta_v0, lambda, xi_tilde, xi_hat, phi, phi_xi;
    WoundMechanics wound;
  };
  /// Constants that follow from the healthy state being steady.
  struct Derived {
    double k_zeta;    ///< k = k_zeta S(zeta0) eta0 [m3/(cell s)]
    double h1;        ///< S(zeta0) = 1 for the activator [-]
    double l_eta;     ///< l_eta eta0 = l zeta0 [kg/(cell s)]
    double lambda_o;  ///< lambda_o v0 = lambda [m/s]
  };

  explicit FiveSpecies(const Parameters& parameters);
  static FiveSpecies from(Values& values);

  [[nodiscard]] std::array<Species, n> species() const;
  [[nodiscard]] std::array<double, n> rest() const { return {1.0, 1.0, 1.0, 1.0, 0.0}; }
  [[nodiscard]] double cells(const std::array<double, n>& q) const { return q[Eta]; }
  [[nodiscard]] WoundMechanics mechanics() const { return p_.wound; }
  [[nodiscard]] const Derived& derived() const { return d_; }
  /// The inequalities that keep healthy tissue stable and let a wound start to heal.
  void check() const;

  /// S(zeta/zeta0), after Eq. (1).
  template <class T>
  [[nodiscard]] T mitosis(const T& zeta) const {
    if (p_.regulation == Regulation::Activator) {
      return 2.0 * d_.h1 * p_.chi * zeta / (p_.chi * p_.chi + zeta * zeta) + p_.h2;
    }
    return ((p_.h0 - 1.0) * zeta + p_.h0) / (2.0 * (p_.h0 - 1.0) * zeta + 1.0);
  }

  template <class T>
  [[nodiscard]] std::array<T, n> source(const std::array<T, n>& q, double wound) const {
    const auto& [eta, zeta, nu, xi, mu] = q;
    const T zero(0.0), one(1.0);
    // Growth needs something that grows: below zero (round-off, overshoot at a sharp front) the
    // logistic terms would run away instead of coming back.
    const T cells = eta < 0.0 ? zero : eta;
    const T capillaries = nu < 0.0 ? zero : nu;
    const T growth = xi < p_.xi_tilde ? xi / p_.xi_tilde : one;  // K / k_zeta, Eq. (6)
    const T release = xi < p_.xi_hat ? wound * (one - xi / p_.xi_hat) : zero;  // Q, Eq. (5)
    const T sprouting = 3.0 * mu / (2.0 + mu);                                 // H, Eq. (3)
    return {d_.k_zeta * p_.eta0 * (growth * mitosis(zeta) * cells * (2.0 - cells)) - p_.k * eta,
            p_.l * (eta - zeta),  // Eq. (2), l_eta eta0 = l zeta0
            p_.beta_v0 * (sprouting * capillaries * (1.0 - capillaries)),  // Eq. (3)
            p_.lambda * (nu - xi),                        // Eq. (4), lambda_o v0 = lambda
            p_.phi_xi / p_.mu0 * release - p_.phi * mu};  // Eq. (5)
  }

 private:
  Parameters p_;
  Derived d_;
};

}  // namespace sanatrix::healing
