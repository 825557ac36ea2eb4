// The excised volume as an implicit function: placement of the axis, the shape, its one piece.
#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::surgery {
namespace {

constexpr double mm = 1e-3, degree = std::numbers::pi / 180.0;
/// Radius of the rounding between side and caps: what a scalpel leaves, and large against the
/// 3 mm elements that have to carry it.
constexpr double usual_blend = 4.0 * mm;
/// Chest faces are averaged with a Gaussian of this width: wider than a rib, narrower than a
/// breast.
constexpr double normal_smoothing = 20.0 * mm;
/// The rounded maximum of three distances changes at most sqrt(3) per metre.
constexpr double steepest = 1.7320508;
/// Edge of the small tetrahedra of cut cells: against the 4 mm rounding they err by 0.1 mm.
double lattice_edge(Detail detail) {
  return (detail == Detail::Full ? 2.0 : 4.5) * mm;
}

/// Distance to a polygon's edges, negative inside (even-odd rule, so the sense does not matter).
double polygon_distance(const std::vector<std::array<double, 2>>& polygon, double x, double y) {
  double best = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto& [ax, ay] = polygon[j];
    const auto& [bx, by] = polygon[i];
    const double ux = bx - ax, uy = by - ay, length2 = ux * ux + uy * uy;
    const double t =
        length2 > 0.0 ? std::clamp(((x - ax) * ux + (y - ay) * uy) / length2, 0.0, 1.0) : 0.0;
    best = std::min(best, std::hypot(x - ax - t * ux, y - ay - t * uy));
    if ((ay > y) != (by > y) && x < ax + (y - ay) / uy * ux) {
      inside = !inside;
    }
  }
  return inside ? -best : best;
}

std::string in_mm(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", p[0] / mm, p[1] / mm, p[2] / mm);
}

/// Unit direction into the body: chest faces around `foot`, whose outward normals point backwards.
Vec3 smoothed_chest_normal(const TriMesh& chest, const Vec3& foot) {
  Vec3 sum{};
  for (const auto& [i, j, k] : chest.triangles) {
    const Vec3 &a = chest.points[i], &b = chest.points[j], &c = chest.points[k];
    const double d = norm((1.0 / 3.0) * (a + b + c) - foot) / normal_smoothing;
    sum += std::exp(-d * d) * cross(c - a, b - a);  // its length is the area's double
  }
  require(norm(sum) > 0.0, "surgery: no chest wall within reach of {}", in_mm(foot));
  return normalised(sum);
}

/// Smallest t > 0 with origin + t direction on the surface (Moller and Trumbore 1997,
/// doi:10.1080/10867651.1997.10487468).
std::optional<double> first_hit(const TriMesh& surface, const Vec3& origin, const Vec3& direction) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k] : surface.triangles) {
    const Vec3 u = surface.points[j] - surface.points[i], v = surface.points[k] - surface.points[i];
    const Vec3 s = origin - surface.points[i], h = cross(direction, v), q = cross(s, u);
    const double det = dot(u, h);
    const double a = dot(s, h) / det, b = dot(direction, q) / det, t = dot(v, q) / det;
    // A hair beyond the edges, so that no ray slips between two triangles.
    constexpr double slack = 1e-9;
    if (a >= -slack && b >= -slack && a + b <= 1.0 + slack && t > 0.0) {
      best = std::min(best, t);
    }
  }
  return std::isfinite(best) ? std::optional(best) : std::nullopt;
}

/// Share of a tetrahedron below zero of the linear function with these corner values.
double share_below_zero(std::array<double, 4> f) {
  std::ranges::sort(f);
  if (f[3] <= 0.0) {
    return 1.0;
  }
  if (f[0] >= 0.0) {
    return 0.0;
  }
  const auto corner = [&f](int at, int x, int y, int z) {
    return f[at] / (f[at] - f[x]) * f[at] / (f[at] - f[y]) * f[at] / (f[at] - f[z]);
  };
  if (f[1] >= 0.0) {
    return corner(0, 1, 2, 3);
  }
  if (f[2] < 0.0) {
    return 1.0 - corner(3, 0, 1, 2);
  }
  // Two and two: the wedge at corners 0 and 1, as three tetrahedra.
  const double s02 = f[0] / (f[0] - f[2]), s03 = f[0] / (f[0] - f[3]);
  const double s12 = f[1] / (f[1] - f[2]), s13 = f[1] / (f[1] - f[3]);
  return s02 * s03 + s12 * s13 * (1.0 - s02) + s02 * s13 * (1.0 - s03);
}

}  // namespace

Resection::Resection(const Plan& plan, const TetMesh& mesh, std::span<const Vec3> points,
                     double midline_x_m, Detail detail)
    : Resection(plan, std::make_shared<const Anatomy>(mesh, points, midline_x_m), detail) {}

Resection::Resection(const Plan& plan, std::shared_ptr<const Anatomy> anatomy, Detail detail)
    : anatomy_(std::move(anatomy)),
      skin_tree_{&anatomy_->skin_tree()},
      chest_tree_{&anatomy_->chest_tree()},
      centre_(plan.tumour_centre),
      radius_(plan.radius.value_or(plan.tumour_radius + plan.margin)),
      clearance_(plan.clearance),
      detail_(detail) {
  // Caps that are nearer to a surface than the field's cells are wide are measured.
  if (detail == Detail::Live && clearance_ >= 1.6 * DistanceField::step) {
    skin_tree_.field = &anatomy_->to_skin();
    chest_tree_.field = &anatomy_->to_chest();
  }
  const double midline_x_m = anatomy_->midline_x_m();
  require((centre_[0] > midline_x_m) == (plan.side == Side::Left),
          "surgery: operated_side is {} but the tumour at x = {:.1f} mm lies on the other side of "
          "the model's midline at {:.1f} mm",
          plan.side == Side::Left ? "L" : "R", centre_[0] / mm, midline_x_m / mm);
  if (!anatomy_->body().locate(centre_)) {
    throw Error(Fault::Input,
                "surgery: the tumour centre " + in_mm(centre_) + " is outside the breast model",
                "check tumour.centre_lps_mm (LPS millimetres) and the plan's frame");
  }
  place_axis(plan);
  place_outline(plan);
  const double room = norm(skin_ - chest_) - 2.0 * clearance_;
  require(room > 0.0,
          "surgery: skin and chest wall are {:.1f} mm apart at the tumour, nothing is left between "
          "the two clearances of {:.1f} mm; reduce clearance_mm",
          norm(skin_ - chest_) / mm, clearance_ / mm);
  blend_ = std::min({usual_blend, 0.4 * radius_, 0.4 * room});
  fill_piece();
}

void Resection::place_axis(const Plan& plan) {
  const TriMesh &skin = anatomy_->skin().mesh, &chest = anatomy_->chest().mesh;
  const Vec3 foot = anatomy_->chest_tree().closest(centre_).point;
  axis_ = plan.axis ? normalised(*plan.axis) : smoothed_chest_normal(chest, foot);
  const auto up = first_hit(skin, centre_, axis_);
  if (!up) {
    throw Error(
        Fault::Input,
        "surgery: the axis from the tumour at " + in_mm(centre_) + " does not meet the skin",
        "check resection.axis_towards_skin_lps, or leave it out for the chest-wall normal");
  }
  skin_ = centre_ + *up * axis_;
  const auto down = first_hit(chest, centre_, -1.0 * axis_);
  require(down || dot(centre_ - foot, axis_) > 0.0,
          "surgery: resection.axis_towards_skin_lps points to the chest wall, not to the skin");
  // Beside the meshed chest wall (near a clip plane) the foot of the tumour stands in for it.
  chest_ = down ? centre_ - *down * axis_ : foot;
}

/// Sector or curve as a polygon across the axis, around the tumour's centre.
void Resection::place_outline(const Plan& plan) {
  const Vec3 helper = std::abs(axis_[2]) < 0.7 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  grid_.e1 = normalised(cross(helper, axis_));
  grid_.e2 = cross(axis_, grid_.e1);
  if (plan.segment) {
    outline_ = sector(*plan.segment);
  }
  for (const Vec3& p : plan.outline) {
    outline_.push_back({dot(p - centre_, grid_.e1), dot(p - centre_, grid_.e2)});
  }
  if (outline_.empty()) {
    return;
  }
  radius_ = 0.0;
  for (const auto& [x, y] : outline_) {
    radius_ = std::max(radius_, std::hypot(x, y));
  }
  require(polygon_distance(outline_, 0.0, 0.0) < 0.0,
          "surgery: the tumour's centre is not inside the {}",
          plan.segment ? "segment; change where it begins or ends"
                       : "drawn outline; draw it around the tumour");
}

/// The sector's corners around the tumour's centre, across the axis. Its arcs are drawn in steps
/// whose chords stay within 0.1 mm of them for the largest breast.
std::vector<std::array<double, 2>> Resection::sector(const Segment& segment) const {
  const Vec3 r = segment.apex - centre_;
  const double ax = dot(r, grid_.e1), ay = dot(r, grid_.e2), distance = std::hypot(ax, ay);
  constexpr double widest_by_itself = 60.0 * degree;
  require(distance > 2.0 * mm && (segment.angle || radius_ < distance * std::sin(widest_by_itself)),
          "surgery: the tumour is {:.1f} mm from the nipple, too near for a segment that keeps its "
          "margin at both sides; choose a cylinder or an outline, or give angle_deg",
          distance / mm);
  const double half =
      segment.angle ? 0.5 * *segment.angle : std::asin(std::min(radius_ / distance, 1.0));
  const double from = segment.from.value_or(std::max(0.0, distance - radius_));
  const double to = segment.to.value_or(distance + radius_);
  require(to > from, "surgery: the segment ends at {:.1f} mm, before it begins at {:.1f} mm",
          to / mm, from / mm);
  const double middle = std::atan2(-ay, -ax);
  const int steps = std::max(2, static_cast<int>(std::ceil(2.0 * half / (4.0 * degree))));
  std::vector<std::array<double, 2>> corners;
  const auto arc = [&](double radius, double sign) {
    for (int i = 0; i <= (radius > 0.0 ? steps : 0); ++i) {
      const double angle = middle + sign * half * (2.0 * i / steps - 1.0);
      corners.push_back({ax + radius * std::cos(angle), ay + radius * std::sin(angle)});
    }
  };
  arc(to, 1.0);
  arc(from, -1.0);
  return corners;
}

double Resection::lateral(const Vec3& p) const {
  if (!outline_.empty()) {
    return polygon_distance(outline_, dot(p - centre_, grid_.e1), dot(p - centre_, grid_.e2));
  }
  return norm(cross(p - centre_, axis_)) - radius_;
}

Resection::Caps Resection::caps_near(const Vec3& p, double reach) const {
  const double far = clearance_ + blend_ + reach;
  std::array<int, 3> at{};
  const auto position = grid_position(p);
  std::ranges::transform(position, at.begin(),
                         [](double x) { return static_cast<int>(std::lround(x)); });
  double skin = 0.0, chest = 0.0;
  if (grid_.holds(at) && grid_.samples[grid_.index(at)].depth > 0.0F) {
    const Sample& near = grid_.samples[grid_.index(at)];
    const double way = norm(p - sample_point(at[0], at[1], at[2]));
    skin = near.skin - way;
    chest = near.chest - way;
  }
  return {skin < far && skin_tree_.distance(p, far) < far,
          chest < far && chest_tree_.distance(p, far) < far};
}

// Intersection of three half-spaces given by distances, with circular edges of radius `blend_`
// inside them: never beyond any of the three, and equal to each where the others are far.
double Resection::shape(const Vec3& p, Caps caps) const {
  const double none = -std::numeric_limits<double>::infinity();
  const double reach = clearance_ + blend_;  // beyond it a cap does not touch the shape
  const std::array<double, 3> f{lateral(p),
                                caps.skin ? clearance_ - skin_tree_.distance(p, reach) : none,
                                caps.chest ? clearance_ - chest_tree_.distance(p, reach) : none};
  double squares = 0.0;
  for (const double x : f) {
    const double over = std::max(x + blend_, 0.0);
    squares += over * over;
  }
  return std::min(*std::ranges::max_element(f), -blend_) + std::sqrt(squares);
}

double Resection::value(const Vec3& p, Caps caps) const {
  const double f = shape(p, caps);
  return f >= 0.0 || in_piece(p) ? f : -f;
}

double Resection::signed_distance(const Vec3& p) const {
  return value(p, caps_near(p, 0.0));
}

// Linear interpolation on a lattice of n^3 equal small tetrahedra (Kuhn's subdivision, in which the
// cell is the simplex 0 <= z <= y <= x <= n): corners are shared, so closest-point searches are
// few.
double Resection::cut_share(const std::array<Vec3, 4>& t, int n, Caps caps) const {
  const auto width = static_cast<std::size_t>(n + 1);
  const auto index = [width](const std::array<int, 3>& at) {
    return (static_cast<std::size_t>(at[0]) * width + static_cast<std::size_t>(at[1])) * width +
           static_cast<std::size_t>(at[2]);
  };
  const auto in_cell = [n](const std::array<int, 3>& at) {
    return at[0] <= n && at[1] <= at[0] && at[2] <= at[1];
  };
  const double step = 1.0 / n;
  std::vector<double> f(width * width * width);
  for (int x = 0; x <= n; ++x) {
    for (int y = 0; y <= x; ++y) {
      for (int z = 0; z <= y; ++z) {
        const Vec3 p = t[0] + step * (x * (t[1] - t[0]) + y * (t[2] - t[1]) + z * (t[3] - t[2]));
        f[index({x, y, z})] = value(p, caps);
      }
    }
  }
  constexpr std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  double sum = 0.0;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y <= x; ++y) {
      for (int z = 0; z <= y; ++z) {
        for (const auto& order : orders) {
          std::array<int, 3> at{x, y, z};
          std::array<double, 4> corners{f[index(at)], 0, 0, 0};
          bool inside = true;
          for (std::size_t i = 0; i < 3 && inside; ++i) {
            ++at[order[i]];
            inside = in_cell(at);
            corners[i + 1] = inside ? f[index(at)] : 0.0;
          }
          sum += inside ? share_below_zero(corners) : 0.0;
        }
      }
    }
  }
  return sum * step * step * step;
}

double Resection::volume_fraction(const std::array<Vec3, 4>& corners) const {
  const Vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  double reach = 0.0, edge = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    reach = std::max(reach, norm(corners[i] - middle));
    for (std::size_t j = 0; j < i; ++j) {
      edge = std::max(edge, norm(corners[i] - corners[j]));
    }
  }
  if (lateral(middle) > reach) {
    return 0.0;
  }
  const Caps caps = caps_near(middle, reach);
  const double f = value(middle, caps);
  if (std::abs(f) > steepest * reach) {
    return f < 0.0 ? 1.0 : 0.0;
  }
  return cut_share(corners, static_cast<int>(std::ceil(edge / lattice_edge(detail_))), caps);
}

}  // namespace sanatrix::surgery
