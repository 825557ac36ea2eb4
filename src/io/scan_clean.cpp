// From a scan as it stands in a file to a surface that can be measured on.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "io/scan_file.hpp"
#include "io/scan_parts.hpp"

namespace sanatrix::io {
namespace {

/// Loose bits smaller than this share of the largest piece's area are not the patient.
constexpr double least_piece_share = 0.02;

bool is_finite(const Vec3& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

class Cleaner {
 public:
  Cleaner(const RawScan& raw, double metres_per_unit, std::vector<std::string>& notes)
      : raw_(raw), notes_(notes), kept_(raw.triangles.size(), true) {
    points_.reserve(raw.points.size());
    for (const Vec3& p : raw.points) {
      points_.push_back(metres_per_unit * p);
    }
  }

  TexturedSurface clean() {
    drop_broken();
    drop_repeated();
    drop_loose_bits();
    require(std::ranges::count(kept_, true) > 0,
            "no usable face is left of the scan's {} (NaN, without area, or loose bits)",
            raw_.triangles.size());
    turn_outwards();
    TexturedSurface surface = compact();
    add_photograph(surface);
    return surface;
  }

 private:
  [[nodiscard]] Vec3 corner(std::size_t t, std::size_t k) const {
    return points_[static_cast<std::size_t>(raw_.triangles[t][k])];
  }
  [[nodiscard]] Vec3 area_vector(std::size_t t) const {
    return 0.5 * cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
  }

  void note(std::size_t count, const std::string& text) {
    if (count > 0) {
      notes_.push_back(fmt::format("{} {}", count, text));
    }
  }

  void drop_broken() {
    std::size_t not_finite = 0, flat = 0;
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (!is_finite(corner(t, 0)) || !is_finite(corner(t, 1)) || !is_finite(corner(t, 2))) {
        kept_[t] = false;
        ++not_finite;
      } else if (!(norm(area_vector(t)) > 1e-14)) {  // [m2]: a needle of 0.1 um x 0.1 mm
        kept_[t] = false;
        ++flat;
      }
    }
    note(not_finite, "faces with coordinates that are no numbers were left out");
    note(flat, "faces without area were left out");
  }

  void drop_repeated() {
    std::vector<std::size_t> order(kept_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::erase_if(order, [&](std::size_t t) { return !kept_[t]; });
    const auto key = [&](std::size_t t) {
      std::array<int, 3> sorted = raw_.triangles[t];
      std::ranges::sort(sorted);
      return sorted;
    };
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
      const auto ka = key(a), kb = key(b);
      return ka != kb ? ka < kb : a < b;
    });
    std::size_t repeated = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
      if (key(order[i]) == key(order[i - 1])) {
        kept_[order[i]] = false;
        ++repeated;
      }
    }
    note(repeated, "faces that were given twice were left out");
  }

  int root(int point) {
    while (piece_[static_cast<std::size_t>(point)] != point) {
      int& parent = piece_[static_cast<std::size_t>(point)];
      parent = piece_[static_cast<std::size_t>(parent)];
      point = parent;
    }
    return point;
  }

  void drop_loose_bits() {
    piece_.resize(points_.size());
    std::iota(piece_.begin(), piece_.end(), 0);
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t]) {
        for (std::size_t k = 1; k < 3; ++k) {
          const int a = root(raw_.triangles[t][0]), b = root(raw_.triangles[t][k]);
          piece_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
        }
      }
    }
    std::vector<double> area(points_.size(), 0.0);
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t]) {
        area[static_cast<std::size_t>(root(raw_.triangles[t][0]))] += norm(area_vector(t));
      }
    }
    const double largest = area.empty() ? 0.0 : *std::ranges::max_element(area);
    std::size_t loose = 0;
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t] && area[static_cast<std::size_t>(root(raw_.triangles[t][0]))] <
                          least_piece_share * largest) {
        kept_[t] = false;
        ++loose;
      }
    }
    note(loose, "faces of loose bits beside the body were left out");
  }

  /// The front of a body bulges along its normals; when it does not, the scan is inside out.
  void turn_outwards() {
    Vec3 centre{};
    double total = 0;
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t]) {
        const Vec3 a = area_vector(t);
        const double weight = norm(a);
        centre += (weight / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2));
        total += weight;
      }
    }
    centre = (1 / total) * centre;
    double bulge = 0;
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t]) {
        const Vec3 middle = (1.0 / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2));
        bulge += dot(middle - centre, area_vector(t));
      }
    }
    inside_out_ = bulge < 0;
    if (inside_out_) {
      notes_.emplace_back(
          "the scan was inside out and has been turned; if a mirror or a negative scale did that, "
          "left and right are swapped");
    }
  }

  TexturedSurface compact() const {
    TexturedSurface surface;
    std::vector<int> number(points_.size(), -1);
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (!kept_[t]) {
        continue;
      }
      std::array<int, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        int& n = number[static_cast<std::size_t>(raw_.triangles[t][k])];
        if (n < 0) {
          n = static_cast<int>(surface.mesh.points.size());
          surface.mesh.points.push_back(corner(t, k));
          if (!raw_.point_colour.empty()) {
            surface.point_colour.push_back(
                raw_.point_colour[static_cast<std::size_t>(raw_.triangles[t][k])]);
          }
        }
        triangle[k] = n;
      }
      if (inside_out_) {
        std::swap(triangle[1], triangle[2]);
      }
      surface.mesh.triangles.push_back(triangle);
    }
    return surface;
  }

  /// Photographs one above the other in a single one, and where each begins.
  struct Pile {
    Photograph photograph;
    std::vector<int> top;  ///< per material, first row; -1: no photograph
    std::vector<std::array<int, 2>> size;
  };
  [[nodiscard]] Pile pile_up() const {
    Pile pile;
    std::vector<Photograph> photographs;
    for (const auto& file : raw_.photographs) {
      photographs.push_back(file.empty() ? Photograph{} : read_photograph(file));
      pile.photograph.width = std::max(pile.photograph.width, photographs.back().width);
      pile.size.push_back({photographs.back().width, photographs.back().height});
    }
    for (const Photograph& one : photographs) {
      pile.top.push_back(one.empty() ? -1 : pile.photograph.height);
      pile.photograph.height += one.height;
      const auto row = static_cast<std::size_t>(3 * one.width);
      for (std::size_t y = 0; y < static_cast<std::size_t>(one.height); ++y) {
        const auto from = one.rgb.begin() + static_cast<long>(y * row);
        pile.photograph.rgb.insert(pile.photograph.rgb.end(), from, from + static_cast<long>(row));
        pile.photograph.rgb.resize(pile.photograph.rgb.size() +
                                   static_cast<std::size_t>(3 * pile.photograph.width) - row);
      }
    }
    return pile;
  }

  void add_photograph(TexturedSurface& surface) {
    Pile pile = pile_up();
    if (pile.photograph.empty() || raw_.texture_triangles.empty()) {
      return;
    }
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    std::size_t without = 0;
    float low = 1e30F, high = -1e30F;
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (!kept_[t]) {
        continue;
      }
      const auto& texture = raw_.texture_triangles[t];
      const int material = raw_.material[t];
      const bool has = material >= 0 && pile.top[static_cast<std::size_t>(material)] >= 0 &&
                       std::ranges::min(texture) >= 0;
      std::array<TextureCorner, 3> corners;
      corners.fill({none, none});
      for (std::size_t k = 0; has && k < 3; ++k) {
        const TextureCorner& at = raw_.texture_points[static_cast<std::size_t>(texture[k])];
        low = std::min({low, at[0], at[1]});
        high = std::max({high, at[0], at[1]});
        corners[k] = placed(pile, static_cast<std::size_t>(material), at);
      }
      if (inside_out_) {
        std::swap(corners[1], corners[2]);
      }
      without += has ? 0 : 1;
      surface.corners.push_back(corners);
    }
    if (!(high - low > 1e-6F)) {
      notes_.emplace_back("all texture coordinates are the same: the photograph is not used");
      surface.corners.clear();
      return;
    }
    note(without, "faces have no photograph");
    surface.photograph = std::move(pile.photograph);
  }

  static TextureCorner placed(const Pile& pile, std::size_t material, const TextureCorner& at) {
    const double u = std::clamp(static_cast<double>(at[0]), 0.0, 1.0);
    const double v = std::clamp(static_cast<double>(at[1]), 0.0, 1.0);
    const double x = u * pile.size[material][0];
    const double y = pile.top[material] + (1 - v) * pile.size[material][1];
    return {static_cast<float>(x / pile.photograph.width),
            static_cast<float>(1 - y / pile.photograph.height)};
  }

  const RawScan& raw_;
  std::vector<std::string>& notes_;
  std::vector<bool> kept_;
  std::vector<Vec3> points_;
  std::vector<int> piece_;
  bool inside_out_ = false;
};

}  // namespace

TexturedSurface clean_scan(const RawScan& raw, double metres_per_unit,
                           std::vector<std::string>& notes) {
  return Cleaner(raw, metres_per_unit, notes).clean();
}

}  // namespace sanatrix::io
