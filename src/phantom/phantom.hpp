// The built-in digital twin: a synthetic patient whose unloaded, supine and upright shapes, and
// that after surgery, are known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::phantom {

enum class Density { Fatty, Scattered, Heterogeneous, Dense };
Density parse_density(const std::string& name);  ///< Error{Usage} otherwise

struct Options {
  std::uint64_t seed = 1;
  double volume_cm3 = 600.0;  ///< of one breast, unloaded; 150..1500
  Density density = Density::Scattered;
  double edge_m = 0.012;  ///< of the truth's mesh in the breasts of a 600 cm3 patient
  double voxel_mm = 1.0;
};

/// The skin of the P2 solutions with its curvature: finer than the mesh. [m]
struct TrueSkin {
  TriMesh unloaded, prone, supine, upright;
  TriMesh upright_after;  ///< surgery and complete healing (phantom/scar); same vertices
};

struct Phantom {
  LabelImage labels;                         ///< prone, 1 mm
  TetMesh mesh;                              ///< the truth's mesh, vertices in the unloaded shape
  std::vector<Vec3> prone, supine, upright;  ///< vertex positions of the P2/P1 solutions [m]
  TrueSkin skin;
  double excised_m3 = 0.0;             ///< by the plan, of the prone body
  std::vector<double> fibroglandular;  ///< per cell
  std::string plan_json;               ///< as for shared plans, prone frame
};
Phantom make_phantom(const Options& options, const Context& ctx);

}  // namespace sanatrix::phantom
