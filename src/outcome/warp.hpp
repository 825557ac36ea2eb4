// The smooth bending that brings the patient's skin onto her scan, and what it carries: texture to
// the model, predicted displacements to the scan. docs/theory/outcome.md, section 2
#pragma once

#include <span>

#include "geometry/textured_surface.hpp"

namespace sanatrix::outcome {

struct Warp {
  TriMesh surface;        ///< the patient's skin, bent onto the scan; same vertices
  double median_m = 0.0;  ///< distance from the scan that is left, where there is one
};
/// Bends `skin` onto `scan` (both in the patient's frame): point-to-plane distances plus a membrane
/// energy of the displacement, ever softer (non-rigid ICP, Amberg et al. 2007,
/// doi:10.1109/CVPR.2007.383165). Skin without counterpart on the scan follows its neighbours.
Warp warp_onto(const TriMesh& skin, const TriMesh& scan);

/// Displacement at every point of the scan from displacements of the bent skin's vertices; fades
/// out within `fade_m` beside the skin, so that the scan stays whole where the model ends.
std::vector<Vec3> carry_to_scan(const Warp& warp, std::span<const Vec3> displacement,
                                const TriMesh& scan, double fade_m = 0.03);

/// A photograph for `skin` (any pose of the warped skin), taken from the scan through the warp.
/// Every triangle has its own place in it. Holes of the scan are filled from their surroundings.
TexturedSurface carry_texture(const Warp& warp, const TexturedSurface& scan, const TriMesh& skin,
                              int side_pixels = 1024);
/// For patients without a scan: even skin with areolae of the usual size around the nipples
/// (diameter 38 mm, Sanuki et al. 2009, doi:10.1007/s00266-008-9285-z).
TexturedSurface clay(const TriMesh& skin, const std::array<Vec3, 2>& nipple,
                     int side_pixels = 1024);

}  // namespace sanatrix::outcome
