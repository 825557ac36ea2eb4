// Which unknowns live at which node, and which process owns them. Identical on every rank.
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

/// Numbering of unknowns: nodes are ordered along a recursive bisection of space, so that every
/// rank owns one contiguous, compact range and neighbours stay close in memory.
struct Layout {
  std::vector<int> first_dof;      ///< per node: its first unknown; the others follow
  std::vector<int> node_dofs;      ///< per node: number of unknowns
  int dofs = 0;                    ///< in all
  int own_begin = 0, own_end = 0;  ///< range of this rank
  [[nodiscard]] bool owns(int dof) const { return dof >= own_begin && dof < own_end; }
};
Layout make_layout(std::span<const Vec3> node_positions, std::vector<int> node_dofs);

}  // namespace sanatrix::fem
