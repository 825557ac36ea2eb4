// P2 cells are cut into small linear tetrahedra, which carry places of the unloaded body to voxels.
#include "phantom/voxelise.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/distance.hpp"

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3;
constexpr double skin_thickness = 2.0 * mm;
constexpr double muscle = 8.0 * mm, rib = 9.0 * mm;  // of the sheets behind the fascia
constexpr double rib_pitch = 25.0 * mm, rib_height = 11.0 * mm, sternum = 17.0 * mm;

/// The box of a scan: all of the breasts with some air, cut where the body is cut.
LabelImage empty_scan(const BodyMesh& body, const Thorax& thorax, std::span<const Vec3> nodes,
                      double voxel_mm) {
  constexpr double air = 12.0, inside = 4.0;  // [mm]
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (std::size_t v = 0; v < nodes.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], nodes[v][i] / mm);
      high[i] = std::max(high[i], nodes[v][i] / mm);
    }
  }
  // The body ends where the chest wall is deepest; there its cut surface moves a little.
  const int cut = boundary_index(body.mesh, "posterior");
  double back = 1e9;
  for (const BoundaryFace& face : body.mesh.faces) {
    for (const int v : face.vertex) {
      if (face.name == cut) {
        back = std::min(back, nodes[static_cast<std::size_t>(v)][1] / mm);
      }
    }
  }
  const double side = thorax.point({thorax.half_arc(), 0.0, 0.0})[0] / mm;
  low = {std::min(low[0], -side) - air, low[1] - air, low[2] + 0.5 * voxel_mm};
  high = {std::max(high[0], side) + air, back - inside, high[2] - 0.5 * voxel_mm};
  LabelImage image;
  image.spacing_mm = {voxel_mm, voxel_mm, voxel_mm};
  image.origin_mm = low;
  std::size_t count = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    image.size[i] = static_cast<int>(std::floor((high[i] - low[i]) / voxel_mm)) + 1;
    count *= static_cast<std::size_t>(image.size[i]);
  }
  image.voxels.assign(count, 0);
  return image;
}

/// Voxels whose centre lies in the tetrahedron, with barycentric coordinates.
template <class Visit>
void for_voxels_in(const LabelImage& image, const std::array<Vec3, 4>& x, Visit&& visit) {
  const Mat3 to_corners = transpose({x[1] - x[0], x[2] - x[0], x[3] - x[0]});
  if (determinant(to_corners) == 0.0) {
    return;
  }
  const Mat3 to_weights = inverse(to_corners);
  std::array<int, 3> from{}, to{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax({x[0][i], x[1][i], x[2][i], x[3][i]});
    from[i] = std::max(
        0,
        static_cast<int>(std::ceil((low / mm - image.origin_mm[i]) / image.spacing_mm[i] - 1e-6)));
    to[i] = std::min(image.size[i] - 1,
                     static_cast<int>(std::floor(
                         (high / mm - image.origin_mm[i]) / image.spacing_mm[i] + 1e-6)));
  }
  constexpr double on_face = -1e-6;
  for (int k = from[2]; k <= to[2]; ++k) {
    for (int j = from[1]; j <= to[1]; ++j) {
      for (int i = from[0]; i <= to[0]; ++i) {
        const Vec3 p = mm * image.position_mm(i, j, k);
        const Vec3 w = to_weights * (p - x[0]);
        const double w0 = 1.0 - w[0] - w[1] - w[2];
        if (std::min({w0, w[0], w[1], w[2]}) >= on_face) {
          visit(image.index(i, j, k), p, std::array{w0, w[0], w[1], w[2]});
        }
      }
    }
  }
}

Label behind_the_fascia(const ChestPlace& place) {
  const double deep = -place.t;
  const double between = place.z / rib_pitch - std::floor(place.z / rib_pitch);
  const bool bone = std::abs(place.s) < sternum || between * rib_pitch < rib_height;
  if (deep < muscle) {
    return Label::Muscle;
  }
  if (deep < muscle + rib) {
    return bone ? Label::Bone : Label::Muscle;
  }
  return Label::Lung;
}

void fill_thorax(const Thorax& thorax, LabelImage& image) {
  // Chords between mesh vertices leave slivers of up to this width before the curved fascia.
  constexpr double sliver = 0.5 * mm;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        unsigned char& voxel = image.at(i, j, k);
        if (voxel == 0) {
          const ChestPlace place = thorax.locate(mm * image.position_mm(i, j, k));
          if (place.t < sliver && std::abs(place.s) < thorax.half_arc()) {
            voxel = static_cast<unsigned char>(behind_the_fascia(place));
          }
        }
      }
    }
  }
}

}  // namespace

LabelImage voxelise(const BodyMesh& body, const Anatomy& anatomy, const TissueMap& tissue,
                    const QuadraticCells& cells, std::span<const Vec3> unloaded,
                    std::span<const Vec3> nodes, double voxel_mm, const Context& ctx) {
  const SurfaceTree skin(cells.boundary("skin", nodes));
  LabelImage image = empty_scan(body, anatomy.thorax(), nodes, voxel_mm);
  // Skin that is stretched is thinner than it was: beyond this unloaded depth no search is needed.
  constexpr double may_be_skin = 4.0 * skin_thickness;
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c) {
    if (c % 500 == 0) {
      ctx.at(static_cast<double>(c) / static_cast<double>(body.mesh.cells.size()),
             "filling voxels");
    }
    const std::vector<Vec3> points = cells.lattice_points(c, nodes);
    std::vector<ChestPlace> places;
    for (const Vec3& p : cells.lattice_points(c, unloaded)) {
      places.push_back(anatomy.thorax().locate(p));
    }
    for (const auto& small : cells.lattice().tetrahedra) {
      std::array<Vec3, 4> x{};
      std::array<ChestPlace, 4> at{};
      for (std::size_t i = 0; i < 4; ++i) {
        x[i] = points[static_cast<std::size_t>(small[i])];
        at[i] = places[static_cast<std::size_t>(small[i])];
      }
      const auto visit = [&](std::size_t voxel, const Vec3& p, const std::array<double, 4>& w) {
        ChestPlace place{};
        for (std::size_t i = 0; i < 4; ++i) {
          place = {place.s + w[i] * at[i].s, place.z + w[i] * at[i].z, place.t + w[i] * at[i].t};
        }
        const double depth = anatomy.depth(place);
        const bool at_surface = depth < may_be_skin && skin.closest(p).distance < skin_thickness;
        const Label label =
            at_surface && !tissue.is_nipple(place, depth) ? Label::Skin : tissue.at(place, depth);
        image.voxels[voxel] = static_cast<unsigned char>(label);
      };
      for_voxels_in(image, x, visit);
    }
  }
  fill_thorax(anatomy.thorax(), image);
  return image;
}

}  // namespace sanatrix::phantom
