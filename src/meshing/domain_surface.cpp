// Iso-surface of skin and chest wall (VTK) clipped by planes into a closed surface (CGAL).
#include "meshing/domain_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/clip.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Surface_mesh.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include "core/error.hpp"
#include "meshing/patch_curves.hpp"

namespace sanatrix::meshing {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

/// Finer than the label grid would only resolve its stairs, coarser loses nipples [mm].
constexpr double iso_spacing_mm = 2.4;

double outside_tissue(const Anatomy& anatomy, const Vec3& p) {
  return std::max(sample(anatomy.outside_skin, p), sample(anatomy.behind_chest, p));
}

/// The planes of the box may move outwards by this much.
constexpr double room_mm = 8.0;

/// The domain's function on a grid a little larger than the clip box, positive on its border so
/// that the iso-surface is closed.
vtkNew<vtkImageData> sample_domain(const Anatomy& anatomy) {
  const Image3<float>& field = anatomy.outside_skin;
  const Vec3 first = field.origin_mm;
  const Vec3 last = field.position_mm(field.size[0] - 1, field.size[1] - 1, field.size[2] - 1);
  Vec3 low{};
  std::array<int, 3> size{};
  for (std::size_t a = 0; a < 3; ++a) {
    // Two extra layers: the planes then cut whole cells of the surface.
    low[a] = std::max(anatomy.box.low_mm[a] - room_mm, first[a]) - 2.3 * iso_spacing_mm;
    const double high = std::min(anatomy.box.high_mm[a] + room_mm, last[a]) + 2.3 * iso_spacing_mm;
    size[a] = static_cast<int>(std::ceil((high - low[a]) / iso_spacing_mm)) + 1;
  }
  vtkNew<vtkFloatArray> values;
  values->SetNumberOfTuples(static_cast<vtkIdType>(size[0]) * size[1] * size[2]);
  vtkIdType n = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++n) {
        const bool border =
            i == 0 || j == 0 || k == 0 || i == size[0] - 1 || j == size[1] - 1 || k == size[2] - 1;
        const Vec3 p = low + iso_spacing_mm * Vec3{static_cast<double>(i), static_cast<double>(j),
                                                   static_cast<double>(k)};
        // An exact zero at a grid point would make a degenerate triangle.
        const auto v = static_cast<float>(outside_tissue(anatomy, p));
        values->SetValue(n, border ? 5.0F : std::abs(v) < 1e-3F ? 1e-3F : v);
      }
    }
  }
  vtkNew<vtkImageData> image;
  image->SetDimensions(size[0], size[1], size[2]);
  image->SetOrigin(low[0], low[1], low[2]);
  image->SetSpacing(iso_spacing_mm, iso_spacing_mm, iso_spacing_mm);
  image->GetPointData()->SetScalars(values);
  return image;
}

SurfaceMesh iso_surface(const Anatomy& anatomy) {
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(sample_domain(anatomy));
  contour->SetValue(0, 0.0);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData* poly = contour->GetOutput();
  SurfaceMesh surface;
  for (vtkIdType p = 0; p < poly->GetNumberOfPoints(); ++p) {
    const double* x = poly->GetPoint(p);
    surface.add_vertex(Kernel::Point_3(x[0], x[1], x[2]));
  }
  for (vtkIdType c = 0; c < poly->GetNumberOfCells(); ++c) {
    vtkIdType count = 0;
    const vtkIdType* id = nullptr;
    poly->GetCellPoints(c, count, id);
    using Vertex = SurfaceMesh::Vertex_index;
    const auto vertex = [&](int i) {
      return Vertex(static_cast<Vertex::size_type>(id[i]));
    };
    surface.add_face(vertex(0), vertex(1), vertex(2));
  }
  return surface;
}

/// Keeps the largest piece; both nipples must be on it.
void keep_one_piece(SurfaceMesh& surface, const std::array<Vec3, 2>& nipple_mm) {
  pmp::keep_largest_connected_components(surface, 1);
  surface.collect_garbage();
  for (std::size_t side = 0; side < 2; ++side) {
    const Vec3& n = nipple_mm[side];
    const auto close = [&](SurfaceMesh::Vertex_index v) {
      const auto& p = surface.point(v);
      return norm(Vec3{p.x(), p.y(), p.z()} - n) < 15.0;
    };
    const auto vertices = surface.vertices();
    if (std::none_of(vertices.begin(), vertices.end(), close)) {
      throw Error(Fault::Input,
                  fmt::format("the two breasts are not one connected body: the {} nipple at "
                              "{:.0f} {:.0f} {:.0f} mm is on another piece",
                              side == 0 ? "right" : "left", n[0], n[1], n[2]),
                  "check that the labels between the breasts (over the sternum) have no gap");
    }
  }
}

Patch patch_of(const Anatomy& anatomy, const std::vector<ClipPlane>& planes,
               const std::array<Vec3, 3>& p) {
  for (const ClipPlane& plane : planes) {
    const auto on_plane = [&](const Vec3& v) {
      return std::abs(v[plane.axis] - plane.at_mm) < 1e-6;
    };
    if (on_plane(p[0]) && on_plane(p[1]) && on_plane(p[2])) {
      return plane.patch;
    }
  }
  const Vec3 centre = (1.0 / 3.0) * (p[0] + p[1] + p[2]);
  return sample(anatomy.behind_chest, centre) > sample(anatomy.outside_skin, centre) ? Patch::Chest
                                                                                     : Patch::Skin;
}

/// A plane through grid points would pass exactly through vertices of the iso-surface (a skin
/// closed by hand is often flat there) and leave edges of micrometres: it is moved between them.
double between_grid_planes(double at_mm, double origin_mm, double spacing_mm, double inwards) {
  const double cells = (at_mm - origin_mm) / spacing_mm;
  return std::abs(cells - std::round(cells)) < 0.05 ? at_mm + 0.4 * inwards * spacing_mm : at_mm;
}

ClipBox shifted_box(const Anatomy& anatomy, const Vec3& inwards_mm) {
  const Image3<float>& image = anatomy.outside_skin;
  const Vec3 first = image.origin_mm;
  const Vec3 last = image.position_mm(image.size[0] - 1, image.size[1] - 1, image.size[2] - 1);
  ClipBox box = anatomy.box;
  for (const std::size_t a : {0, 1, 2}) {
    // Moving outwards ends two voxels before the border of the image.
    const double border = 2.0 * image.spacing_mm[a];
    const double by = inwards_mm[a];
    if (a != 1) {
      box.low_mm[a] =
          by > 0.0 ? box.low_mm[a] + by
                   : std::min(box.low_mm[a], std::max(box.low_mm[a] + by, first[a] + border));
    }
    box.high_mm[a] =
        by > 0.0 ? box.high_mm[a] - by
                 : std::max(box.high_mm[a], std::min(box.high_mm[a] - by, last[a] - border));
    box.low_mm[a] = between_grid_planes(box.low_mm[a], first[a], image.spacing_mm[a], 1);
    box.high_mm[a] = between_grid_planes(box.high_mm[a], first[a], image.spacing_mm[a], -1);
  }
  return box;
}

/// CGAL numbers the new points of a cut by their addresses; put everything in an order that depends
/// on positions only, so that the same labels always give the same mesh.
void sort_by_position(DomainSurface& domain) {
  std::vector<int> order(domain.points_mm.size());
  std::iota(order.begin(), order.end(), 0);
  const auto point = [&](int v) {
    return domain.points_mm[static_cast<std::size_t>(v)];
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return point(a) < point(b); });
  std::vector<int> rank(order.size());
  std::vector<Vec3> sorted;
  for (std::size_t r = 0; r < order.size(); ++r) {
    rank[static_cast<std::size_t>(order[r])] = static_cast<int>(r);
    sorted.push_back(point(order[r]));
  }
  domain.points_mm = std::move(sorted);
  std::vector<std::pair<std::array<int, 3>, Patch>> faces;
  for (std::size_t t = 0; t < domain.triangles.size(); ++t) {
    auto v = domain.triangles[t];
    for (int& corner : v) {
      corner = rank[static_cast<std::size_t>(corner)];
    }
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    faces.emplace_back(v, domain.patch[t]);
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t t = 0; t < faces.size(); ++t) {
    std::tie(domain.triangles[t], domain.patch[t]) = faces[t];
  }
}

/// The part of a closed surface inside the box, closed by the box's planes.
DomainSurface clip(SurfaceMesh surface, const Anatomy& anatomy, const ClipBox& box,
                   const std::array<Vec3, 2>& nipple_mm, const Deadline& deadline) {
  const std::vector<ClipPlane> planes = clip_planes(box);
  for (const ClipPlane& plane : planes) {
    std::array<double, 3> normal{};
    normal[plane.axis] = plane.outwards;
    const Kernel::Plane_3 cut(normal[0], normal[1], normal[2], -plane.outwards * plane.at_mm);
    deadline.check();
    pmp::clip(surface, cut, CGAL::parameters::clip_volume(true));
  }
  keep_one_piece(surface, nipple_mm);

  DomainSurface domain{.points_mm = {}, .triangles = {}, .patch = {}, .box = box};
  for (const auto v : surface.vertices()) {
    const auto& p = surface.point(v);
    Vec3 x{p.x(), p.y(), p.z()};
    for (const ClipPlane& plane : planes) {
      if (std::abs(x[plane.axis] - plane.at_mm) < 1e-6) {
        x[plane.axis] = plane.at_mm;
      }
    }
    domain.points_mm.push_back(x);
  }
  for (const auto f : surface.faces()) {
    std::array<int, 3> corner{};
    std::array<Vec3, 3> p{};
    std::size_t i = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f))) {
      corner[i] = static_cast<int>(v);
      p[i++] = domain.points_mm[static_cast<std::size_t>(v)];
    }
    domain.triangles.push_back(corner);
    domain.patch.push_back(patch_of(anatomy, planes, p));
  }
  sort_by_position(domain);
  return domain;
}

}  // namespace

const std::vector<std::string>& boundary_names() {
  static const std::vector<std::string> names{"skin",     "chest",   "superior",
                                              "inferior", "lateral", "posterior"};
  return names;
}

std::vector<ClipPlane> clip_planes(const ClipBox& box) {
  return {{Patch::Lateral, 0, box.low_mm[0], -1},
          {Patch::Lateral, 0, box.high_mm[0], 1},
          {Patch::Posterior, 1, box.high_mm[1], 1},
          {Patch::Inferior, 2, box.low_mm[2], -1},
          {Patch::Superior, 2, box.high_mm[2], 1}};
}

DomainSurface extract_domain(const Anatomy& anatomy, const std::array<Vec3, 2>& nipple_mm,
                             const Deadline& deadline) {
  SurfaceMesh whole = iso_surface(anatomy);
  ensure(CGAL::is_closed(whole) && !whole.is_empty(), "the iso-surface is not closed");
  if (!pmp::is_outward_oriented(whole)) {
    pmp::reverse_face_orientations(whole);
  }
  // Shifts [mm] of the lateral, posterior and horizontal planes, inwards, tried in turn.
  constexpr std::array<Vec3, 7> shifts{
      {{0, 0, 0}, {0, 4, 0}, {4, 0, 0}, {0, -4, 0}, {4, 8, 0}, {-8, 4, 4}, {8, 8, 4}}};
  // Narrower strips would need edges that are much finer than any part of interest.
  constexpr double enough_mm = 1.6;
  DomainSurface best;
  double best_clearance = -1.0;
  for (const Vec3& shift : shifts) {
    DomainSurface domain = clip(whole, anatomy, shifted_box(anatomy, shift), nipple_mm, deadline);
    const double clearance = clearance_mm(domain, find_curves(domain), deadline);
    if (clearance > best_clearance) {
      best = std::move(domain);
      best_clearance = clearance;
    }
    if (best_clearance > enough_mm) {
      break;
    }
  }
  return best;
}

}  // namespace sanatrix::meshing
