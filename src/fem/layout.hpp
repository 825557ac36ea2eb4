// Nodes of a discretisation: mid-edge nodes, global numbers, and which process owns which.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix::fem {

/// Unique edges of a tetrahedral mesh and the six edges of every cell.
struct EdgeTable {
  static constexpr std::array<std::array<int, 2>, 6> local{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  std::vector<std::array<int, 2>> edges;       ///< vertex pairs, first < second, ascending
  std::vector<std::array<int, 6>> cell_edges;  ///< in the order of `local`
  /// Index of an edge, or -1.
  [[nodiscard]] int find(int a, int b) const;
};
EdgeTable make_edges(std::span<const std::array<int, 4>> cells);

/// Unknowns per node in every linear system: three displacements and a pressure. A node without a
/// pressure (mid-edge) holds it fixed.
constexpr int block = 4;

/// Global numbering of the nodes a process works with. Nodes are ordered along a recursive
/// bisection of space, so that every rank owns one contiguous, compact range and neighbours stay
/// close in memory.
struct Layout {
  std::vector<int> global;         ///< per node
  int own_begin = 0, own_end = 0;  ///< global range of this rank
  int total = 0;                   ///< nodes of all ranks
  [[nodiscard]] bool owns(int node) const {
    const int g = global[static_cast<std::size_t>(node)];
    return g >= own_begin && g < own_end;
  }
  [[nodiscard]] int own() const { return own_end - own_begin; }
};
/// Orders nodes along a recursive bisection of space.
void order_by_place(std::span<const Vec3> positions, std::span<int> nodes);
/// All nodes known to all ranks, owned in equal shares.
Layout make_layout(std::span<const Vec3> node_positions);

}  // namespace sanatrix::fem
