// What mechanics knows about tissue and skin, per cell and per skin face. SI.
#pragma once

#include <string>

namespace sanatrix::mechanics {

/// Mooney-Rivlin tissue, Eq. (9) of doi:10.1371/journal.pone.0159766, with what healing does to it:
/// W = integrity [c1 (I1bar - 3) + c2 (I2bar - 3)] + kappa/2 (J - 1 + shrinkage)^2,
/// S_active = active_stress I.
struct Tissue {
  double c1 = 100.0, c2 = 100.0;  ///< [Pa]
  double kappa = 5e5;             ///< [Pa]
  double density = 950.0;         ///< in the reference configuration [kg/m3]
  double integrity = 1.0;         ///< 1 - damage, scales the isochoric part only
  double active_stress = 0.0;     ///< tau_f eta_f [Pa]
  double shrinkage = 0.0;         ///< 1 - J at which the pressure is zero
  double guard = 1.0;             ///< multiplies a P1/P1 cell's own share of kappa (ADR 3 and 18)
};

/// Veronda-Westmann membrane, Eq. (10): W = alpha (exp(beta (I1 - 3)) - 1) + c2 (I2 - 3).
struct Skin {
  double alpha = 3940.0;      ///< [Pa]
  double beta = 5.03;         ///< [-]
  double c2 = -9909.1;        ///< [Pa]; -alpha beta / 2, see models/tissue
  double thickness = 1.5e-3;  ///< [m]
  double density = 1100.0;    ///< [kg/m3]
  bool tension_field = true;  ///< relaxed energy: no compressive stress (Pipkin 1986)
};

/// A named set of tissue values: models/tissue/*.json, each value with status and source.
struct TissuePreset {
  std::string name;
  Tissue adipose, fibroglandular;
  Skin skin;
};
/// "vavourakis2016" (default) and the alternates of PARAMETERS.md section 3; Error{Input}
/// otherwise.
TissuePreset tissue_preset(const std::string& name);
/// Mixture by volume fraction: shear moduli and density by the arithmetic mean, the bulk modulus by
/// the harmonic mean (volume changes add up under a common pressure).
Tissue mix(const Tissue& a, const Tissue& b, double fraction_of_b);

}  // namespace sanatrix::mechanics
