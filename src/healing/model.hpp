// A healing model is a list of species and one local source term. Diffusion, time stepping,
// coupling and output are written once and never see which model they run.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sanatrix::healing {

/// Scaled so that the value in healthy tissue at rest is of order 1.
struct Species {
  std::string key;       ///< "eta": prefix of its history columns
  std::string label;     ///< "cell density"
  double healthy;        ///< initial and clamped value outside the wound
  double wounded;        ///< initial value inside the wound
  bool clamped_outside;  ///< held at `healthy` strictly outside the wound
  double diffusivity;    ///< [m2/s]
};

/// What a wound asks of mechanics; values [Pa], Eq. (9) and S_active = tau_f eta_f I of
/// doi:10.1371/journal.pone.0159766.
struct WoundMechanics {
  double c1, c2;           ///< Mooney-Rivlin at full integrity
  double kappa;            ///< drained bulk modulus
  double active_stress;    ///< T0 = tau_f alpha_f eta0_f, at eta = eta0
  double integrity_floor;  ///< lower bound of eta/eta0
};

class Model {
 public:
  virtual ~Model() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;    ///< "vavourakis2016"
  [[nodiscard]] virtual std::string_view source() const = 0;  ///< citation
  [[nodiscard]] virtual std::span<const Species> species() const = 0;
  /// Source term for a batch of points. q, dq: points x species; jac (may be empty): points x
  /// species x species, row-major, d(dq_i)/d(q_j); wound: one flag in [0,1] per point. [1/s]
  virtual void source(std::span<const double> q, std::span<const double> wound,
                      std::span<double> dq, std::span<double> jac) const = 0;
  /// Cells relative to healthy tissue, eta/eta0, of one point: what mechanics asks for.
  [[nodiscard]] virtual double cells(std::span<const double> q) const = 0;
  [[nodiscard]] virtual const WoundMechanics& mechanics() const = 0;
  /// Throws Error{Internal} unless the healthy state is steady (PARAMETERS.md section 1).
  virtual void check_steady_state() const = 0;
};

/// Names of the built-in presets: vavourakis2016, vavourakis2016_inhibitor, clinical_kader.
std::vector<std::string> preset_names();
/// Error{Input} listing the known names when there is no such preset. Overrides are "key=value"
/// with the keys of models/healing/*.json, e.g. "D_eta=4e-13".
std::unique_ptr<Model> make_model(const std::string& preset,
                                  std::span<const std::string> overrides = {});

}  // namespace sanatrix::healing
