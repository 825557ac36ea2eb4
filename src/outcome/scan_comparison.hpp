// How far a predicted surface is from a scan: the paper's Table 1 and Fig 9.
#pragma once

#include <span>
#include <vector>

#include "outcome/outcome.hpp"

namespace sanatrix::outcome {

/// Signed distances from the vertices of one surface to another, positive outwards of the first;
/// NaN where the other ends or has a hole, or where its nearest place looks another way (a smaller
/// cosine between the normals than `least_cosine`; -1 leaves nothing out, as errors must not be).
std::vector<double> signed_distances(const TriMesh& from, const TriMesh& to,
                                     double least_cosine = 0.3);

/// Statistics of |distance| over the chosen vertices that have one; weighted by area. `samples` is
/// 0, and the rest NaN, when there are none.
SurfaceDistance distance_statistics(const TriMesh& surface, std::span<const double> distance,
                                    const std::vector<bool>& chosen);

/// What a dent is: how deep the second surface lies below the first.
struct Retraction {
  double depth_m = 0.0;      ///< deepest place, as the mean over `smoothing_m` around it
  double p95_m = 0.0;        ///< 95th percentile of the inward distance
  double area_3mm_m2 = 0.0;  ///< deeper than 3 mm
  double area_5mm_m2 = 0.0;
  int vertex = -1;  ///< deepest
};
/// `inward` per vertex, positive where the surface has gone in; NaN is left out.
Retraction retraction(const TriMesh& surface, std::span<const double> inward,
                      const std::vector<bool>& chosen, double smoothing_m = 0.003);

/// Mean over the vertices within a distance of each, weighted by area; NaN stays NaN.
std::vector<double> smoothed(const TriMesh& surface, std::span<const double> values,
                             double radius_m);

/// Share of the area per bin of |distance|, for the histogram of Fig 9.
std::vector<double> histogram(const TriMesh& surface, std::span<const double> distance,
                              const std::vector<bool>& chosen, double bin_m, std::size_t bins);

}  // namespace sanatrix::outcome
