#include "pipeline/wound_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/distance.hpp"

namespace sanatrix::pipeline {
namespace {

constexpr int around = 32, along = 16;

/// Rows of `around` points, closed around, joined to a tube.
TriMesh tube(const std::vector<Vec3>& points) {
  TriMesh mesh{points, {}};
  for (int row = 0; row + 1 < static_cast<int>(points.size()) / around; ++row) {
    for (int i = 0; i < around; ++i) {
      const int a = row * around + i, b = row * around + (i + 1) % around;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
  }
  return mesh;
}

double angle_of(int i) {
  return 2 * std::numbers::pi * i / around;
}

TriMesh ball(const Vec3& centre, double radius) {
  std::vector<Vec3> points;
  for (int row = 0; row <= along; ++row) {
    const double polar = std::numbers::pi * row / along;
    for (int i = 0; i < around; ++i) {
      const double r = radius * std::sin(polar);
      points.push_back(centre + Vec3{r * std::cos(angle_of(i)), r * std::sin(angle_of(i)),
                                     radius * std::cos(polar)});
    }
  }
  return tube(points);
}

TriMesh cylinder(const Vec3& from, const Vec3& to, double radius) {
  const Vec3 axis = normalised(to - from);
  const Vec3 other = std::abs(axis[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 e1 = normalised(cross(axis, other)), e2 = cross(axis, e1);
  std::vector<Vec3> points;
  constexpr int rings = 5;  // few lines, so that what is inside stays visible
  for (int row = 0; row <= rings; ++row) {
    const Vec3 centre = from + (static_cast<double>(row) / rings) * (to - from);
    for (int i = 0; i < around; ++i) {
      points.push_back(centre + radius * std::cos(angle_of(i)) * e1 +
                       radius * std::sin(angle_of(i)) * e2);
    }
  }
  return tube(points);
}

}  // namespace

Vec3 wound_centre(const CaseResult& r, std::span<const Vec3> pose) {
  const std::vector<double> volume = cell_volumes(r.model.mesh, pose);
  Vec3 centre{};
  double total = 0.0;
  for (std::size_t c = 0; c < volume.size(); ++c) {
    const double weight = volume[c] * r.wound.fraction[c];
    for (const int vertex : r.model.mesh.cells[c]) {
      centre += 0.25 * weight * pose[static_cast<std::size_t>(vertex)];
    }
    total += weight;
  }
  return (1.0 / total) * centre;
}

TetMesh cells_near_wound(const CaseResult& r, double half_edge_m) {
  constexpr double beyond_m = 0.01;  // healing moves the tissue by less
  const std::span<const Vec3> pose = r.points(r.supine);
  const Vec3 centre = wound_centre(r, pose);
  TetMesh part = r.model.mesh;
  part.cells.clear();
  part.region.clear();
  for (std::size_t c = 0; c < r.model.mesh.cells.size(); ++c) {
    const auto& cell = r.model.mesh.cells[c];
    const bool near = std::ranges::any_of(cell, [&](int vertex) {
      const Vec3 d = pose[static_cast<std::size_t>(vertex)] - centre;
      return std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) < half_edge_m + beyond_m;
    });
    if (near) {
      part.cells.push_back(cell);
      part.region.push_back(r.model.mesh.region[c]);
    }
  }
  return part;
}

PlanShapes plan_shapes(const CaseResult& r) {
  const bool supine_plan = r.plan.frame == surgery::Frame::Supine;
  const std::span<const Vec3> supine = r.points(r.supine);
  const std::span<const Vec3> drawn =
      supine_plan ? supine : std::span<const Vec3>(r.model.mesh.points);
  const surgery::Resection resection(r.plan, r.model.mesh, drawn, r.model.midline_x_m,
                                     surgery::Detail::Live);
  PlanShapes shapes{ball(r.plan.tumour_centre, r.plan.tumour_radius),
                    cylinder(resection.chest_point(), resection.skin_point(), resection.radius()),
                    {{supine.begin(), supine.end()}, {}}};
  const TetLocator body(r.model.mesh, drawn);
  for (TriMesh* surface : {&shapes.tumour, &shapes.planned}) {
    for (Vec3& p : surface->points) {
      const TetLocator::Place place = body.nearest(p);
      const auto& cell = r.model.mesh.cells[static_cast<std::size_t>(place.cell)];
      p = {};
      for (std::size_t k = 0; k < 4; ++k) {
        p += place.barycentric[k] * supine[static_cast<std::size_t>(cell[k])];
      }
    }
  }
  TetMesh removed = r.model.mesh;
  removed.cells.clear();
  for (std::size_t c = 0; c < r.model.mesh.cells.size(); ++c) {
    if (r.wound.fraction[c] >= 0.5) {
      removed.cells.push_back(r.model.mesh.cells[c]);
    }
  }
  shapes.resected.triangles = boundary_of(removed);
  return shapes;
}

}  // namespace sanatrix::pipeline
