#include "standing/closed_body.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/distance.hpp"
#include "geometry/image_filters.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::standing {
namespace {

/// Beyond a rim the skin goes on as round as a breast, not straight into a tip.
constexpr double rim_radius_m = 0.06;

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

class Skin {
 public:
  explicit Skin(const TriMesh& surface)
      : surface_(surface),
        tree_(surface),
        normal_(calm_normals(surface)),
        border_(outcome::border_vertices(surface)) {}

  [[nodiscard]] double distance_mm(const Vec3& p_mm) const {
    const Vec3 p = 1e-3 * p_mm;
    const SurfaceTree::Hit hit = tree_.closest(p);
    const auto& t = surface_.triangles[static_cast<std::size_t>(hit.triangle)];
    const std::array<double, 3> w = outcome::weights_in(surface_, hit.triangle, hit.point);
    Vec3 n{};
    double at_rim = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      at_rim += border_[static_cast<std::size_t>(t[k])] ? w[k] : 0.0;
      n += w[k] * normal_[static_cast<std::size_t>(t[k])];
    }
    const double bend = at_rim > 0.99 ? hit.distance * hit.distance / (2 * rim_radius_m) : 0.0;
    return std::copysign(1e3 * hit.distance, dot(p - hit.point, normalised(n)) + bend);
  }

 private:
  const TriMesh& surface_;
  SurfaceTree tree_;
  std::vector<Vec3> normal_;
  std::vector<bool> border_;
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
  constexpr int step = 3;
  Image3<float> coarse{.size = {}, .origin_mm = distance_mm.origin_mm, .voxels = {}};
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    coarse.size[a] = 2 + (distance_mm.size[a] - 1) / step;
    coarse.spacing_mm[a] = step * distance_mm.spacing_mm[a];
    count *= static_cast<std::size_t>(coarse.size[a]);
  }
  coarse.voxels.resize(count);
  fill(coarse, [&](const Vec3& p) { return target.distance_mm(p); });
  const double near_mm = 2.0 * coarse.spacing_mm[0];
  fill(distance_mm, [&](const Vec3& p) {
    const double about = sample(coarse, p);
    return std::abs(about) < near_mm ? target.distance_mm(p) : about;
  });
}

}  // namespace sanatrix::standing
