// The one formula that ties cells to mechanics.
#include <algorithm>

#include "core/error.hpp"
#include "recovery/recovery.hpp"

namespace sanatrix::recovery {

std::vector<mechanics::Tissue> healing_tissue(std::span<const mechanics::Tissue> healthy,
                                              std::span<const double> wound_fraction,
                                              std::span<const double> cell_density,
                                              const healing::WoundMechanics& wound) {
  ensure(healthy.size() == wound_fraction.size() && healthy.size() == cell_density.size(),
         "{} tissues, {} wound fractions, {} cell densities", healthy.size(), wound_fraction.size(),
         cell_density.size());
  std::vector<mechanics::Tissue> tissue(healthy.begin(), healthy.end());
  for (std::size_t c = 0; c < tissue.size(); ++c) {
    if (wound_fraction[c] <= 0.0) {
      continue;
    }
    // 1 - damage = eta/eta0; both the stiffness and the pull of a wound follow its cells.
    const double cells = std::max(cell_density[c], 0.0);
    const double integrity = std::clamp(cells, wound.integrity_floor, 1.0);
    mechanics::Tissue scar = healthy[c];
    scar.c1 = wound.c1;
    scar.c2 = wound.c2;
    scar.kappa = wound.kappa;
    scar.active_stress = wound.active_stress * cells;
    mechanics::Tissue mixed = mechanics::mix(healthy[c], scar, wound_fraction[c]);
    // Wound and healthy share carry the same pressure, and their volume changes add up: the mixture
    // shrinks by f T/kappa_wound. Its own traction f T does f T/kappa_mixed of that.
    mixed.shrinkage = mixed.active_stress * (1.0 / wound.kappa - 1.0 / mixed.kappa);
    // Of the mixture's full stiffness, the wounded share has only `integrity`.
    const double wounded = wound_fraction[c] * (scar.c1 + scar.c2) / (mixed.c1 + mixed.c2);
    mixed.integrity = 1.0 - wounded * (1.0 - integrity);
    tissue[c] = mixed;
  }
  return tissue;
}

}  // namespace sanatrix::recovery
