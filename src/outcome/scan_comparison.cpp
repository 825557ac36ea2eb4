#include "outcome/scan_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::vector<double> signed_distances(const TriMesh& from, const TriMesh& to, double least_cosine) {
  const ScanTarget target(to);
  const std::vector<Vec3> normals = vertex_normals(from);
  std::vector<double> distances;
  distances.reserve(from.points.size());
  for (std::size_t v = 0; v < from.points.size(); ++v) {
    const auto hit = target.closest(from.points[v]);
    const double sign = dot(hit.point - from.points[v], hit.normal) < 0 ? -1.0 : 1.0;
    const bool comparable =
        dot(hit.normal, normals[v]) >= least_cosine && !target.ends_near(from.points[v], hit);
    distances.push_back(comparable ? sign * hit.distance : nothing);
  }
  return distances;
}

SurfaceDistance distance_statistics(const TriMesh& surface, std::span<const double> distance,
                                    const std::vector<bool>& chosen) {
  ensure(distance.size() == surface.points.size() && chosen.size() == surface.points.size(),
         "{} distances and {} choices for {} vertices", distance.size(), chosen.size(),
         surface.points.size());
  const std::vector<double> areas = vertex_areas(surface);
  std::vector<double> values, weights;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    if (chosen[v] && std::isfinite(distance[v]) && areas[v] > 0) {
      values.push_back(std::abs(distance[v]));
      weights.push_back(areas[v]);
    }
  }
  if (values.empty()) {
    return {nothing, nothing, nothing, nothing, nothing, nothing, 0};
  }
  return statistics(values, weights);
}

std::vector<double> smoothed(const TriMesh& surface, std::span<const double> values,
                             double radius_m) {
  const std::vector<double> areas = vertex_areas(surface);
  const auto cube_of = [&](const Vec3& p) {
    std::array<long, 3> cube;
    for (std::size_t k = 0; k < 3; ++k) {
      cube[k] = std::lround(p[k] / radius_m);
    }
    return cube;
  };
  const auto key = [](const std::array<long, 3>& c) {
    return static_cast<std::uint64_t>(c[0] & 0x1fffff) << 42 |
           static_cast<std::uint64_t>(c[1] & 0x1fffff) << 21 |
           static_cast<std::uint64_t>(c[2] & 0x1fffff);
  };
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cubes;
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    if (std::isfinite(values[v])) {
      cubes[key(cube_of(surface.points[v]))].push_back(v);
    }
  }
  std::vector<double> result(values.begin(), values.end());
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    if (!std::isfinite(values[v])) {
      continue;
    }
    const std::array<long, 3> centre = cube_of(surface.points[v]);
    double sum = areas[v] * values[v], weight = areas[v];
    for (long i = -1; i <= 1; ++i) {
      for (long j = -1; j <= 1; ++j) {
        for (long k = -1; k <= 1; ++k) {
          const auto near = cubes.find(key({centre[0] + i, centre[1] + j, centre[2] + k}));
          if (near == cubes.end()) {
            continue;
          }
          for (const std::size_t w : near->second) {
            if (w != v && norm(surface.points[w] - surface.points[v]) <= radius_m) {
              sum += areas[w] * values[w];
              weight += areas[w];
            }
          }
        }
      }
    }
    result[v] = weight > 0 ? sum / weight : values[v];
  }
  return result;
}

Retraction retraction(const TriMesh& surface, std::span<const double> inward,
                      const std::vector<bool>& chosen, double smoothing_m) {
  const std::vector<double> areas = vertex_areas(surface);
  const std::vector<double> smooth = smoothed(surface, inward, smoothing_m);
  Retraction result;
  std::vector<double> values, weights;
  for (std::size_t v = 0; v < smooth.size(); ++v) {
    if (!chosen[v] || !std::isfinite(smooth[v])) {
      continue;
    }
    values.push_back(std::max(smooth[v], 0.0));
    weights.push_back(areas[v]);
    if (result.vertex < 0 || smooth[v] > result.depth_m) {
      result.depth_m = smooth[v];
      result.vertex = static_cast<int>(v);
    }
    result.area_3mm_m2 += smooth[v] > 0.003 ? areas[v] : 0.0;
    result.area_5mm_m2 += smooth[v] > 0.005 ? areas[v] : 0.0;
  }
  result.depth_m = std::max(result.depth_m, 0.0);
  if (!values.empty()) {
    result.p95_m = statistics(values, weights).p95;
  }
  return result;
}

std::vector<double> histogram(const TriMesh& surface, std::span<const double> distance,
                              const std::vector<bool>& chosen, double bin_m, std::size_t bins) {
  const std::vector<double> areas = vertex_areas(surface);
  std::vector<double> shares(bins, 0.0);
  double total = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    if (chosen[v] && std::isfinite(distance[v])) {
      const auto bin = static_cast<std::size_t>(std::abs(distance[v]) / bin_m);
      shares[std::min(bin, bins - 1)] += areas[v];
      total += areas[v];
    }
  }
  for (double& share : shares) {
    share = total > 0 ? share / total : 0.0;
  }
  return shares;
}

}  // namespace sanatrix::outcome
