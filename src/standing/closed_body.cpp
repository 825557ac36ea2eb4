#include "standing/closed_body.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/distance.hpp"
#include "geometry/image_filters.hpp"
#include "outcome/scan_target.hpp"
#include "standing/fairing.hpp"

namespace sanatrix::standing {
namespace {

/// Beyond a rim the skin goes on as round as a breast, not straight into a tip.
constexpr double rim_radius_m = 0.06;
/// What cameras see at a grazing angle beside a rim is rough: it is made anew with the hole.
constexpr double loose_rim_m = 0.005;
/// How far from a rim the continued skin is faired into one smooth surface [mm].
constexpr double faired_mm = 30.0;

/// Normals averaged over neighbours, so that noise at a rim does not turn how the skin goes on.
std::vector<Vec3> calm_normals(const TriMesh& skin) {
  constexpr int rounds = 8;
  std::vector<Vec3> normal = vertex_normals(skin);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vec3> sum = normal;
    for (const auto& t : skin.triangles) {
      Vec3 all{};
      for (const int v : t) {
        all += normal[static_cast<std::size_t>(v)];
      }
      for (const int v : t) {
        sum[static_cast<std::size_t>(v)] += all;
      }
    }
    for (std::size_t v = 0; v < sum.size(); ++v) {
      const double length = norm(sum[v]);
      normal[v] = length > 0 ? (1 / length) * sum[v] : normal[v];
    }
  }
  return normal;
}

/// Distance along the surface [m] of each vertex to the nearest rim, as far as it is looked at.
std::vector<double> rim_distance(const TriMesh& skin) {
  constexpr int rounds = 10;  // enough for edges of 0.5 mm
  const std::vector<bool> border = outcome::border_vertices(skin);
  std::vector<double> distance;
  for (const bool b : border) {
    distance.push_back(b ? 0.0 : 1.0);
  }
  for (int round = 0; round < rounds; ++round) {
    for (const auto& t : skin.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
        const double length = norm(skin.points[a] - skin.points[b]);
        distance[a] = std::min(distance[a], distance[b] + length);
        distance[b] = std::min(distance[b], distance[a] + length);
      }
    }
  }
  return distance;
}

class Skin {
 public:
  explicit Skin(const TriMesh& surface)
      : surface_(surface),
        tree_(surface),
        normal_(calm_normals(surface)),
        to_rim_(rim_distance(surface)) {}

  struct Look {
    double distance_mm;  ///< negative inside
    bool loose;          ///< the nearest skin is at a rim, where cameras see badly or nothing
  };
  [[nodiscard]] Look look(const Vec3& p_mm) const {
    const Vec3 p = 1e-3 * p_mm;
    const SurfaceTree::Hit hit = tree_.closest(p);
    const auto& t = surface_.triangles[static_cast<std::size_t>(hit.triangle)];
    const std::array<double, 3> w = outcome::weights_in(surface_, hit.triangle, hit.point);
    Vec3 n{};
    double to_rim = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      to_rim += w[k] * to_rim_[static_cast<std::size_t>(t[k])];
      n += w[k] * normal_[static_cast<std::size_t>(t[k])];
    }
    const bool at_rim = to_rim < 1e-5;
    const double bend = at_rim ? hit.distance * hit.distance / (2 * rim_radius_m) : 0.0;
    return {std::copysign(1e3 * hit.distance, dot(p - hit.point, normalised(n)) + bend),
            to_rim < loose_rim_m};
  }

 private:
  const TriMesh& surface_;
  SurfaceTree tree_;
  std::vector<Vec3> normal_;
  std::vector<double> to_rim_;
};

template <class F>
void fill(Image3<float>& image, F&& value) {
  std::size_t voxel = 0;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i, ++voxel) {
        image.voxels[voxel] = static_cast<float>(value(image.position_mm(i, j, k)));
      }
    }
  }
}

}  // namespace

void measure_body(const TriMesh& skin, Image3<float>& distance_mm) {
  const Skin target(skin);
  // Everywhere on a coarse grid, again where the skin is near.
  constexpr int step = 2;
  Image3<float> coarse{.size = {}, .origin_mm = distance_mm.origin_mm, .voxels = {}};
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    coarse.size[a] = 2 + (distance_mm.size[a] - 1) / step;
    coarse.spacing_mm[a] = step * distance_mm.spacing_mm[a];
    count *= static_cast<std::size_t>(coarse.size[a]);
  }
  coarse.voxels.resize(count);
  std::vector<bool> loose;
  loose.reserve(count);
  fill(coarse, [&](const Vec3& p) {
    const Skin::Look look = target.look(p);
    loose.push_back(look.loose && std::abs(look.distance_mm) < faired_mm);
    return look.distance_mm;
  });
  fair(coarse, loose);
  const double near_mm = 2.0 * coarse.spacing_mm[0];
  fill(distance_mm, [&](const Vec3& p) -> double {
    const double about = sample(coarse, p);
    if (std::abs(about) >= near_mm) {
      return about;
    }
    const Skin::Look look = target.look(p);
    return look.loose ? about : look.distance_mm;
  });
}

}  // namespace sanatrix::standing
