#include "standing/nipples.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "standing/areola.hpp"
#include "standing/breast_pair.hpp"

namespace sanatrix::standing {
namespace {

using meshing::ColumnMap;

constexpr double fine_mm = 2.0;
constexpr double breast_radius_mm = 70.0;
constexpr double bump_reach_mm = 30.0;  ///< from where the shape puts the nipple
constexpr double bump_foot_mm = 14.0;   ///< a nipple's bump has fallen off this far from its top
constexpr double least_bump_mm = 2.0;   ///< of a nipple above the areola, smoothed
/// Nipples look this far outwards: measured, docs/theory/scan-only.md.
constexpr double apex_turn_deg = 20.0;
constexpr double climb_mm = 9.0;
/// 1 sd of a nipple's place, by what it was taken from; measured, docs/theory/scan-only.md.
constexpr double mark_doubt_mm = 2.0, colour_doubt_mm = 4.0, bump_doubt_mm = 6.0,
                 shape_doubt_mm = 13.0, small_shape_doubt_mm = 30.0;
/// A breast that stands less in front of the rolling ball says little about its nipple.
constexpr double small_rise_mm = 30.0;

/// Gaussian smoothing of a map, borders going on.
ColumnMap smoothed(const ColumnMap& map, double sigma_mm) {
  Image3<float> image{.size = {map.size[0], map.size[1], 1},
                      .spacing_mm = {map.spacing_mm, map.spacing_mm, map.spacing_mm},
                      .voxels = {map.value.begin(), map.value.end()}};
  smooth(image, sigma_mm);
  ColumnMap result = map;
  result.value.assign(image.voxels.begin(), image.voxels.end());
  return result;
}

Vec3 place(const ColumnMap& map, std::size_t column) {
  const auto nx = static_cast<std::size_t>(map.size[0]);
  const std::size_t i = column % nx, k = column / nx;
  return {map.origin_mm[0] + static_cast<double>(i) * map.spacing_mm, map.value[column],
          map.origin_mm[1] + static_cast<double>(k) * map.spacing_mm};
}

/// The most anterior skin of the breast around a first guess.
std::size_t foremost(const FrontMap& front, const ColumnMap& calm_y, const Vec3& guess_mm,
                     double reach_mm) {
  std::size_t best = calm_y.nearest(guess_mm[0], guess_mm[2]);
  double least = 1e300;
  for (std::size_t c = 0; c < calm_y.value.size(); ++c) {
    const Vec3 p = place(calm_y, c);
    const bool near = std::hypot(p[0] - guess_mm[0], p[2] - guess_mm[2]) < reach_mm;
    if (front.seen[c] && near && p[1] < least) {
      least = p[1];
      best = c;
    }
  }
  return best;
}

/// From the most anterior skin to the skin that is foremost in the direction in which breasts
/// point: outwards, as the chest that carries them is round. Climbs, so that an arm beside the
/// breast is not reached.
Vec3 apex(const FrontMap& front, const ColumnMap& calm_y, std::size_t from, std::size_t side,
          double reach_mm) {
  const double outwards = (side == 0 ? -1 : 1) * std::tan(apex_turn_deg * std::numbers::pi / 180);
  const auto height = [&](std::size_t c) {
    const Vec3 p = place(calm_y, c);
    return outwards * p[0] - p[1];
  };
  const Vec3 start = place(calm_y, from);
  std::size_t at = from, next = from;
  do {
    at = next;
    const Vec3 here = place(calm_y, at);
    for (std::size_t c = 0; c < calm_y.value.size(); ++c) {
      const Vec3 p = place(calm_y, c);
      if (front.seen[c] && std::hypot(p[0] - here[0], p[2] - here[2]) < climb_mm &&
          std::hypot(p[0] - start[0], p[2] - start[2]) < reach_mm && height(c) > height(next)) {
        next = c;
      }
    }
  } while (next != at);
  return place(calm_y, at);
}

/// The sharpest small bump near a place, if it is far sharper than the round skin beside it and
/// stands alone: a nipple. Towards a fold or an end of the scan the measure grows without a peak.
std::optional<Vec3> bump_near(const FrontMap& front, const ColumnMap& bump, const Vec3& guess_mm) {
  const auto apart = [&](std::size_t c, const Vec3& p) {
    const Vec3 q = place(front.skin_y, c);
    return std::hypot(p[0] - q[0], p[2] - q[2]);
  };
  std::size_t found = 0;
  double best = -1e300, sum = 0, count = 0;
  for (std::size_t c = 0; c < bump.value.size(); ++c) {
    if (front.seen[c] && apart(c, guess_mm) < bump_reach_mm) {
      sum += bump.value[c];
      count += 1;
      if (bump.value[c] > best) {
        best = bump.value[c];
        found = c;
      }
    }
  }
  if (count == 0 || best - sum / count < least_bump_mm) {
    return std::nullopt;
  }
  const Vec3 there = place(front.skin_y, found);
  for (std::size_t c = 0; c < bump.value.size(); ++c) {
    const double r = apart(c, there);
    const bool higher = bump.value[c] > best || !front.seen[c];
    const bool wide = r > bump_foot_mm - 4.0 && bump.value[c] > 0.6 * best;
    if (r < bump_foot_mm && (higher || wide)) {
      return std::nullopt;
    }
  }
  return there;
}

/// The notch between the collar bones: the hollow of the midline above the breasts.
std::optional<Vec3> notch_above(const FrontMap& front, const Vec3& middle_mm) {
  const ColumnMap fine = smoothed(front.skin_y, 4.0), coarse = smoothed(front.skin_y, 14.0);
  std::optional<Vec3> best;
  constexpr double least_hollow_mm = 2.5;
  double deepest = least_hollow_mm;
  for (std::size_t c = 0; c < fine.value.size(); ++c) {
    const Vec3 p = place(front.skin_y, c);
    const double up = p[2] - middle_mm[2];
    const bool inside = front.seen[front.skin_y.nearest(p[0], p[2] + 25)];
    if (front.seen[c] && inside && std::abs(p[0] - middle_mm[0]) < 12 && up > 110 && up < 260 &&
        fine.value[c] - coarse.value[c] > deepest) {
      deepest = fine.value[c] - coarse.value[c];
      best = p;
    }
  }
  return best;
}

/// Everything that is looked at to find nipples; turned into LPS, before the origin is known [mm].
class Search {
 public:
  explicit Search(const TexturedSurface& turned)
      : colours_(skin_colours(turned)),
        front_(front_map(turned.mesh, window_of(turned.mesh, 10.0), fine_mm)),
        calm_y_(smoothed(front_.skin_y, 3.0)),
        bump_(smoothed(front_.skin_y, 10.0)) {
    for (std::size_t c = 0; c < bump_.value.size(); ++c) {
      bump_.value[c] -= calm_y_.value[c];
    }
  }
  [[nodiscard]] const FrontMap& front() const { return front_; }

  [[nodiscard]] std::pair<Vec3, NippleFind> find(const BreastPair& pair, const ColumnMap& rise,
                                                 std::size_t side) const {
    const Vec3& tip_mm = pair.tip_mm[side];
    // Not over to the other breast: it may be the larger.
    const double reach_mm =
        std::min(breast_radius_mm, 0.5 * (pair.tip_mm[1][0] - pair.tip_mm[0][0]));
    const std::size_t start = foremost(front_, calm_y_, tip_mm, reach_mm);
    const Vec3 shape = apex(front_, calm_y_, start, side, reach_mm);
    if (const auto areola = find_areola(colours_, shape)) {
      return {areola->centre_mm, {NippleSign::Colour, colour_doubt_mm}};
    }
    if (const auto bump = bump_near(front_, bump_, shape)) {
      return {*bump, {NippleSign::Bump, bump_doubt_mm}};
    }
    // When the rise is a shoulder's, the foremost skin near it is a breast, or a flat chest.
    constexpr double least_rise = 0.5;  // of that of the rise
    const auto rise_at = [&](const Vec3& p) {
      return rise.value[rise.nearest(p[0], p[2])];
    };
    if (rise_at(shape) < least_rise * rise_at(tip_mm)) {
      throw Error(
          Fault::Input,
          fmt::format("the breasts do not stand forward of the trunk clearly enough to tell "
                      "where the {} nipple is",
                      side == 0 ? "right" : "left"),
          "mark both nipples and the sternal notch (--landmarks), or give a photograph");
    }
    const double doubt = rise_at(tip_mm) < small_rise_mm ? small_shape_doubt_mm : shape_doubt_mm;
    return {shape, {NippleSign::Shape, doubt}};
  }

 private:
  std::vector<ColourSample> colours_;
  FrontMap front_;
  ColumnMap calm_y_, bump_;
};

}  // namespace

void locate_nipples(const TexturedSurface& scan, const Mat3& rotation,
                    std::optional<double> middle_x_m, const ScanLandmarks& marks,
                    ScanFrame& frame) {
  TexturedSurface turned = scan;
  turned.mesh = moved(std::move(turned.mesh), {rotation, {}});
  const FrontMap rough = front_map(turned.mesh, window_of(turned.mesh, 10.0), 5.0);
  const auto middle_x_mm = middle_x_m ? std::optional(1e3 * *middle_x_m) : std::nullopt;
  const ColumnMap rise = meshing::prominence_of(rough.skin_y, search_ball);
  const auto pair = find_level_pair(rough, rise, middle_x_mm);
  const Search search(turned);
  const SurfaceTree skin(turned.mesh);
  std::array<Vec3, 2> nipple{};
  for (std::size_t side = 0; side < 2; ++side) {
    const char* name = side == 0 ? "right" : "left";
    if (marks.nipple[side]) {
      nipple[side] = skin.closest(rotation * *marks.nipple[side]).point;
      frame.nipple_find[side] = {NippleSign::Mark, mark_doubt_mm};
      continue;
    }
    if (!pair) {
      throw Error(Fault::Input, fmt::format("no breast is found on the patient's {}", name),
                  "mark both nipples and the sternal notch (--scan-landmarks)");
    }
    const auto [place_mm, find] = search.find(*pair, rise, side);
    nipple[side] = skin.closest(1e-3 * place_mm).point;
    frame.nipple_find[side] = find;
    if (find.sign == NippleSign::Shape) {
      frame.notes.push_back(
          fmt::format("the {} nipple shows neither in colour nor in shape; it is put where a "
                      "breast of this shape has it, +-{:.0f} mm (mark it: --landmarks)",
                      name, find.doubt_mm));
    }
  }
  Vec3 middle = 0.5 * (nipple[0] + nipple[1]);
  middle[0] = middle_x_m.value_or(middle[0]);
  frame.to_patient = {rotation, -1.0 * middle};
  frame.nipple = {nipple[0] - middle, nipple[1] - middle};
  if (marks.sternal_notch) {
    frame.sternal_notch = frame.to_patient(*marks.sternal_notch);
  } else if (const auto notch = notch_above(search.front(), 1e3 * middle)) {
    frame.sternal_notch = 1e-3 * *notch - middle;
  }
}

}  // namespace sanatrix::standing
