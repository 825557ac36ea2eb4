// Delaunay refinement of the clipped domain with CGAL Mesh_3; edges between patches stay sharp.
#include "meshing/tetrahedra.hpp"

#include <set>
#include <unordered_map>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/properties_Surface_mesh_features.h>
#include <CGAL/make_mesh_3.h>
#include <boost/property_map/function_property_map.hpp>

#include "core/error.hpp"
#include "meshing/patch_curves.hpp"

namespace sanatrix::meshing {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, SurfaceMesh>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

/// CGAL's patch number 0 means "inside", so ours start at 1.
int patch_id(Patch patch) {
  return static_cast<int>(patch) + 1;
}

SurfaceMesh to_cgal(const DomainSurface& surface) {
  SurfaceMesh mesh;
  for (const Vec3& p : surface.points_mm) {
    mesh.add_vertex(Point(p[0], p[1], p[2]));
  }
  auto id = get(CGAL::face_patch_id_t<int>(), mesh);
  using Vertex = SurfaceMesh::Vertex_index;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto vertex = [&](std::size_t i) {
      return Vertex(static_cast<Vertex::size_type>(surface.triangles[t][i]));
    };
    const auto face = mesh.add_face(vertex(0), vertex(1), vertex(2));
    put(id, face, patch_id(surface.patch[t]));
  }
  return mesh;
}

/// A size field for CGAL: `factor` turns an edge length into the radius that CGAL bounds.
struct Radius {
  using FT = Kernel::FT;
  using Point_3 = Triangulation::Geom_traits::Point_3;
  const SizeField* edge_mm;
  double factor;
  template <class P, class Index>
  FT operator()(const P& p, int, const Index&) const {
    return factor * (*edge_mm)({p.x(), p.y(), p.z()});
  }
};

Tetrahedra to_arrays(const Complex& complex) {
  Tetrahedra result;
  const Triangulation& tri = complex.triangulation();
  std::unordered_map<Triangulation::Vertex_handle, int> number;
  const auto vertex = [&](Triangulation::Vertex_handle v) {
    const auto [entry, fresh] = number.try_emplace(v, static_cast<int>(number.size()));
    if (fresh) {
      const auto& p = tri.point(v);
      result.points_mm.push_back(
          {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())});
    }
    return entry->second;
  };
  for (auto c = complex.cells_in_complex_begin(); c != complex.cells_in_complex_end(); ++c) {
    result.cells.push_back(
        {vertex(c->vertex(0)), vertex(c->vertex(1)), vertex(c->vertex(2)), vertex(c->vertex(3))});
  }
  for (auto f = complex.facets_in_complex_begin(); f != complex.facets_in_complex_end(); ++f) {
    auto [cell, opposite] = *f;
    if (!complex.is_in_complex(cell)) {
      std::tie(cell, opposite) = tri.mirror_facet(*f);
      if (!complex.is_in_complex(cell)) {
        continue;  // a face that bounds nothing
      }
    }
    // Seen from inside, the vertices after the opposite one turn one way for even positions.
    std::array<int, 3> corner{vertex(cell->vertex((opposite + 1) % 4)),
                              vertex(cell->vertex((opposite + 2) % 4)),
                              vertex(cell->vertex((opposite + 3) % 4))};
    if (opposite % 2 == 0) {
      std::swap(corner[1], corner[2]);
    }
    result.faces.push_back({corner, static_cast<Patch>(complex.surface_patch_index(*f) - 1)});
  }
  return result;
}

}  // namespace

struct Refinement::Impl {
  explicit Impl(const DomainSurface& surface) : polyhedron(to_cgal(surface)), domain(polyhedron) {
    const std::vector<PatchCurve> curves = find_curves(surface);
    domain.add_features_and_incidences(
        curves.begin(), curves.end(),
        boost::make_function_property_map<PatchCurve>([&](const PatchCurve& c) {
          std::vector<Point> points;
          for (const int v : c.vertices) {
            const Vec3& p = surface.points_mm[static_cast<std::size_t>(v)];
            points.emplace_back(p[0], p[1], p[2]);
          }
          return points;
        }),
        boost::make_function_property_map<PatchCurve>([](const PatchCurve& c) {
          std::set<int> ids;
          for (const Patch patch : c.patches) {
            ids.insert(patch_id(patch));
          }
          return ids;
        }));
  }
  SurfaceMesh polyhedron;
  Domain domain;
  Complex complex;
};

Refinement::Refinement(const DomainSurface& surface) : impl_(std::make_unique<Impl>(surface)) {}
Refinement::~Refinement() = default;

int Refinement::refine(const SizeField& edge_mm, double surface_distance_mm) {
  namespace p = CGAL::parameters;
  // The factors make the mean edge about as long as asked for: CGAL bounds circumradii.
  const Criteria criteria(p::edge_size = Radius{&edge_mm, 0.95}, p::facet_angle = 25.0,
                          p::facet_size = Radius{&edge_mm, 0.68},
                          p::facet_distance = surface_distance_mm, p::cell_radius_edge_ratio = 2.0,
                          p::cell_size = Radius{&edge_mm, 0.72});
  impl_->complex =
      CGAL::make_mesh_3<Complex>(impl_->domain, criteria, p::no_perturb(), p::no_exude());
  ensure(impl_->complex.number_of_cells_in_complex() > 0, "Delaunay refinement gave no cells");
  return static_cast<int>(impl_->complex.triangulation().number_of_vertices());
}

void Refinement::improve_angles(double bound_deg, double seconds) {
  namespace p = CGAL::parameters;
  CGAL::perturb_mesh_3(impl_->complex, impl_->domain, p::time_limit = seconds,
                       p::sliver_bound = bound_deg);
  CGAL::exude_mesh_3(impl_->complex, p::time_limit = seconds, p::sliver_bound = bound_deg);
}

Tetrahedra Refinement::mesh() const {
  return to_arrays(impl_->complex);
}

}  // namespace sanatrix::meshing
