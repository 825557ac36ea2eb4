#include "healing/neighbourhood.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "fem/session.hpp"
#include "geometry/box_tree.hpp"

namespace sanatrix::healing {
namespace {

/// Decay lengths to the border. What is cut off there has fallen by exp(-12), and what the cut does
/// to the wound has come all the way back: exp(-24), far below any tolerance of the species. Cells
/// longer than a decay length let both fall more slowly (docs/theory/healing.md has numbers).
constexpr double decay_lengths = 12.0;

/// Whatever is in the wound's part of the mesh, of all processes.
std::vector<Box> wound_points(std::span<const Vec3> points, const WoundMap& wound,
                              const fem::MeshShare* share) {
  std::vector<double> flat;
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (fem::owns_vertex(share, v) && (wound.vertex[v] || wound.fraction[v] > 0.0)) {
      flat.insert(flat.end(), points[v].begin(), points[v].end());
    }
  }
  if (share != nullptr) {
    flat = fem::gather(flat);
    fem::broadcast(flat);
  }
  std::vector<Box> boxes(flat.size() / 3);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    boxes[b].include(Vec3{flat[3 * b], flat[3 * b + 1], flat[3 * b + 2]});
  }
  return boxes;
}

}  // namespace

double reach(const Model& model) {
  const auto species = model.species();
  const std::size_t n = species.size();
  std::vector<double> healthy, rate(n), jacobian(n * n);
  for (const Species& s : species) {
    healthy.push_back(s.healthy);
  }
  model.source(healthy, std::vector{0.0}, rate, jacobian);
  double longest = 0.0;
  for (std::size_t s = 0; s < n; ++s) {
    if (species[s].clamped_outside) {
      continue;
    }
    double restoring = -jacobian[s * n + s];  // less what the other free species may do to it
    double fastest = 0.0;
    for (std::size_t t = 0; t < n; ++t) {
      const double size = std::abs(jacobian[s * n + t]);
      fastest = std::max(fastest, size);
      restoring -= t != s && !species[t].clamped_outside ? size : 0.0;
    }
    const bool at_rest = std::abs(rate[s]) <= 1e-12 * fastest;
    if (!at_rest || restoring <= 0.0) {
      return std::numeric_limits<double>::infinity();
    }
    longest = std::max(longest, std::sqrt(species[s].diffusivity / restoring));
  }
  return decay_lengths * longest;
}

std::vector<bool> neighbourhood(const Model& model, std::span<const Vec3> points,
                                const WoundMap& wound, const fem::MeshShare* share) {
  const double distance = reach(model);
  const std::vector<Box> boxes = wound_points(points, wound, share);
  if (boxes.empty() || !std::isfinite(distance)) {
    return std::vector<bool>(points.size(), true);
  }
  const BoxTree tree(boxes);
  std::vector<std::uint8_t> near(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    double reach2 = distance * distance;
    tree.within(points[v], reach2, [&](int b) {
      if (boxes[static_cast<std::size_t>(b)].squared_distance(points[v]) <= reach2) {
        near[v] = 1;
        reach2 = -1.0;  // one is enough
      }
    });
  }
  if (share != nullptr) {
    share->fetch(near);
  }
  return {near.begin(), near.end()};
}

}  // namespace sanatrix::healing
