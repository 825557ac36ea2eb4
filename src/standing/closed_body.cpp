#include "standing/closed_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/distance.hpp"
#include "geometry/image_filters.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::standing {
namespace {

/// Beyond a rim the skin goes on as round as a breast, not straight into a tip.
constexpr double rim_radius_mm = 60.0;
/// But no more than this per length: far behind the skin is the body, too.
constexpr double most_bend = 0.25;
/// Skin is summed up in cubes; closer than this the nearest triangle says more.
constexpr double cube_mm = 6.0;
constexpr double soft_mm2 = 0.25 * cube_mm * cube_mm;  ///< a piece is no point

/// A piece of skin: its centre, and its area times its normal.
struct Piece {
  Vec3 centre_mm{}, normal_mm2{};
  double area_mm2 = 0.0;
};

std::vector<Piece> pieces_of(const TriMesh& skin) {
  struct Keyed {
    std::array<int, 3> cube;
    Piece piece;
  };
  std::vector<Keyed> all;
  for (const auto& t : skin.triangles) {
    const auto corner = [&](std::size_t k) {
      return 1e3 * skin.points[static_cast<std::size_t>(t[k])];
    };
    const Vec3 centre = (1.0 / 3) * (corner(0) + corner(1) + corner(2));
    const Vec3 normal = 0.5 * cross(corner(1) - corner(0), corner(2) - corner(0));
    std::array<int, 3> cube{};
    for (std::size_t a = 0; a < 3; ++a) {
      cube[a] = static_cast<int>(std::floor(centre[a] / cube_mm));
    }
    all.push_back({cube, {centre, normal, norm(normal)}});
  }
  std::ranges::stable_sort(all, {}, &Keyed::cube);
  std::vector<Piece> pieces;
  for (auto first = all.begin(); first != all.end();) {
    Piece sum;
    auto last = first;
    for (; last != all.end() && last->cube == first->cube; ++last) {
      sum.centre_mm += last->piece.area_mm2 * last->piece.centre_mm;
      sum.normal_mm2 += last->piece.normal_mm2;
      sum.area_mm2 += last->piece.area_mm2;
    }
    if (sum.area_mm2 > 0) {
      sum.centre_mm = (1 / sum.area_mm2) * sum.centre_mm;
      pieces.push_back(sum);
    }
    first = last;
  }
  return pieces;
}

class Skin {
 public:
  explicit Skin(const TriMesh& surface)
      : surface_(surface),
        tree_(surface),
        normal_(vertex_normals(surface)),
        border_(outcome::border_vertices(surface)),
        pieces_(pieces_of(surface)) {}

  /// `side` tells outside (positive) from inside where the nearest skin alone is not to be trusted.
  template <class F>
  [[nodiscard]] double distance_mm(const Vec3& p_mm, F&& side) const {
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
    if (at_rim > 0.99) {
      return going_on_mm(p_mm);
    }
    const bool near = 1e3 * hit.distance < cube_mm;
    return std::copysign(1e3 * hit.distance, near ? dot(p - hit.point, n) : side());
  }

  /// Positive outside: the generalised winding number (Jacobson et al. 2013,
  /// doi:10.1145/2461912.2461916) is 1 in a closed body and 0 outside; behind and in front of an
  /// open front it is about +-1/2.
  [[nodiscard]] double side_of(const Vec3& p_mm) const {
    constexpr double least_inside = 0.125;
    double sum = 4 * std::numbers::pi * least_inside;
    for (const Piece& piece : pieces_) {
      const Vec3 arm = p_mm - piece.centre_mm;
      const double calm = dot(arm, arm) + soft_mm2;
      sum += dot(arm, piece.normal_mm2) / (calm * std::sqrt(calm));
    }
    return sum;
  }

  /// Mean distance from the skin's tangents, bent inwards, by area / distance^6: far skin looks
  /// elsewhere.
  [[nodiscard]] double going_on_mm(const Vec3& p_mm) const {
    double sum = 0, weights = 0;
    for (const Piece& piece : pieces_) {
      const Vec3 arm = p_mm - piece.centre_mm;
      const double squared = dot(arm, arm), calm = squared + soft_mm2;
      const double weight = 1 / (calm * calm * calm);
      const double bend = std::min(squared / (2 * rim_radius_mm), most_bend * std::sqrt(squared));
      sum += weight * (dot(arm, piece.normal_mm2) + piece.area_mm2 * bend);
      weights += weight * piece.area_mm2;
    }
    return sum / weights;
  }

 private:
  const TriMesh& surface_;
  SurfaceTree tree_;
  std::vector<Vec3> normal_;
  std::vector<bool> border_;
  std::vector<Piece> pieces_;
};

template <class F>
void fill(Image3<float>& image, F&& value) {
#pragma omp parallel for schedule(dynamic)
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        image.voxels[image.index(i, j, k)] = static_cast<float>(value(image.position_mm(i, j, k)));
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
  fill(coarse,
       [&](const Vec3& p) { return target.distance_mm(p, [&] { return target.side_of(p); }); });
  const double near_mm = 2.0 * coarse.spacing_mm[0];
  fill(distance_mm, [&](const Vec3& p) {
    const double about = sample(coarse, p);
    return std::abs(about) < near_mm ? target.distance_mm(p, [&] { return about; }) : about;
  });
}

}  // namespace sanatrix::standing
