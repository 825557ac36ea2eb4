// Noise of a scanned surface, measured on it, and smoothed away without shrinking what is smooth.
#pragma once

#include "geometry/tri_mesh.hpp"

namespace sanatrix {

/// Standard deviation [m] of each point's distance from a smooth surface, independent from point to
/// point: what bends the surface from one triangle to the next, seen along the normal. A smooth
/// surface of radius R and edges h leaves about h^4 / R^3 of its own.
double noise_of(const TriMesh& surface);

/// Taubin's low-pass filter (1995, doi:10.1145/218380.218473), `rounds` times one step in and one
/// out again; points on borders move along them. What is much longer than the edges stays.
TriMesh smoothed(TriMesh surface, int rounds);

/// The noise that may stay [m]: half of what the skin of the usual mesh may be away from its
/// labels.
inline constexpr double harmless_noise_m = 0.00025;
/// What `noise_m` demands: 0 for harmless noise, and for surfaces so coarse that bends between
/// triangles are their shape.
int rounds_for(const TriMesh& surface, double noise_m);

}  // namespace sanatrix
