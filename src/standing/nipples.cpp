#include "standing/nipples.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "standing/breast_pair.hpp"

namespace sanatrix::standing {
namespace {

using meshing::ColumnMap;

constexpr double fine_mm = 2.0;
constexpr double breast_radius_mm = 70.0;
constexpr double nipple_reach_mm = 30.0;  ///< from the tip of the breast
constexpr double least_bump_mm = 2.0;     ///< of a nipple above the areola, smoothed

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
  return {map.origin_mm[0] + static_cast<double>(column % nx) * map.spacing_mm, map.value[column],
          map.origin_mm[1] + static_cast<double>(column / nx) * map.spacing_mm};
}

struct Tip {
  Vec3 place_mm;
  bool is_bump;
};

/// The most anterior skin of the breast around a first guess.
Vec3 foremost(const FrontMap& front, const ColumnMap& calm_y, const Vec3& guess_mm) {
  Vec3 best = guess_mm;
  double least = 1e300;
  for (std::size_t c = 0; c < calm_y.value.size(); ++c) {
    const Vec3 p = place(calm_y, c);
    const bool near = std::hypot(p[0] - guess_mm[0], p[2] - guess_mm[2]) < breast_radius_mm;
    if (front.seen[c] && near && p[1] < least) {
      least = p[1];
      best = p;
    }
  }
  return best;
}

/// The nipple as the sharpest small bump near the tip of the breast, if it is one: far sharper than
/// the round skin beside it. Else the tip.
Tip nipple_near(const FrontMap& front, const ColumnMap& bump, const Vec3& tip_mm) {
  Tip found{tip_mm, false};
  double best = -1e300, sum = 0, count = 0;
  for (std::size_t c = 0; c < bump.value.size(); ++c) {
    const Vec3 p = place(front.skin_y, c);
    const double apart = std::hypot(p[0] - tip_mm[0], p[2] - tip_mm[2]);
    if (!front.seen[c] || apart > nipple_reach_mm) {
      continue;
    }
    sum += bump.value[c];
    count += 1;
    if (bump.value[c] > best) {
      best = bump.value[c];
      found.place_mm = p;
    }
  }
  found.is_bump = count > 0 && best - sum / count > least_bump_mm;
  return found.is_bump ? found : Tip{tip_mm, false};
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

}  // namespace

void locate_nipples(const TriMesh& scan, const Mat3& rotation, const ScanLandmarks& marks,
                    ScanFrame& frame) {
  const TriMesh turned = moved(scan, {rotation, {}});
  const FrontWindow window = window_of(turned, 10.0);
  const FrontMap rough = front_map(turned, window, 5.0);
  const auto pair = find_pair(rough, meshing::prominence_of(rough.skin_y, search_ball));
  const FrontMap front = front_map(turned, window, fine_mm);
  ColumnMap bump = smoothed(front.skin_y, 10.0);
  const ColumnMap fine = smoothed(front.skin_y, 3.0);
  for (std::size_t c = 0; c < bump.value.size(); ++c) {
    bump.value[c] -= fine.value[c];
  }
  const SurfaceTree skin(turned);
  std::array<Vec3, 2> nipple{};
  for (std::size_t side = 0; side < 2; ++side) {
    if (marks.nipple[side]) {
      nipple[side] = skin.closest(rotation * *marks.nipple[side]).point;
      continue;
    }
    if (!pair) {
      throw Error(
          Fault::Input,
          fmt::format("no breast is found on the patient's {}", side == 0 ? "right" : "left"),
          "mark both nipples and the sternal notch (--scan-landmarks)");
    }
    const Tip tip = nipple_near(front, bump, foremost(front, fine, pair->tip_mm[side]));
    nipple[side] = skin.closest(1e-3 * tip.place_mm).point;
    if (!tip.is_bump) {
      frame.notes.push_back(
          fmt::format("the {} nipple does not stand out; the tip of the breast is taken for it",
                      side == 0 ? "right" : "left"));
    }
  }
  const Vec3 middle = 0.5 * (nipple[0] + nipple[1]);
  frame.to_patient = {rotation, -1.0 * middle};
  frame.nipple = {nipple[0] - middle, nipple[1] - middle};
  if (marks.sternal_notch) {
    frame.sternal_notch = frame.to_patient(*marks.sternal_notch);
  } else if (const auto notch = notch_above(front, 1e3 * middle)) {
    frame.sternal_notch = 1e-3 * *notch - middle;
  }
}

}  // namespace sanatrix::standing
