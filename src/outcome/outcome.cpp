// Volumes, displacements and surface distances, all weighted by what each vertex stands for.
#include "outcome/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

constexpr double cm3 = 1e6, mm = 1e3;  // per m3, per m

struct Sample {
  double value, weight;
};

/// Smallest value that at least the given share of the weight does not exceed; samples ascending.
double percentile(const std::vector<Sample>& ascending, double share) {
  const double total =
      std::accumulate(ascending.begin(), ascending.end(), 0.0,
                      [](double sum, const Sample& sample) { return sum + sample.weight; });
  double below = 0;
  for (const Sample& sample : ascending) {
    below += sample.weight;
    if (below >= share * total) {
      return sample.value;
    }
  }
  return ascending.back().value;
}

}  // namespace

SurfaceDistance statistics(std::span<const double> values, std::span<const double> weights) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (weights[i] > 0) {
      samples.push_back({values[i], weights[i]});
    }
  }
  require(!samples.empty(), "a surface to measure distances from has no area");
  std::sort(samples.begin(), samples.end(),
            [](const Sample& a, const Sample& b) { return a.value < b.value; });
  double weight = 0, first = 0, second = 0;
  for (const Sample& sample : samples) {
    weight += sample.weight;
    first += sample.weight * sample.value;
  }
  const double mean = first / weight;
  for (const Sample& sample : samples) {
    second += sample.weight * (sample.value - mean) * (sample.value - mean);
  }
  return {.mean = mean,
          .deviation = std::sqrt(second / weight),
          .p50 = percentile(samples, 0.50),
          .p90 = percentile(samples, 0.90),
          .p95 = percentile(samples, 0.95),
          .max = samples.back().value,
          .samples = samples.size()};
}

SurfaceDistance surface_distance(const TriMesh& from, const TriMesh& to) {
  const SurfaceTree tree(to);
  std::vector<double> distances;
  distances.reserve(from.points.size());
  for (const Vec3& p : from.points) {
    distances.push_back(tree.closest(p).distance);
  }
  return statistics(distances, vertex_areas(from));
}

std::array<TissueVolumes, 2> tissue_volumes(const TetMesh& mesh, std::span<const Vec3> points,
                                            std::span<const double> fibroglandular,
                                            std::span<const signed char> side,
                                            const std::vector<bool>& in_breast) {
  const std::size_t count = mesh.cells.size();
  ensure(fibroglandular.size() == count && side.size() == count && in_breast.size() == count,
         "tissue of {} cells given by {}, {} and {} numbers", count, fibroglandular.size(),
         side.size(), in_breast.size());
  const std::vector<double> volumes = cell_volumes(mesh, points);
  std::array<TissueVolumes, 2> sides{};
  for (std::size_t c = 0; c < count; ++c) {
    TissueVolumes& sum = sides[side[c] > 0 ? 1 : 0];
    const double volume = cm3 * volumes[c];
    sum.model_cm3 += volume;
    if (in_breast[c]) {
      sum.breast_cm3 += volume;
      sum.fibroglandular_cm3 += fibroglandular[c] * volume;
      sum.adipose_cm3 += (1.0 - fibroglandular[c]) * volume;
    }
  }
  return sides;
}

SkinDisplacement skin_displacement(const TetMesh& mesh, std::span<const Vec3> before,
                                   std::span<const Vec3> after,
                                   const std::vector<bool>& vertex_used) {
  ensure(vertex_used.size() == mesh.points.size(), "choice of skin has {} flags for {} vertices",
         vertex_used.size(), mesh.points.size());
  const Surface skin = extract_surface(mesh, before, {"skin"});
  const std::vector<double> areas = vertex_areas(skin.mesh);
  SkinDisplacement result{0.0, 0.0, -1};
  double weight = 0, sum = 0;
  for (std::size_t i = 0; i < skin.vertex.size(); ++i) {
    const auto v = static_cast<std::size_t>(skin.vertex[i]);
    if (!vertex_used[v]) {
      continue;
    }
    const double moved = mm * norm(after[v] - before[v]);
    weight += areas[i];
    sum += areas[i] * moved;
    if (result.max_vertex < 0 || moved > result.max_mm) {
      result.max_mm = moved;
      result.max_vertex = skin.vertex[i];
    }
  }
  require(weight > 0, "no skin was chosen to measure displacements on");
  result.mean_mm = sum / weight;
  return result;
}

}  // namespace sanatrix::outcome
