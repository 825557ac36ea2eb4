// Gland as noisy lobes that gather below the nipple, cut at the level that gives the class's share.
#include "phantom/tissue.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3;
constexpr double nipple_radius = 5.0 * mm, nipple_depth = 5.0 * mm;
constexpr double skin_fat = 6.0 * mm;  // under the skin and on the fascia gland becomes unlikely
constexpr int lobe_count = 14;         // a breast has 15 to 20, some merged

/// A number in [-1, 1] that depends on a lattice point and the seed only (SplitMix64's finaliser).
double lattice_value(std::array<std::int64_t, 3> at, std::uint64_t seed) {
  std::uint64_t x = seed * 0x9e3779b97f4a7c15ULL;
  for (const std::int64_t i : at) {
    x += static_cast<std::uint64_t>(i) + 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    x ^= x >> 31;
  }
  return static_cast<double>(x >> 11) * 0x1p-52 - 1.0;
}

/// Smooth random function with features of size `cell`.
double noise(const Vec3& p, double cell, std::uint64_t seed) {
  std::array<std::int64_t, 3> low{};
  Vec3 w{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = std::floor(p[i] / cell);
    low[i] = static_cast<std::int64_t>(x);
    const double f = p[i] / cell - x;
    w[i] = f * f * (3.0 - 2.0 * f);
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> up{corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = 1.0;
    std::array<std::int64_t, 3> at = low;
    for (std::size_t i = 0; i < 3; ++i) {
      weight *= up[i] == 1 ? w[i] : 1.0 - w[i];
      at[i] += up[i];
    }
    sum += weight * lattice_value(at, seed);
  }
  return sum;
}

Vec3 local(const Breast& breast, const ChestPlace& place) {
  return {place.s - breast.s, place.z - breast.z, place.t};
}

}  // namespace

double gland_share(Density density) {
  switch (density) {
    case Density::Fatty:
      return 0.12;
    case Density::Scattered:
      return 0.20;
    case Density::Heterogeneous:
      return 0.35;
    case Density::Dense:
      return 0.55;
  }
  return 0.0;
}

TissueMap::TissueMap(const Anatomy& anatomy, Density density, std::uint64_t seed)
    : anatomy_(anatomy), seed_(seed) {
  std::mt19937_64 random(seed + 17);
  for (const std::size_t i : {0U, 1U}) {
    const Breast& breast = anatomy.breasts()[i];
    const double h = anatomy.thickness(breast.s, breast.z);
    const Vec3 from{0.0, 0.0, h - 7.0 * mm};
    for (int k = 0; k < lobe_count; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k + uniform(random, -0.3, 0.3)) / lobe_count;
      const double out = breast.radius * uniform(random, 0.25, 0.75);
      const Vec3 end{out * std::cos(angle), out * std::sin(angle), h * uniform(random, 0.12, 0.4)};
      // Most gland lies in the upper outer quadrant.
      const double upper_outer = std::max(0.0, breast.side * std::cos(angle) + std::sin(angle));
      const double thick = breast.radius * (0.10 + 0.05 * upper_outer + uniform(random, 0.0, 0.04));
      lobes_[i].push_back({from, end - from, 2.0 * mm, thick});
    }
  }
  for (const std::size_t i : {0U, 1U}) {
    threshold_[i] = threshold_for(anatomy.breasts()[i], lobes_[i], gland_share(density));
  }
  const Breast& ill = anatomy.breasts()[uniform(random, 0.0, 1.0) < 0.5 ? 0 : 1];
  const double s = ill.s + ill.side * ill.radius * uniform(random, 0.30, 0.45);
  const double z = ill.z + ill.radius * uniform(random, 0.25, 0.40);
  const double h = anatomy.thickness(s, z);
  // Half of tumours treated by lumpectomy measure 12 to 20 mm; in a thin breast what fits with the
  // clearances of a resection.
  tumour_ = {{s, z, uniform(random, 0.45, 0.55) * h},
             std::min(uniform(random, 6.0, 10.0) * mm, 0.2 * h)};
}

double TissueMap::gland(const Breast& breast, std::span<const Lobe> lobes, const ChestPlace& place,
                        double depth) const {
  const Vec3 p = local(breast, place);
  double nearest = 1.0;
  for (const Lobe& lobe : lobes) {
    const Vec3 r = p - lobe.from;
    const double w = std::clamp(dot(r, lobe.along) / dot(lobe.along, lobe.along), 0.0, 1.0);
    const double radius = lobe.thin + w * (lobe.thick - lobe.thin);
    nearest = std::min(nearest, norm(r - w * lobe.along) - radius);
  }
  const double rough =
      5.0 * mm * noise(p, 9.0 * mm, seed_) + 3.0 * mm * noise(p, 4.0 * mm, seed_ + 1);
  const double edge = std::max(0.0, skin_fat - std::min(depth, place.t));
  const double rim =
      std::max(0.0, anatomy_.base_radius(breast, place.s, place.z) - 0.85) * breast.radius;
  return rough - nearest - 3.0 * edge - 3.0 * rim;
}

double TissueMap::threshold_for(const Breast& breast, std::span<const Lobe> lobes,
                                double share) const {
  struct Sample {
    double gland, volume;
  };
  std::vector<Sample> samples;
  double total = 0.0;
  constexpr int n = 40, layers = 24;
  const double reach = 1.25 * breast.radius, step = 2.0 * reach / n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double s = breast.s - reach + (i + 0.5) * step;
      const double z = breast.z - reach + (j + 0.5) * step;
      if (anatomy_.base_radius(breast, s, z) >= 1.0) {
        continue;
      }
      const double h = anatomy_.thickness(s, z);
      for (int k = 0; k < layers; ++k) {
        const ChestPlace place{s, z, h * (k + 0.5) / layers};
        const double volume = (1.0 + anatomy_.thorax().curvature(s) * place.t) * h;
        samples.push_back({gland(breast, lobes, place, anatomy_.depth(place)), volume});
        total += volume;
      }
    }
  }
  std::ranges::sort(samples, std::greater<>(), &Sample::gland);
  double sum = 0.0;
  for (const Sample& sample : samples) {
    sum += sample.volume;
    if (sum >= share * total) {
      return sample.gland;
    }
  }
  return samples.back().gland;
}

bool TissueMap::in_tumour(const ChestPlace& place) const {
  const ChestPlace& c = tumour_.centre;
  // An irregular ellipsoid: unequal axes of product one, and a bumpy surface.
  const Vec3 r{(place.s - c.s) / 1.18, place.z - c.z, (place.t - c.t) * 1.18};
  const double bumps =
      0.22 * noise(Vec3{place.s, place.z, place.t}, 0.7 * tumour_.radius, seed_ + 2);
  return norm(r) < tumour_.radius * (1.0 + bumps);
}

bool TissueMap::is_nipple(const ChestPlace& place, double depth) const {
  const Breast& breast = anatomy_.breast_at(place.s);
  return depth < nipple_depth && std::hypot(place.s - breast.s, place.z - breast.z) < nipple_radius;
}

Label TissueMap::at(const ChestPlace& place, double depth) const {
  const Breast& breast = anatomy_.breast_at(place.s);
  if (in_tumour(place)) {
    return Label::Tumour;
  }
  if (is_nipple(place, depth)) {
    return Label::Nipple;
  }
  const std::size_t i = place.s > 0.0 ? 1 : 0;
  const bool gland_here = anatomy_.base_radius(breast, place.s, place.z) < 1.0 &&
                          gland(breast, lobes_[i], place, depth) > threshold_[i];
  return gland_here ? Label::Fibroglandular : Label::Adipose;
}

}  // namespace sanatrix::phantom
