#include "standing/scan_frame.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"
#include "standing/breast_pair.hpp"
#include "standing/marks.hpp"
#include "standing/mirror.hpp"
#include "standing/nipples.hpp"

namespace sanatrix::standing {
namespace {

constexpr double search_edge_m = 0.005;
constexpr double search_spacing_mm = 5.0;
/// Less than this and two rises are folds of the skin or of clothes [cm3, see Found].
constexpr double least_score = 8.0;
/// Skin that stands less than this in front of the rolling ball is not breast [mm].
constexpr double still_mm = 6.0;
constexpr double most_turn = 0.94;  // cosine of 20 degrees
/// Cameras are levelled: an axis of the scanner this near to the body's axis is the vertical. The
/// trunk's own axis is up to 22 degrees off, its mean with that of nipples and notch 15.
constexpr double level_deg = 25.0, marked_level_deg = 15.0;
/// A trunk's axis farther from the scanner's is worth a word: she leans, or the scan is tilted.
constexpr double leaning_deg = 12.0;

/// Rows: the patient's left, back, up, as directions of the scan.
Mat3 axes(const Vec3& left_about, const Vec3& up) {
  const Vec3 left = normalised(left_about - dot(left_about, up) * up);
  return {left, cross(up, left), up};
}

struct Front {
  TriMesh surface;  ///< turned, [m]
  FrontMap map;
  meshing::ColumnMap prominence;
};

Front look(const TriMesh& scan, const Mat3& rotation) {
  Front front{moved(scan, {rotation, {}}), {}, {}};
  front.map =
      front_map(front.surface, window_of(front.surface, search_spacing_mm), search_spacing_mm);
  front.prominence = meshing::prominence_of(front.map.skin_y, search_ball);
  return front;
}

/// Sum of area x normal, and of area x |its part| over all triangles.
Vec3 mean_normal(const TriMesh& scan) {
  Vec3 sum{};
  double total = 0;
  for (const auto& [a, b, c] : scan.triangles) {
    const Vec3& p = scan.points[static_cast<std::size_t>(a)];
    const Vec3 n = cross(scan.points[static_cast<std::size_t>(b)] - p,
                         scan.points[static_cast<std::size_t>(c)] - p);
    sum += n;
    total += norm(n);
  }
  return (1 / total) * sum;
}

/// A direction, and six 20 degrees beside it.
std::vector<Vec3> about(const Vec3& front) {
  constexpr double beside = 0.36;  // tan 20 degrees
  const Vec3 any = std::abs(front[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalised(cross(front, any)), v = cross(front, u);
  std::vector<Vec3> fronts{front};
  for (int i = 0; i < 6; ++i) {
    const double turn = std::numbers::pi * i / 3;
    fronts.push_back(normalised(front + beside * (std::cos(turn) * u + std::sin(turn) * v)));
  }
  return fronts;
}

/// All round, 30 degrees apart.
std::vector<Vec3> all_directions() {
  constexpr int rings = 6;
  std::vector<Vec3> fronts;
  for (int r = 0; r <= rings; ++r) {
    const double polar = std::numbers::pi * r / rings;
    const int count = std::max(1, static_cast<int>(std::lround(12 * std::sin(polar))));
    for (int i = 0; i < count; ++i) {
      const double turn = 2 * std::numbers::pi * i / count;
      fronts.push_back(
          {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
    }
  }
  return fronts;
}

Mat3 facing(const Vec3& front) {
  const Vec3 any = std::abs(front[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return axes(any - dot(any, front) * front, normalised(cross(front, any)));
}

/// A turn that brings a pair of breasts level, with their upper poles upwards.
struct Found {
  Mat3 rotation = identity3;
  double score = 0.0;  ///< of the pair, times how much steeper its lower side is: breasts have one
};

/// The likeliest turns seen from some directions, the best first.
std::vector<Found> search(const TriMesh& coarse, const std::vector<Vec3>& fronts) {
  constexpr std::size_t per_direction = 6, in_all = 24;
  std::vector<Found> found;
  for (const Vec3& direction : fronts) {
    Mat3 rotation = facing(direction);
    // axes() makes left x up point to the back: turn it so that back is away from the front.
    if (dot(rotation[1], direction) > 0) {
      rotation = {-1.0 * rotation[0], -1.0 * rotation[1], rotation[2]};
    }
    const Front front = look(coarse, rotation);
    auto pairs = find_pairs(front.map, front.prominence);
    pairs.resize(std::min(pairs.size(), per_direction));
    for (const BreastPair& pair : pairs) {
      const double sign = pair.upper_pole >= 0 ? 1.0 : -1.0;
      const Vec3 along = sign * (pair.tip_mm[1] - pair.tip_mm[0]);
      const Mat3 level = axes({along[0], 0, along[2]}, normalised({-along[2], 0, along[0]}));
      found.push_back({level * rotation, pair.score * std::abs(pair.upper_pole)});
    }
  }
  std::ranges::stable_sort(found, std::greater{}, &Found::score);
  found.resize(std::min(found.size(), in_all));
  return found;
}

/// The vertical in the plane across the line of the nipples: the trunk is drawn out along it, so
/// that the normals of skin beside the breasts have the least part in it.
Vec3 trunk_axis(const Front& front, double middle_x_mm, double middle_z_mm) {
  // Farther up the chest slopes back to the shoulders.
  constexpr double half_width_mm = 140.0, above_mm = 100.0, below_mm = 180.0;
  double yy = 0, yz = 0, zz = 0;
  for (const auto& [a, b, c] : front.surface.triangles) {
    const Vec3& p = front.surface.points[static_cast<std::size_t>(a)];
    const Vec3& q = front.surface.points[static_cast<std::size_t>(b)];
    const Vec3& r = front.surface.points[static_cast<std::size_t>(c)];
    const Vec3 centre = (1e3 / 3) * (p + q + r);
    const bool near = std::abs(centre[0] - middle_x_mm) < half_width_mm &&
                      centre[2] - middle_z_mm < above_mm && middle_z_mm - centre[2] < below_mm;
    const std::size_t column = front.prominence.nearest(centre[0], centre[2]);
    if (near && front.prominence.value[column] < still_mm) {
      const Vec3 n = cross(q - p, r - p);
      const double weight = 1 / std::max(norm(n), 1e-12);
      yy += weight * n[1] * n[1];
      yz += weight * n[1] * n[2];
      zz += weight * n[2] * n[2];
    }
  }
  // The least eigenvector of [yy yz; yz zz], z upwards.
  const double angle = 0.5 * std::atan2(2 * yz, yy - zz);
  const Vec3 axis{0, -std::sin(angle), std::cos(angle)};
  return axis[2] < 0 ? -1.0 * axis : axis;
}

/// How she stands, and where her middle is, if her trunk has one.
struct Stance {
  Mat3 rotation = identity3;
  std::optional<double> middle_x_m;  ///< of the turned scan
  double symmetry = 0.0;             ///< share of still skin that lies on its mirror image
};

/// Rows for a left that is kept and an upwards direction that is made perpendicular to it.
Mat3 keeping_left(const Vec3& left, const Vec3& up_about) {
  const Vec3 up = normalised(up_about - dot(up_about, left) * left);
  return {left, cross(up, left), up};
}

/// Right and left, in the scan's own frame [m].
using MarkedNipples = std::optional<std::array<Vec3, 2>>;

/// Turns the frame by the mirror symmetry of what is not breast and by the trunk's own axis. What
/// is marked counts, not what looks like breasts.
Stance refined(const TriMesh& coarse, const Mat3& rotation, const std::optional<Vec3>& up,
               const MarkedNipples& marked) {
  const Front front = look(coarse, rotation);
  const auto pair = find_level_pair(front.map, front.prominence);
  if (!pair && !marked) {
    return {rotation, {}};
  }
  const auto tip_mm = [&](std::size_t side) {
    return marked ? 1e3 * (rotation * (*marked)[side]) : pair->tip_mm[side];
  };
  const Vec3 middle = 0.5 * (tip_mm(0) + tip_mm(1));
  const Vec3 along = normalised(tip_mm(1) - tip_mm(0));
  std::vector<bool> still;
  for (const Vec3& p : front.surface.points) {
    const bool near =
        std::abs(1e3 * p[0] - middle[0]) < 170 && std::abs(1e3 * p[2] - middle[2]) < 200;
    const double rise = front.prominence.value[front.prominence.nearest(1e3 * p[0], 1e3 * p[2])];
    still.push_back(near && rise < still_mm);
  }
  MirrorPlane mirror = fit_mirror(front.surface, still, {along, 1e-3 * dot(along, middle)});
  // Of breasts of two sizes one nipple lies farther back, as if she had turned.
  for (const double turn : {-0.25, 0.25}) {
    const Vec3 turned = normalised(along + turn * cross(Vec3{0, 0, 1}, along));
    const MirrorPlane other =
        marked ? fit_mirror(front.surface, still, {turned, 1e-3 * dot(turned, middle)}) : mirror;
    if (other.share > mirror.share) {
      mirror = other;
    }
  }
  // Symmetry that contradicts the breasts by far has found something else.
  constexpr double most_shift_m = 0.025;
  const bool agree = dot(mirror.normal, along) > most_turn &&
                     std::abs(dot(mirror.normal, 1e-3 * middle) - mirror.offset_m) < most_shift_m;
  const Vec3 left = agree ? mirror.normal : along;
  const Mat3 turn = up ? axes(left, normalised(rotation * *up))
                       : keeping_left(left, trunk_axis(front, middle[0], middle[2]));
  return {turn * rotation, agree && !up ? std::optional(mirror.offset_m) : std::nullopt,
          agree ? mirror.share : 0.0};
}

/// An axis of the scanner near a direction.
std::optional<Vec3> level_of(const Vec3& up, double most_deg) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::abs(up[a]) > std::cos(most_deg * std::numbers::pi / 180)) {
      Vec3 level{};
      level[a] = up[a] > 0 ? 1.0 : -1.0;
      return level;
    }
  }
  return std::nullopt;
}

/// From marked nipples and notch: the notch lies above and about 20 degrees behind the nipples.
Mat3 marked_rotation(const ScanLandmarks& marks) {
  const Vec3 along = *marks.nipple[1] - *marks.nipple[0];
  const Vec3 rise = *marks.sternal_notch - 0.5 * (*marks.nipple[0] + *marks.nipple[1]);
  const Mat3 rough = axes(along, normalised(rise - (dot(rise, along) / dot(along, along)) * along));
  constexpr double back = 0.36;  // tan 20 degrees
  return axes(along, normalised(rough[2] - back * rough[1]));
}

/// Of the likeliest turns the one whose trunk is its own mirror image (a breast and an arm are
/// not), and that most others agree with.
Stance best_stance(const TriMesh& coarse, const std::vector<Vec3>& fronts,
                   const std::optional<Vec3>& up) {
  std::vector<std::pair<Stance, double>> stances;
  for (const Found& found : search(coarse, fronts)) {
    Mat3 rotation = found.rotation;
    if (up && dot(rotation[2], *up) < 0) {  // what is said counts more than the breasts' shape
      rotation = {-1.0 * rotation[0], rotation[1], -1.0 * rotation[2]};
    }
    if (found.score > least_score) {
      const Stance stance = refined(coarse, rotation, up, std::nullopt);
      stances.emplace_back(stance, found.score * std::pow(stance.symmetry, 4));
    }
  }
  std::ranges::stable_sort(stances, std::greater{}, &std::pair<Stance, double>::second);
  Stance best;
  double most = 0.0;
  for (const auto& [stance, merit] : stances) {
    double votes = 0.0;
    for (const auto& [other, vote] : stances) {
      const bool agrees = dot(other.rotation[0], stance.rotation[0]) > most_turn &&
                          dot(other.rotation[2], stance.rotation[2]) > 0.8;
      votes += agrees ? vote : 0.0;
    }
    if (votes > most) {
      most = votes;
      best = stance;
    }
  }
  if (most == 0.0) {
    throw Error(Fault::Input,
                "no two breasts side by side are found on the scan, so it is not known how the "
                "patient stands in it",
                "give a scan of the bare trunk, without wall or chair, or mark the nipples and the "
                "sternal notch "
                "(--scan-landmarks)");
  }
  return best;
}

/// The front is where the skin looks on average, or, when the scan goes round the body, found among
/// all directions and looked at again. Arms and what is missing at the back turn the mean.
Stance found_stance(const TriMesh& coarse, const std::optional<Vec3>& up) {
  const Vec3 mean = mean_normal(coarse);
  constexpr double one_sided = 0.2;
  const Vec3 front = norm(mean) > one_sided
                         ? normalised(mean)
                         : -1.0 * best_stance(coarse, all_directions(), up).rotation[1];
  return best_stance(coarse, about(front), up);
}

/// A breast and something else that stands forward, a shoulder or a flank, are neither mirror
/// images nor on a trunk that is one: found when a breast is missing or flat.
void check_pair(const ScanFrame& frame, double symmetry) {
  constexpr double least_symmetry = 0.6;                       // of skin that is not breast; chosen
  constexpr double most_unlike_m = 0.05, least_apart_m = 0.1;  // of the nipples of one patient
  const Vec3 &right = frame.nipple[0], &left = frame.nipple[1];
  const double unlike = std::hypot(right[0] + left[0], right[2] - left[2]);
  if (symmetry < least_symmetry || unlike > most_unlike_m || left[0] - right[0] < least_apart_m) {
    throw Error(Fault::Input,
                fmt::format("the two breasts that are found are no pair: of the trunk around them "
                            "{:.0f} % is symmetric, and the nipples lie {:.0f} mm apart, {:.0f} mm "
                            "from being mirror images; a breast may be missing, flat or covered",
                            100 * symmetry, 1e3 * (left[0] - right[0]), 1e3 * unlike),
                "when both are there, mark both nipples and the sternal notch (--landmarks)");
  }
}

/// The scanner's vertical where the body agrees with it, else the body's own; `marked_up` is what
/// marked nipples and notch say of it.
void set_vertical(Stance& stance, const std::optional<Vec3>& marked_up, ScanFrame& frame) {
  const Vec3 own = stance.rotation[2];
  const Vec3 body = marked_up ? normalised(own + *marked_up) : own;
  const char* name = marked_up ? "that of trunk and marks" : "the trunk's own";
  const auto level = level_of(body, marked_up ? marked_level_deg : level_deg);
  if (!level) {
    stance.rotation = keeping_left(stance.rotation[0], body);
    frame.notes.push_back(
        fmt::format("the vertical is {}, as no axis of the scanner is near it; it may be 10 "
                    "degrees off (mark \"up\" to be sure)",
                    name));
    return;
  }
  stance.rotation = keeping_left(stance.rotation[0], *level);
  const double apart = std::acos(std::min(1.0, dot(body, *level))) * 180 / std::numbers::pi;
  frame.notes.push_back(fmt::format(
      "the vertical is the scanner's axis, {:.0f} degrees from {}{}", apart, name,
      apart > leaning_deg ? ": if she did not lean, the scan is tilted (mark \"up\")" : ""));
}

}  // namespace

ScanFrame find_frame(const TexturedSurface& scan, const ScanLandmarks& marks) {
  const TriMesh coarse = outcome::coarsened(scan.mesh, search_edge_m);
  ScanFrame frame;
  check_marks(coarse, marks);
  const std::optional<Vec3> up = marks.up ? std::optional(normalised(*marks.up)) : std::nullopt;
  MarkedNipples nipples;
  if (marks.nipple[0] && marks.nipple[1]) {
    nipples = {*marks.nipple[0], *marks.nipple[1]};
  }
  const bool marked = nipples && marks.sternal_notch;
  Stance stance =
      marked ? refined(coarse, marked_rotation(marks), up, nipples) : found_stance(coarse, up);
  if (const Stance again = refined(coarse, stance.rotation, up, nipples);
      again.symmetry >= 0.9 * stance.symmetry) {
    stance = again;
  }
  if (!up) {
    set_vertical(stance, marked ? std::optional(marked_rotation(marks)[2]) : std::nullopt, frame);
  }
  locate_nipples(scan, stance.rotation, stance.middle_x_m, marks, frame);
  check_marks(frame, marks);
  if (!nipples) {
    check_pair(frame, stance.symmetry);
  }
  return frame;
}

}  // namespace sanatrix::standing
