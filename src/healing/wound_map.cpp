#include "healing/wound_map.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "core/error.hpp"

namespace sanatrix::healing {
namespace {

/// The faces between wound cells and the others.
std::vector<std::array<int, 3>> surface(const TetMesh& mesh, const std::vector<bool>& wound) {
  std::map<std::array<int, 3>, int> balance;  // wound cells minus other cells at a face
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto& [p, q, r, s] = mesh.cells[c];
    for (std::array<int, 3> face : {std::array{q, r, s}, {p, r, s}, {p, q, s}, {p, q, r}}) {
      std::ranges::sort(face);
      const auto [found, first] = balance.try_emplace(face, 0);
      // 0 after both: one of each. A boundary face of the mesh stays at +1 or -1.
      found->second += wound[c] ? 1 : -1;
    }
  }
  std::vector<std::array<int, 3>> faces;
  for (const auto& [face, sum] : balance) {
    if (sum == 0) {
      faces.push_back(face);
    }
  }
  return faces;
}

}  // namespace

WoundMap make_wound_map(const TetMesh& mesh, std::span<const Vec3> points,
                        std::span<const double> wound_fraction, const fem::MeshShare* share) {
  const std::size_t n = points.size();
  WoundMap map{std::vector<bool>(mesh.cells.size()), std::vector<bool>(n), std::vector<double>(n),
               std::vector<double>(n)};
  const std::vector<double> volumes = cell_volumes(mesh, points);
  std::vector<double> lumped(n);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    map.cell[c] = wound_fraction[c] >= 0.5;
    for (const int i : mesh.cells[c]) {
      lumped[i] += volumes[c];
      map.fraction[i] += volumes[c] * wound_fraction[c];
      map.vertex[i] = map.vertex[i] || map.cell[c];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    ensure(lumped[i] > 0.0, "vertex {} of the healing mesh belongs to no cell", i);
    map.fraction[i] /= lumped[i];
  }
  for (const auto& [a, b, c] : surface(mesh, map.cell)) {
    const double area = 0.5 * norm(cross(points[b] - points[a], points[c] - points[a]));
    for (const int i : {a, b, c}) {
      map.area[i] += area / 3.0;
    }
  }
  if (share != nullptr) {
    std::vector<std::uint8_t> touched(map.vertex.begin(), map.vertex.end());
    share->fetch(touched);
    map.vertex.assign(touched.begin(), touched.end());
  }
  return map;
}

}  // namespace sanatrix::healing
