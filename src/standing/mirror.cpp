#include "standing/mirror.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "outcome/scan_target.hpp"

namespace sanatrix::standing {
namespace {

constexpr int rounds = 25, least_points = 100;
/// Skin farther from its mirror image has none, as an arm that is held elsewhere; from the first
/// round to the last.
constexpr double first_reach_m = 0.030, last_reach_m = 0.010;
constexpr double match_m = 0.005;
/// Keeps steps small in directions that the surface leaves open; part of what it says of others.
constexpr double damping = 1e-3;

struct Point {
  Vec3 place;
  double weight;
};

/// One Gauss-Newton step: two turns of the normal and the shift of the plane. Places are relative
/// to their centre. Also finds plane.share.
void improve(const outcome::ScanTarget& target, const std::vector<Point>& points,
             const Vec3& centre, double reach_m, MirrorPlane& plane) {
  const Vec3& n = plane.normal;
  const Vec3 any = std::abs(n[2]) < 0.8 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  const Vec3 u = normalised(cross(n, any)), v = cross(n, u);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double all = 0, matched = 0;
  for (const Point& point : points) {
    all += point.weight;
    const double across = dot(n, point.place) - plane.offset_m;
    const Vec3 mirrored = point.place - (2 * across) * n;
    const auto hit = target.closest(centre + mirrored);
    if (hit.on_border || hit.distance > 2 * reach_m) {
      continue;
    }
    const double r = dot(hit.normal, hit.point - centre - mirrored);
    const double far = r / reach_m;
    matched += std::abs(r) < match_m ? point.weight : 0.0;
    const double weight = point.weight * std::max(0.0, 1 - far * far);
    // The mirror image is p - 2 (n.p - c) n; this is how it moves with n and c.
    const auto slope = [&](const Vec3& turn) {
      return -2 * dot(hit.normal, dot(turn, point.place) * n + across * turn);
    };
    const Eigen::Vector3d j(slope(u), slope(v), 2 * dot(hit.normal, n));
    matrix += weight * j * j.transpose();
    right += weight * r * j;
  }
  plane.share = matched / all;
  // A turn by one moves skin as far as the shift by the trunk's radius.
  constexpr double radius_m = 0.15;
  const double turn_scale =
      damping * std::max(matrix(2, 2) * radius_m * radius_m, matrix(0, 0) + matrix(1, 1));
  matrix(0, 0) += turn_scale;
  matrix(1, 1) += turn_scale;
  matrix(2, 2) += damping * matrix(2, 2);
  const Eigen::Vector3d step = matrix.ldlt().solve(right);
  if (step.allFinite()) {
    plane.normal = normalised(n + step[0] * u + step[1] * v);
    plane.offset_m += step[2];
  }
}

}  // namespace

MirrorPlane fit_mirror(const TriMesh& surface, const std::vector<bool>& counts, MirrorPlane plane) {
  const outcome::ScanTarget target(surface);
  const std::vector<double> areas = outcome::vertex_areas(surface);
  const std::vector<bool> border = outcome::border_vertices(surface);
  std::vector<Point> points;
  Vec3 centre{};
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    if (counts[v] && !border[v]) {
      points.push_back({surface.points[v], areas[v]});
      centre += surface.points[v];
    }
  }
  if (points.size() < least_points) {
    return plane;
  }
  centre = (1.0 / static_cast<double>(points.size())) * centre;
  for (Point& point : points) {
    point.place = point.place - centre;
  }
  plane.offset_m -= dot(plane.normal, centre);
  for (int round = 0; round < rounds; ++round) {
    const double share = static_cast<double>(round) / (rounds - 1);
    improve(target, points, centre, std::lerp(first_reach_m, last_reach_m, share), plane);
  }
  plane.offset_m += dot(plane.normal, centre);
  return plane;
}

}  // namespace sanatrix::standing
