// Steps C and D: anatomy -> closed surface -> tetrahedra -> model with names and tissue.
#include "meshing/breast_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "meshing/anatomy.hpp"
#include "meshing/cell_tissue.hpp"
#include "meshing/deadline.hpp"
#include "meshing/domain_surface.hpp"
#include "meshing/improve.hpp"
#include "meshing/sizing.hpp"
#include "meshing/tetrahedra.hpp"

namespace sanatrix::meshing {
namespace {

/// A solver needs dihedral angles above 10 degrees; asking for a little more leaves room.
constexpr double least_dihedral_deg = 10.0;
constexpr double wanted_dihedral_deg = 12.0;
/// Skin faces may be this part of the far edge away from the skin: a third of a voxel of the label
/// grid for edges of 8 mm.
constexpr double surface_distance_part = 1.0 / 16.0;

void check(const LabelImage& labels, const Image3<float>& fibroglandular,
           const MeshOptions& options) {
  require(options.target_vertices >= 500 && options.target_vertices <= 2000000,
          "target vertices must be 500 to 2000000, not {}", options.target_vertices);
  require(options.near_edge_m >= 0.001 && options.near_edge_m <= options.far_edge_m &&
              options.far_edge_m <= 0.04,
          "edges must be 1 mm <= near ({:g} mm) <= far ({:g} mm) <= 40 mm",
          1e3 * options.near_edge_m, 1e3 * options.far_edge_m);
  require(labels.voxels.size() == fibroglandular.voxels.size(),
          "labels and fibroglandular fraction are on different grids");
}

/// Refines until the number of vertices fits, all edges scaled by a factor. Each try costs a few
/// seconds, so three must do.
void refine_to_target(Refinement& refinement, Sizing& sizing, int target, double factor,
                      const Deadline& deadline, const Context& ctx) {
  int calls = 0;
  const SizeField size = [&](const Vec3& p) {
    if (++calls % 4096 == 0) {
      deadline.check();
      ctx.detail(0.5, {});  // a chance to be stopped
    }
    return factor * sizing.edge_mm(p);
  };
  constexpr int tries = 3;
  for (int i = 0; i < tries; ++i) {
    sizing.aim_at(target);
    const int count = refinement.refine(size, surface_distance_part * sizing.far_mm());
    ctx.at((i + 1.0) / tries, fmt::format("{} vertices, far edge {:.1f} mm, near edge {:.1f} mm",
                                          count, sizing.far_mm(), sizing.near_mm()));
    sizing.learn(count);
    if (std::abs(count - target) < 0.1 * target) {
      return;
    }
  }
}

TetMesh to_model_mesh(const Tetrahedra& tetrahedra, const ClipBox& box) {
  TetMesh mesh;
  for (const Vec3& p : tetrahedra.points_mm) {
    mesh.points.push_back(1e-3 * p);
  }
  mesh.cells = tetrahedra.cells;
  mesh.region.assign(mesh.cells.size(), 0);
  mesh.region_names = {"breast"};
  mesh.boundary_names = boundary_names();
  const std::vector<ClipPlane> planes = clip_planes(box);
  for (const auto& face : tetrahedra.faces) {
    mesh.faces.push_back({face.vertex, static_cast<int>(face.patch)});
    // Rounding took the flat sides out of their planes; put them back exactly.
    for (const ClipPlane& plane : planes) {
      for (const int v : face.vertex) {
        double& x = mesh.points[static_cast<std::size_t>(v)][plane.axis];
        if (face.patch == plane.patch && std::abs(x - 1e-3 * plane.at_mm) < 1e-6) {
          x = 1e-3 * plane.at_mm;
        }
      }
    }
  }
  return mesh;
}

double least_dihedral(const TetMesh& mesh) {
  const std::vector<double> angles = min_dihedral_angles(mesh, mesh.points);
  return *std::min_element(angles.begin(), angles.end());
}

}  // namespace

BreastModel mesh_breasts(const LabelImage& labels, const Image3<float>& fibroglandular,
                         double midline_x_mm, const std::array<Vec3, 2>& nipple_mm,
                         const MeshOptions& options, const Context& ctx) {
  check(labels, fibroglandular, options);
  const Deadline deadline(options.time_limit_s);
  ctx.at(0.0, "skin and chest wall");
  const Anatomy anatomy =
      find_anatomy(labels,
                   {.midline_x_mm = midline_x_mm,
                    .nipple_mm = nipple_mm,
                    .slab_half_height_mm = 1e3 * options.slab_half_height_m,
                    .ball = options.standing ? standing_ball : RollingBall{},
                    .breast_reach_mm = options.standing ? standing_reach_mm : 1e3,
                    .least_saddle = options.standing ? standing_least_saddle : 0.0,
                    .above_mm = options.standing ? standing_above_mm : 25.0,
                    .wall_is_whole = options.standing},
                   ctx.part(0.0, 0.2));
  deadline.check();
  ctx.at(0.2, "clipped surface");
  const DomainSurface surface = extract_domain(anatomy, nipple_mm, deadline);

  BreastModel model;
  Sizing sizing(anatomy, options);
  Refinement refinement(surface);
  // Slightly different edges make another mesh, should flat cells or faces inside the body remain.
  const auto is_closed = [](const TetMesh& mesh) {
    return boundary_of(mesh).size() == mesh.faces.size();
  };
  for (const double factor : {1.0, 0.97, 1.03}) {
    refine_to_target(refinement, sizing, options.target_vertices, factor, deadline,
                     ctx.part(0.3, 0.5));
    ctx.at(0.5, "improving angles");
    refinement.improve_angles(wanted_dihedral_deg, 0.5 * deadline.left_s());
    deadline.check();
    Tetrahedra mesh = refinement.mesh();
    peel_flat_cells(mesh, wanted_dihedral_deg);
    move_vertices_of_flat_cells(mesh, surface, wanted_dihedral_deg, deadline);
    model.mesh = to_model_mesh(mesh, surface.box);
    if (least_dihedral(model.mesh) > least_dihedral_deg && is_closed(model.mesh)) {
      break;
    }
  }
  check_and_orient(model.mesh, "breast mesh");
  ensure(is_closed(model.mesh), "breast mesh: {} faces have names, {} are on the boundary",
         model.mesh.faces.size(), boundary_of(model.mesh).size());
  if (const double angle = least_dihedral(model.mesh); angle <= least_dihedral_deg) {
    model.warnings.push_back(fmt::format("smallest dihedral angle {:.1f} degrees", angle));
  }
  if (sizing.near_mm() > 1.001e3 * options.near_edge_m) {
    model.warnings.push_back(
        fmt::format("{} vertices are too few for edges of {:g} mm in the focus; they are {:.1f} mm",
                    options.target_vertices, 1e3 * options.near_edge_m, sizing.near_mm()));
  }
  ctx.at(0.9, "tissue of the cells");
  model.midline_x_m = 1e-3 * midline_x_mm;
  assign_tissue(model, fibroglandular, anatomy.breasts, nipple_mm);
  ctx.at(1.0,
         fmt::format("{} vertices, {} cells", model.mesh.points.size(), model.mesh.cells.size()));
  return model;
}

}  // namespace sanatrix::meshing
