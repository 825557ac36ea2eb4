// glTF 2.0 binary: a textured surface with morph targets, for viewers, web pages and phones.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/textured_surface.hpp"

namespace sanatrix::io {

struct MorphTarget {
  std::string name;          ///< "3 months after surgery"
  std::vector<Vec3> points;  ///< of the surface's mesh, moved [m]
};

/// Metres, y up, z towards the viewer, as glTF wants it: LPS (x, y, z) becomes (x, z, -y). An
/// animation goes through the targets one by one; `seconds` in all. The file says in `extras` that
/// it is for research only and which axes it had.
void write_glb(const TexturedSurface& surface, const std::vector<MorphTarget>& targets,
               const std::filesystem::path& file, double seconds = 4.0);

}  // namespace sanatrix::io
