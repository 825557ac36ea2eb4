// The structured mesh of the unloaded phantom, deliberately unlike what the pipeline's mesher
// makes.
#include "phantom/body_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3;
constexpr double usual_radius = 63.0 * mm;
constexpr int layers = 4;
constexpr std::array<std::array<std::size_t, 3>, 6> orders{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// Grid lines from low to high whose spacing follows `size`.
std::vector<double> lines(double low, double high, const std::function<double(double)>& size) {
  constexpr int fine = 4000;
  const double step = (high - low) / fine;
  std::vector<double> count{0.0};
  for (int i = 0; i < fine; ++i) {
    count.push_back(count.back() + step / size(low + (i + 0.5) * step));
  }
  const int n = std::max(4, static_cast<int>(std::lround(count.back())));
  std::vector<double> result{low};
  for (int i = 1, k = 0; i < n; ++i) {
    const double wanted = count.back() * i / n;
    while (count[static_cast<std::size_t>(k) + 1] < wanted) {
      ++k;
    }
    const double here = count[static_cast<std::size_t>(k)];
    const double next = count[static_cast<std::size_t>(k) + 1];
    result.push_back(low + step * (k + (wanted - here) / (next - here)));
  }
  result.push_back(high);
  return result;
}

/// Vertices by grid position; k is the layer, 0 on the chest wall.
struct Grid {
  int ns, nz;
  [[nodiscard]] int vertex(int i, int j, int k) const { return (i * nz + j) * (layers + 1) + k; }
  [[nodiscard]] std::array<int, 3> position(int v) const {
    const int column = v / (layers + 1);
    return {column / nz, column % nz, v % (layers + 1)};
  }
};

void name_boundaries(const Grid& grid, TetMesh& mesh) {
  mesh.boundary_names = {"skin", "chest", "superior", "inferior", "posterior"};
  for (const auto& face : boundary_of(mesh)) {
    std::array<std::array<int, 3>, 3> at{grid.position(face[0]), grid.position(face[1]),
                                         grid.position(face[2])};
    const auto all = [&at](std::size_t axis, int value) {
      return std::ranges::all_of(at, [&](const auto& p) { return p[axis] == value; });
    };
    int name = 4;
    if (all(2, layers)) {
      name = 0;
    } else if (all(2, 0)) {
      name = 1;
    } else if (all(1, grid.nz - 1)) {
      name = 2;
    } else if (all(1, 0)) {
      name = 3;
    }
    mesh.faces.push_back({face, name});
  }
}

int nearest_vertex(const BodyMesh& body, const ChestPlace& place) {
  int best = 0;
  double best2 = 1e9;
  for (std::size_t v = 0; v < body.places.size(); ++v) {
    const ChestPlace& q = body.places[v];
    const Vec3 d{q.s - place.s, q.z - place.z, q.t - place.t};
    if (dot(d, d) < best2) {
      best2 = dot(d, d);
      best = static_cast<int>(v);
    }
  }
  return best;
}

}  // namespace

BodyMesh mesh_body(const Anatomy& anatomy, double edge) {
  const auto size = [&](double distance_in_radii, double radius) {
    // Fine in the breasts, half as fine in the thin layer around them.
    const double w = std::clamp((distance_in_radii - 1.15) / 0.3, 0.0, 1.0);
    return edge * std::sqrt(radius / usual_radius) * (1.0 + 0.5 * w);
  };
  const double end = anatomy.thorax().half_arc();
  const auto along_s = lines(-end, end, [&](double s) {
    const Breast& b = anatomy.breast_at(s);
    return size(std::abs(s - b.s) / b.radius, b.radius);
  });
  const auto along_z = lines(anatomy.inferior(), anatomy.superior(), [&](double z) {
    const Breast& b = anatomy.breasts()[0];
    return size(std::abs(z - b.z) / b.radius, b.radius);
  });
  const Grid grid{static_cast<int>(along_s.size()), static_cast<int>(along_z.size())};

  BodyMesh body;
  TetMesh& mesh = body.mesh;
  mesh.region_names = {"breast"};
  for (const double s : along_s) {
    for (const double z : along_z) {
      const double h = anatomy.thickness(s, z);
      for (int k = 0; k <= layers; ++k) {
        body.places.push_back({s, z, h * k / layers});
        mesh.points.push_back(anatomy.thorax().point(body.places.back()));
      }
    }
  }
  for (int i = 0; i + 1 < grid.ns; ++i) {
    for (int j = 0; j + 1 < grid.nz; ++j) {
      for (int k = 0; k < layers; ++k) {
        for (const auto& order : orders) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> cell{grid.vertex(i, j, k), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[order[step]];
            cell[step + 1] = grid.vertex(at[0], at[1], at[2]);
          }
          mesh.cells.push_back(cell);
        }
      }
    }
  }
  mesh.region.assign(mesh.cells.size(), 0);
  check_and_orient(mesh, "phantom");
  name_boundaries(grid, mesh);
  for (const Breast& b : anatomy.breasts()) {
    mesh.named_points[b.side > 0.0 ? "nipple_L" : "nipple_R"] =
        nearest_vertex(body, {b.s, b.z, anatomy.thickness(b.s, b.z)});
  }
  return body;
}

std::vector<Vec3> curved_nodes(const BodyMesh& body, const Anatomy& anatomy,
                               std::span<const std::array<int, 2>> edges) {
  std::vector<Vec3> nodes = body.mesh.points;
  for (const auto& [a, b] : edges) {
    const ChestPlace& p = body.places[static_cast<std::size_t>(a)];
    const ChestPlace& q = body.places[static_cast<std::size_t>(b)];
    const double s = 0.5 * (p.s + q.s), z = 0.5 * (p.z + q.z);
    const double layer =
        0.5 * (p.t / anatomy.thickness(p.s, p.z) + q.t / anatomy.thickness(q.s, q.z));
    nodes.push_back(anatomy.thorax().point({s, z, layer * anatomy.thickness(s, z)}));
  }
  return nodes;
}

Lattice::Lattice(int n) {
  std::map<std::array<int, 3>, int> number;
  for (int a = 0; a <= n; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int c = 0; c <= b; ++c) {
        number[{a, b, c}] = static_cast<int>(weights.size());
        weights.push_back({1.0 - static_cast<double>(a) / n, static_cast<double>(a - b) / n,
                           static_cast<double>(b - c) / n, static_cast<double>(c) / n});
      }
    }
  }
  for (const auto& [low, first] : number) {
    for (const auto& order : orders) {
      std::array<int, 3> at = low;
      std::array<int, 4> corners{first, 0, 0, 0};
      bool inside = true;
      for (std::size_t step = 0; step < 3 && inside; ++step) {
        ++at[order[step]];
        const auto found = number.find(at);
        inside = found != number.end();
        corners[step + 1] = inside ? found->second : 0;
      }
      if (inside) {
        tetrahedra.push_back(corners);
      }
    }
  }
}

std::vector<double> gland_fractions(const BodyMesh& body, const Anatomy& anatomy,
                                    const TissueMap& tissue) {
  const Lattice lattice(4);
  std::vector<double> fractions;
  for (const auto& cell : body.mesh.cells) {
    double gland = 0.0;
    for (const auto& small : lattice.tetrahedra) {
      ChestPlace middle{};
      for (const int corner : small) {
        for (std::size_t v = 0; v < 4; ++v) {
          const ChestPlace& p = body.places[static_cast<std::size_t>(cell[v])];
          const double w = 0.25 * lattice.weights[static_cast<std::size_t>(corner)][v];
          middle = {middle.s + w * p.s, middle.z + w * p.z, middle.t + w * p.t};
        }
      }
      const Label label = tissue.at(middle, anatomy.depth(middle));
      gland += label == Label::Fibroglandular || label == Label::Tumour ? 1.0 : 0.0;
    }
    fractions.push_back(gland / static_cast<double>(lattice.tetrahedra.size()));
  }
  return fractions;
}

}  // namespace sanatrix::phantom
