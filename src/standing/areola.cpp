#include "standing/areola.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace sanatrix::standing {
namespace {

constexpr double cube_mm = 2.0;
/// Radii [mm] that are tried; areolas of adults measure 20 to 65 mm across.
constexpr std::array<double, 5> radii_mm{10, 14, 19, 25, 32};
constexpr double gap = 1.25;      ///< the ring begins at this many radii: the border is blurred
constexpr double ring_mm = 14.0;  ///< width of the ring of ordinary skin
constexpr double reach_mm = 70.0;
constexpr double guess_mm = 30.0;  ///< doubt about where the shape puts the nipple
/// Shadows darken but hardly redden: darkness counts less.
constexpr double darkness_weight = 0.25;
constexpr double least_deviation = 0.02;  ///< of skin's tint; evens out flawless pictures
constexpr double least_difference = 0.05, least_contrast = 2.0;
constexpr double pixel_noise = 5.0;  ///< added to channels 0..255
constexpr double black = 15.0;       ///< sum of the channels: not photographed

std::optional<double> tint_of(const std::array<double, 3>& rgb) {
  if (!(rgb[0] + rgb[1] + rgb[2] > black)) {  // NaN, too
    return std::nullopt;
  }
  const double bright = 0.30 * rgb[0] + 0.59 * rgb[1] + 0.11 * rgb[2];
  return std::log((rgb[0] + pixel_noise) / (rgb[1] + pixel_noise)) -
         darkness_weight * std::log(bright + pixel_noise);
}

/// Colour inside a triangle, given the weights of its corners.
std::array<double, 3> colour_in(const TexturedSurface& surface, std::size_t t,
                                const std::array<double, 3>& weight) {
  std::array<double, 3> rgb{};
  if (surface.has_photograph()) {
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      u += weight[k] * surface.corners[t][k][0];
      v += weight[k] * surface.corners[t][k][1];
    }
    rgb.fill(std::numeric_limits<double>::quiet_NaN());
    return std::isfinite(u + v) ? surface.photograph.at(u, v) : rgb;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Colour& at = surface.point_colour[static_cast<std::size_t>(surface.mesh.triangles[t][k])];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      rgb[channel] += weight[k] * at[channel];
    }
  }
  return rgb;
}

struct Sum {
  Vec3 place{};
  double tint = 0, weight = 0;
};

/// Adds a triangle as pieces of about a cube's size.
void add_triangle(const TexturedSurface& surface, std::size_t t,
                  std::unordered_map<long, Sum>& cubes) {
  const auto corner = [&](std::size_t k) {
    return 1e3 * surface.mesh.points[static_cast<std::size_t>(surface.mesh.triangles[t][k])];
  };
  const Vec3 a = corner(0), b = corner(1), c = corner(2);
  const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
  const int n = std::clamp(static_cast<int>(std::ceil(longest / cube_mm)), 1, 30);
  const double share = area(a, b, c) / (n * n);
  const auto add = [&](double i, double j) {
    const std::array<double, 3> weight{1 - (i + j) / n, i / n, j / n};
    if (const auto tint = tint_of(colour_in(surface, t, weight))) {
      const Vec3 p = weight[0] * a + weight[1] * b + weight[2] * c;
      long key = 0;
      for (const double x : p) {
        key = key * (1L << 20) + static_cast<long>(std::floor(x / cube_mm)) + (1L << 19);
      }
      Sum& sum = cubes[key];
      sum.place += share * p;
      sum.tint += share * *tint;
      sum.weight += share;
    }
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      add(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j + 1 < n) {
        add(i + 2.0 / 3, j + 2.0 / 3);
      }
    }
  }
}

struct Moments {
  double count = 0, sum = 0, squares = 0;
  void add(double x) {
    count += 1;
    sum += x;
    squares += x * x;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double deviation() const {
    return std::sqrt(std::max(0.0, squares / count - mean() * mean()));
  }
};

struct Spot {
  Vec3 centre{};
  double radius = 0, inside = 0, around = 0, contrast = 0;
};

/// How much a disc differs from the ring around it; nothing where too little of either is seen.
std::optional<Spot> spot_at(std::span<const ColourSample> near, const Vec3& centre, double radius) {
  Moments disc, ring;
  const double inner = gap * radius, outer = inner + ring_mm;
  for (const ColourSample& sample : near) {
    const Vec3 arm = sample.place_mm - centre;
    const double squared = dot(arm, arm);
    if (squared < radius * radius) {
      disc.add(sample.tint);
    } else if (squared > inner * inner && squared < outer * outer) {
      ring.add(sample.tint);
    }
  }
  const double cube_area = cube_mm * cube_mm, pi = 3.14159;
  constexpr double least_seen = 0.5;
  if (disc.count * cube_area < least_seen * pi * radius * radius ||
      ring.count * cube_area < least_seen * pi * (outer * outer - inner * inner)) {
    return std::nullopt;
  }
  const double difference = disc.mean() - ring.mean();
  return Spot{
      centre, radius, disc.mean(), ring.mean(),
      difference < least_difference ? 0.0 : difference / (ring.deviation() + least_deviation)};
}

/// Centre of the tint above the skin's, twice, as the first place is one of a coarse set.
Vec3 centred(std::span<const ColourSample> near, const Spot& spot) {
  Vec3 centre = spot.centre;
  for (int round = 0; round < 3; ++round) {
    Vec3 sum{};
    double total = 0;
    for (const ColourSample& sample : near) {
      if (norm(sample.place_mm - centre) < gap * spot.radius) {
        const double weight =
            std::clamp((sample.tint - spot.around) / (spot.inside - spot.around), 0.0, 1.0);
        sum += weight * sample.place_mm;
        total += weight;
      }
    }
    centre = total > 0 ? (1 / total) * sum : centre;
  }
  return centre;
}

}  // namespace

std::vector<ColourSample> skin_colours(const TexturedSurface& surface) {
  std::vector<ColourSample> samples;
  if (!surface.has_photograph() && surface.point_colour.empty()) {
    return samples;
  }
  std::unordered_map<long, Sum> cubes;
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    add_triangle(surface, t, cubes);
  }
  for (const auto& [key, sum] : cubes) {
    samples.push_back({(1 / sum.weight) * sum.place, sum.tint / sum.weight});
  }
  std::ranges::sort(samples, {}, &ColourSample::place_mm);  // the same on every machine
  return samples;
}

std::optional<Areola> find_areola(std::span<const ColourSample> skin, const Vec3& guess) {
  std::vector<ColourSample> near;
  std::ranges::copy_if(skin, std::back_inserter(near), [&](const ColourSample& sample) {
    return norm(sample.place_mm - guess) < reach_mm + gap * radii_mm.back() + ring_mm;
  });
  Spot best;
  double best_score = 0.0;
  for (std::size_t i = 0; i < near.size(); i += 3) {  // some 3.5 mm apart
    const double far = norm(near[i].place_mm - guess);
    if (far > reach_mm) {
      continue;
    }
    for (const double radius : radii_mm) {
      const auto spot = spot_at(near, near[i].place_mm, radius);
      const double score =
          spot ? spot->contrast * std::exp(-0.5 * far * far / (guess_mm * guess_mm)) : 0.0;
      if (score > best_score) {
        best_score = score;
        best = *spot;
      }
    }
  }
  if (best.contrast < least_contrast) {
    return std::nullopt;
  }
  return Areola{centred(near, best), best.radius, best.contrast};
}

}  // namespace sanatrix::standing
