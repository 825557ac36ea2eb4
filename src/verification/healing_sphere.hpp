// A spherical wound that heals in a ball of healthy tissue: the common ground of C4, C11, A1-A6 and
// the clinical curves.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/tet_mesh.hpp"
#include "healing/reaction_diffusion.hpp"
#include "mechanics/problem.hpp"
#include "verification/radial_wound.hpp"

namespace sanatrix::verification {

/// A quantity in time.
struct History {
  std::vector<double> day, value;
  [[nodiscard]] double at(double when) const;        ///< interpolated
  [[nodiscard]] double time_of(double level) const;  ///< first crossing; NaN when there is none
};

struct SphereHealing {
  History eta, nu, xi;                    ///< means over the wound
  History centre_nu;                      ///< at the centre
  History zeta_far;                       ///< regulator far away
  History volume;                         ///< V/V0; empty when mechanics did not run
  std::map<double, RadialProfile> cells;  ///< at every mechanics step, by day
};

/// Around the wound.
inline constexpr mechanics::Tissue healthy_tissue{112.5, 112.5, 5e5, 1000.0, 1.0, 0.0};

/// The octant of a wound of `radius` with `layers` layers of cells in a ball of three times that.
TetMesh wounded_ball(double radius, int layers);
/// The same with cells of `thinnest` on both sides of the wall that grow by `growth` away from it:
/// the layer in which cells invade is thinner than a uniform mesh resolves.
TetMesh ball_with_fine_wall(double radius, double thinnest, double growth);
std::vector<double> wound_of(const TetMesh& mesh, double radius);

/// Species only, restarted every 6 days as recovery does.
SphereHealing heal_species(const std::string& preset, double radius, int layers, double days,
                           const Context& ctx);
/// Species and mechanics, as `recovery` couples them, in a mesh of a wounded ball.
SphereHealing heal_body(const std::string& preset, const TetMesh& mesh, double radius, double days,
                        const Context& ctx, mechanics::Element element = mechanics::Element::P1P1);

}  // namespace sanatrix::verification
