// P2 cells are cut into small linear tetrahedra, which carry places of the unloaded body to voxels.
#include "phantom/voxelise.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "geometry/distance.hpp"

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3;
constexpr double skin_thickness = 2.0 * mm;
constexpr double muscle = 8.0 * mm, rib = 9.0 * mm;  // of the sheets behind the fascia
constexpr double rib_pitch = 25.0 * mm, rib_height = 11.0 * mm, sternum = 17.0 * mm;
constexpr int parts = 3;  // of a cell's edge: chords of a curved edge then err by less than 0.1 mm

/// A point of the deformed body with its place in the unloaded one.
struct Node {
  Vec3 x;
  ChestPlace place;
};

class CellNodes {
 public:
  CellNodes(const BodyMesh& body, const Thorax& thorax, std::span<const Vec3> nodes,
            std::span<const std::array<int, 2>> edges)
      : body_(body), thorax_(thorax), nodes_(nodes), lattice_(parts) {
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [a, b] = std::minmax(edges[e][0], edges[e][1]);
      edge_node_[{a, b}] = body.mesh.points.size() + e;
    }
  }
  [[nodiscard]] const Lattice& lattice() const { return lattice_; }

  /// Lattice points of a cell: deformed by the P2 basis, placed by the straight unloaded cell.
  [[nodiscard]] std::vector<Node> of(const std::array<int, 4>& cell) const {
    std::vector<Node> result;
    for (const auto& w : lattice_.weights) {
      Vec3 deformed{}, unloaded{};
      for (std::size_t i = 0; i < 4; ++i) {
        deformed += w[i] * (2.0 * w[i] - 1.0) * nodes_[static_cast<std::size_t>(cell[i])];
        unloaded += w[i] * body_.mesh.points[static_cast<std::size_t>(cell[i])];
        for (std::size_t j = 0; j < i; ++j) {
          deformed += 4.0 * w[i] * w[j] * nodes_[middle(cell[i], cell[j])];
        }
      }
      result.push_back({deformed, thorax_.locate(unloaded)});
    }
    return result;
  }

  /// The deformed skin, as finely divided as the cells.
  [[nodiscard]] TriMesh skin() const {
    TriMesh surface;
    const int name = boundary_index(body_.mesh, "skin");
    for (const BoundaryFace& face : body_.mesh.faces) {
      if (face.name == name) {
        add_face(face.vertex, surface);
      }
    }
    return surface;
  }

 private:
  [[nodiscard]] std::size_t middle(int a, int b) const {
    return edge_node_.at({std::min(a, b), std::max(a, b)});
  }

  void add_face(const std::array<int, 3>& face, TriMesh& surface) const {
    std::map<std::array<int, 2>, int> number;
    for (int a = 0; a <= parts; ++a) {
      for (int b = 0; b + a <= parts; ++b) {
        const std::array<double, 3> w{1.0 - static_cast<double>(a + b) / parts,
                                      static_cast<double>(a) / parts,
                                      static_cast<double>(b) / parts};
        Vec3 x{};
        for (std::size_t i = 0; i < 3; ++i) {
          x += w[i] * (2.0 * w[i] - 1.0) * nodes_[static_cast<std::size_t>(face[i])];
          x += 4.0 * w[i] * w[(i + 1) % 3] * nodes_[middle(face[i], face[(i + 1) % 3])];
        }
        number[{a, b}] = static_cast<int>(surface.points.size());
        surface.points.push_back(x);
      }
    }
    for (const auto& [at, first] : number) {
      const auto [a, b] = at;
      if (a + b < parts) {
        surface.triangles.push_back({first, number[{a + 1, b}], number[{a, b + 1}]});
      }
      if (a + b + 1 < parts) {
        surface.triangles.push_back(
            {number[{a + 1, b}], number[{a + 1, b + 1}], number[{a, b + 1}]});
      }
    }
  }

  const BodyMesh& body_;
  const Thorax& thorax_;
  std::span<const Vec3> nodes_;
  std::map<std::array<int, 2>, std::size_t> edge_node_;
  Lattice lattice_;
};

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
                    std::span<const Vec3> nodes, std::span<const std::array<int, 2>> edges,
                    double voxel_mm, const Context& ctx) {
  const CellNodes cell_nodes(body, anatomy.thorax(), nodes, edges);
  const SurfaceTree skin(cell_nodes.skin());
  LabelImage image = empty_scan(body, anatomy.thorax(), nodes, voxel_mm);
  // Skin that is stretched is thinner than it was: beyond this unloaded depth no search is needed.
  constexpr double may_be_skin = 4.0 * skin_thickness;
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c) {
    if (c % 500 == 0) {
      ctx.at(static_cast<double>(c) / static_cast<double>(body.mesh.cells.size()),
             "filling voxels");
    }
    const auto points = cell_nodes.of(body.mesh.cells[c]);
    for (const auto& small : cell_nodes.lattice().tetrahedra) {
      std::array<Node, 4> at{};
      for (std::size_t i = 0; i < 4; ++i) {
        at[i] = points[static_cast<std::size_t>(small[i])];
      }
      const auto visit = [&](std::size_t voxel, const Vec3& p, const std::array<double, 4>& w) {
        ChestPlace place{};
        for (std::size_t i = 0; i < 4; ++i) {
          place = {place.s + w[i] * at[i].place.s, place.z + w[i] * at[i].place.z,
                   place.t + w[i] * at[i].place.t};
        }
        const double depth = anatomy.depth(place);
        const bool at_surface = depth < may_be_skin && skin.closest(p).distance < skin_thickness;
        const Label label =
            at_surface && !tissue.is_nipple(place, depth) ? Label::Skin : tissue.at(place, depth);
        image.voxels[voxel] = static_cast<unsigned char>(label);
      };
      for_voxels_in(image, {at[0].x, at[1].x, at[2].x, at[3].x}, visit);
    }
  }
  fill_thorax(anatomy.thorax(), image);
  return image;
}

}  // namespace sanatrix::phantom
