// The scan's photograph on the model's skin: an atlas with a place for every triangle.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"
#include "outcome/warp.hpp"

namespace sanatrix::outcome {
namespace {

using Colour = std::array<double, 3>;

/// Two triangles share a square cell: the lower left and the upper right half, with a border of
/// pixels around each so that neighbours do not bleed into each other.
struct Atlas {
  int cell, columns, side;

  Atlas(std::size_t triangles, int side_pixels) {
    const double cells = std::ceil(0.5 * static_cast<double>(triangles));
    columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(cells))));
    cell = std::max(6, side_pixels / columns);
    side = columns * cell;
  }
  /// Pixel positions of the corners of a triangle, from the lower left of the picture.
  [[nodiscard]] std::array<std::array<double, 2>, 3> corners(std::size_t triangle) const {
    const auto place = static_cast<int>(triangle / 2);
    const int column = place % columns, row = place / columns;
    const double x = column * cell, y = row * cell;
    const double first = 1.0, last = cell - 3.0;  // leaves the diagonal to the other half
    if (triangle % 2 == 0) {
      return {{{x + first, y + first}, {x + last, y + first}, {x + first, y + last}}};
    }
    const double far = cell - 1.0, near = 3.0;
    return {{{x + far, y + far}, {x + near, y + far}, {x + far, y + near}}};
  }
};

/// Colour of the scan at a point of the warped skin, or nothing (hole, no photograph there).
class Sampler {
 public:
  explicit Sampler(const TexturedSurface& scan) : scan_(scan), target_(scan.mesh) {}

  [[nodiscard]] bool colour_at(const Vec3& p, const Vec3& normal, Colour& colour) const {
    const auto hit = target_.closest(p);
    const auto& corners = scan_.corners[static_cast<std::size_t>(hit.triangle)];
    if (hit.on_border || hit.distance > 0.01 || dot(hit.normal, normal) < 0.2 ||
        std::isnan(corners[0][0])) {
      return false;
    }
    const std::array<double, 3> weights = weights_in(scan_.mesh, hit.triangle, hit.point);
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      u += weights[k] * corners[k][0];
      v += weights[k] * corners[k][1];
    }
    colour = scan_.photograph.at(u, v);
    return true;
  }

 private:
  const TexturedSurface& scan_;
  ScanTarget target_;
};

/// Colours per vertex; unseen vertices take the mean of their neighbours, from the rim inwards.
std::vector<Colour> vertex_colours(const TriMesh& skin, const Sampler& sampler) {
  const std::vector<Vec3> normals = vertex_normals(skin);
  std::vector<Colour> colours(skin.points.size());
  std::vector<bool> known(skin.points.size());
  for (std::size_t v = 0; v < skin.points.size(); ++v) {
    known[v] = sampler.colour_at(skin.points[v], normals[v], colours[v]);
  }
  require(std::ranges::count(known, true) > 0,
          "the scan's photograph shows nothing of the model's skin");
  for (bool progress = true; progress;) {
    progress = false;
    std::vector<Colour> sum(colours.size(), Colour{});
    std::vector<double> count(colours.size(), 0.0);
    for (const auto& t : skin.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t other = 1; other < 3; ++other) {
          const auto from = static_cast<std::size_t>(t[(k + other) % 3]);
          const auto to = static_cast<std::size_t>(t[k]);
          if (known[from] && !known[to]) {
            for (std::size_t c = 0; c < 3; ++c) {
              sum[to][c] += colours[from][c];
            }
            count[to] += 1;
          }
        }
      }
    }
    for (std::size_t v = 0; v < colours.size(); ++v) {
      if (count[v] > 0) {
        for (std::size_t c = 0; c < 3; ++c) {
          colours[v][c] = sum[v][c] / count[v];
        }
        known[v] = true;
        progress = true;
      }
    }
  }
  return colours;
}

/// A photograph with a place for every triangle; colour_of(triangle, weights of its corners).
template <class ColourOf>
TexturedSurface baked(const TriMesh& skin, int side_pixels, ColourOf&& colour_of) {
  const Atlas atlas(skin.triangles.size(), side_pixels);
  const auto side = static_cast<std::size_t>(atlas.side);
  TexturedSurface result{skin, {}, {atlas.side, atlas.side, {}}, {}};
  result.photograph.rgb.assign(3 * side * side, 128);
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto corners = atlas.corners(t);
    const double way = corners[0][0] < corners[1][0] ? 1.0 : -1.0;
    const double length = std::abs(corners[1][0] - corners[0][0]);
    std::array<TextureCorner, 3> texture;
    for (std::size_t k = 0; k < 3; ++k) {
      texture[k] = {static_cast<float>((corners[k][0] + 0.5) / atlas.side),
                    static_cast<float>((corners[k][1] + 0.5) / atlas.side)};
    }
    result.corners.push_back(texture);
    // One pixel more on every side than the triangle, for bilinear look-up.
    const int last = static_cast<int>(length) + 1;
    for (int i = -1; i <= last; ++i) {
      for (int j = -1; i + j <= last; ++j) {
        const int x = static_cast<int>(corners[0][0] + way * i);
        const int y = atlas.side - 1 - static_cast<int>(corners[0][1] + way * j);
        if (x < 0 || y < 0 || x >= atlas.side || y >= atlas.side) {
          continue;
        }
        const double wb = i / length, wc = j / length;
        const Colour colour = colour_of(t, std::array<double, 3>{1 - wb - wc, wb, wc});
        const std::size_t at =
            3 * (static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x));
        for (std::size_t c = 0; c < 3; ++c) {
          result.photograph.rgb[at + c] =
              static_cast<unsigned char>(std::clamp(colour[c], 0.0, 255.0));
        }
      }
    }
  }
  return result;
}

}  // namespace

TexturedSurface carry_texture(const Warp& warp, const TexturedSurface& scan, const TriMesh& skin,
                              int side_pixels) {
  ensure(scan.has_photograph() && skin.points.size() == warp.surface.points.size(),
         "a texture needs a photograph and the warped skin's own vertices");
  const TriMesh& bent = warp.surface;
  const Sampler sampler(scan);
  const std::vector<Colour> colours = vertex_colours(bent, sampler);
  const std::vector<Vec3> normals = vertex_normals(bent);
  return baked(skin, side_pixels, [&](std::size_t t, const std::array<double, 3>& w) {
    Vec3 p{}, n{};
    Colour colour{}, seen{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(bent.triangles[t][k]);
      p += w[k] * bent.points[v];
      n += w[k] * normals[v];
      for (std::size_t c = 0; c < 3; ++c) {
        colour[c] += w[k] * colours[v][c];
      }
    }
    return sampler.colour_at(p, n, seen) ? seen : colour;
  });
}

TexturedSurface clay(const TriMesh& skin, const std::array<Vec3, 2>& nipple, int side_pixels) {
  constexpr Colour tone{213, 170, 145}, areola{176, 116, 98}, tip{158, 98, 84};
  constexpr double areola_m = 0.019, tip_m = 0.006, soft_m = 0.0015;
  const auto blend = [](const Colour& a, const Colour& b, double share) {
    Colour mixed;
    for (std::size_t c = 0; c < 3; ++c) {
      mixed[c] = (1 - share) * a[c] + share * b[c];
    }
    return mixed;
  };
  return baked(skin, side_pixels, [&](std::size_t t, const std::array<double, 3>& w) {
    Vec3 p{};
    for (std::size_t k = 0; k < 3; ++k) {
      p += w[k] * skin.points[static_cast<std::size_t>(skin.triangles[t][k])];
    }
    const double r = std::min(norm(p - nipple[0]), norm(p - nipple[1]));
    const auto inside = [&](double radius) {
      return std::clamp((radius - r) / soft_m + 0.5, 0.0, 1.0);
    };
    return blend(blend(tone, areola, inside(areola_m)), tip, inside(tip_m));
  });
}

}  // namespace sanatrix::outcome
