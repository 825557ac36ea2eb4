#include "geometry/structured_mesh.hpp"

#include <algorithm>
#include <numbers>

#include "core/error.hpp"

namespace sanatrix {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Names every boundary face for which all vertices fulfil `on`, in the order of `names`.
void name_boundaries(TetMesh& mesh, std::vector<std::string> names,
                     const std::function<bool(std::size_t name, const Vec3& p)>& on) {
  mesh.boundary_names = std::move(names);
  for (const auto& face : boundary_of(mesh)) {
    for (std::size_t name = 0; name < mesh.boundary_names.size(); ++name) {
      if (std::ranges::all_of(face, [&](int v) { return on(name, mesh.points[index(v)]); })) {
        mesh.faces.push_back({face, static_cast<int>(name)});
        break;
      }
    }
  }
}

/// Keeps the order of the others.
void drop_unused_points(TetMesh& mesh) {
  std::vector<bool> used(mesh.points.size(), false);
  for (const auto& cell : mesh.cells) {
    for (const int v : cell) {
      used[index(v)] = true;
    }
  }
  std::vector<int> renumbered(mesh.points.size(), -1);
  std::vector<Vec3> kept;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v]) {
      renumbered[v] = static_cast<int>(kept.size());
      kept.push_back(mesh.points[v]);
    }
  }
  for (auto& cell : mesh.cells) {
    for (int& v : cell) {
      v = renumbered[index(v)];
    }
  }
  mesh.points = std::move(kept);
}

TetMesh boxes(std::array<int, 3> n, const std::function<Vec3(int, int, int)>& place,
              const std::function<bool(int, int, int)>& keep) {
  TetMesh mesh;
  const auto vertex = [&](const std::array<int, 3>& p) {
    return (p[2] * (n[1] + 1) + p[1]) * (n[0] + 1) + p[0];
  };
  for (int k = 0; k <= n[2]; ++k) {
    for (int j = 0; j <= n[1]; ++j) {
      for (int i = 0; i <= n[0]; ++i) {
        mesh.points.push_back(place(i, j, k));
      }
    }
  }
  const auto add_box = [&](int i, int j, int k) {
    std::array<std::size_t, 3> axis{0, 1, 2};  // Kuhn: one cell per order of walking the axes
    do {
      std::array<int, 3> corner{i, j, k};
      std::array<int, 4> cell{vertex(corner)};
      for (std::size_t step = 0; step < 3; ++step) {
        ++corner[axis[step]];
        cell[step + 1] = vertex(corner);
      }
      mesh.cells.push_back(cell);
    } while (std::ranges::next_permutation(axis).found);
  };
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        if (keep(i, j, k)) {
          add_box(i, j, k);
        }
      }
    }
  }
  drop_unused_points(mesh);
  mesh.region.assign(mesh.cells.size(), 0);
  mesh.region_names = {"tissue"};
  check_and_orient(mesh, "structured mesh");
  return mesh;
}

}  // namespace

TetMesh lattice(std::array<int, 3> n, const std::function<Vec3(int, int, int)>& place) {
  return boxes(n, place, [](int, int, int) { return true; });
}

TetMesh block(const Vec3& size, const std::array<int, 3>& n) {
  TetMesh mesh = lattice(n, [&](int i, int j, int k) {
    return Vec3{size[0] * i / n[0], size[1] * j / n[1], size[2] * k / n[2]};
  });
  name_boundaries(mesh, {"x0", "x1", "y0", "y1", "z0", "z1"}, [&](std::size_t name, const Vec3& p) {
    const double target = name % 2 == 0 ? 0.0 : size[name / 2];
    return std::abs(p[name / 2] - target) < 1e-9 * size[name / 2];
  });
  return mesh;
}

TetMesh bar(int count, double length, double width) {
  return lattice({count, 1, 1}, [=](int i, int j, int k) {
    return Vec3{i * length / count, j * width, k * width};
  });
}

TetMesh ball_octant(const std::vector<double>& radii, int hollow) {
  const int n = static_cast<int>(radii.size()) - 1;
  ensure(n > hollow && radii.front() == 0.0, "a ball needs radii from 0 outwards");
  TetMesh mesh = boxes(
      {n, n, n},
      [&](int i, int j, int k) {
        const Vec3 direction{1.0 * i, 1.0 * j, 1.0 * k};
        const double r = norm(direction);
        return r == 0.0 ? direction : (radii[index(std::max({i, j, k}))] / r) * direction;
      },
      [&](int i, int j, int k) {
        return std::max({i, j, k}) >= hollow;
      });
  const double close = 1e-9 * radii.back();
  std::vector<std::string> names{"x0", "y0", "z0", "outer"};
  if (hollow > 0) {
    names.emplace_back("inner");
  }
  name_boundaries(mesh, names, [&](std::size_t name, const Vec3& p) {
    if (name < 3) {
      return std::abs(p[name]) < close;
    }
    return std::abs(norm(p) - (name == 3 ? radii.back() : radii[index(hollow)])) < close;
  });
  return mesh;
}

TetMesh tube_quarter(double inner, double outer, double height, int layers, int around) {
  TetMesh mesh = lattice({layers, around, 1}, [=](int i, int j, int k) {
    const double r = inner + (outer - inner) * i / layers;
    const double angle = 0.5 * std::numbers::pi * j / around;
    return Vec3{j == around ? 0.0 : r * std::cos(angle), r * std::sin(angle), k * height};
  });
  const double close = 1e-9 * outer;
  name_boundaries(mesh, {"x0", "y0", "z0", "z1", "inner", "outer"},
                  [&](std::size_t name, const Vec3& p) {
                    if (name < 3) {
                      return std::abs(p[name]) < close;
                    }
                    if (name == 3) {
                      return std::abs(p[2] - height) < close;
                    }
                    return std::abs(std::hypot(p[0], p[1]) - (name == 4 ? inner : outer)) < close;
                  });
  return mesh;
}

std::vector<double> graded_radii(double first, int layers, double outer, double growth) {
  std::vector<double> radii;
  for (int k = 0; k <= layers; ++k) {
    radii.push_back(k * first / layers);
  }
  for (double h = first / layers; radii.back() < outer;) {
    h *= growth;
    radii.push_back(radii.back() + h > outer - 0.5 * h ? outer : radii.back() + h);
  }
  return radii;
}

std::vector<std::uint8_t> symmetry_supports(const TetMesh& mesh) {
  std::vector<std::uint8_t> fixed(mesh.points.size(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int v : vertices_on(mesh, std::array{"x0", "y0", "z0"}[index(axis)])) {
      fixed[index(v)] |= static_cast<std::uint8_t>(1 << axis);
    }
  }
  return fixed;
}

Vec3 centroid(const TetMesh& mesh, std::size_t cell) {
  Vec3 sum{};
  for (const int v : mesh.cells[cell]) {
    sum += 0.25 * mesh.points[index(v)];
  }
  return sum;
}

std::vector<double> cells_where(const TetMesh& mesh,
                                const std::function<bool(const Vec3&)>& inside) {
  std::vector<double> share;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    share.push_back(inside(centroid(mesh, c)) ? 1.0 : 0.0);
  }
  return share;
}

}  // namespace sanatrix
