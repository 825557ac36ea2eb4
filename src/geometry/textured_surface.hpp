// A surface with a photograph on it: what 3-D cameras deliver and what patients recognise.
#pragma once

#include <array>
#include <vector>

#include "geometry/tri_mesh.hpp"

namespace sanatrix {

/// Pixels of a photograph, top row first.
struct Photograph {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;  ///< 3 x width x height

  [[nodiscard]] bool empty() const { return rgb.empty(); }
  /// Bilinear colour at (u, v) in 0..1, v upwards as in OBJ files; clamped at the borders.
  [[nodiscard]] std::array<double, 3> at(double u, double v) const;
};

using TextureCorner = std::array<float, 2>;  ///< u to the right, v up
using Colour = std::array<float, 3>;         ///< red, green, blue; 0..255

struct TexturedSurface {
  TriMesh mesh;
  /// Per triangle; empty without a photograph. Corners of triangles without a photograph are NaN.
  std::vector<std::array<TextureCorner, 3>> corners;
  Photograph photograph;
  std::vector<Colour> point_colour;  ///< per point; empty when the scan has none

  [[nodiscard]] bool has_photograph() const { return !photograph.empty() && !corners.empty(); }
};

/// How the photograph lies on the surface seen from outside, by area: 1 as taken, -1 as in a
/// mirror, 0 without a photograph.
double photograph_sense(const TexturedSurface& surface);

/// The same surface with one texture coordinate per point: points on seams become several.
struct SeamlessSurface {
  TriMesh mesh;
  std::vector<TextureCorner> corner;  ///< per point
  std::vector<int> origin;            ///< point of the surface it comes from
};
SeamlessSurface split_at_seams(const TexturedSurface& surface);

}  // namespace sanatrix
