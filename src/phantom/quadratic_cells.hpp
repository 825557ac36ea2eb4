// P2 cells and faces as many small linear ones, for drawing and for voxels.
#pragma once

#include <map>
#include <span>
#include <string>

#include "geometry/tri_mesh.hpp"
#include "phantom/body_mesh.hpp"

namespace sanatrix::phantom {

/// Nodes are vertices first, then one per edge in the order of `edges`.
class QuadraticCells {
 public:
  QuadraticCells(const TetMesh& mesh, std::span<const std::array<int, 2>> edges);

  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  /// Positions of the lattice points of a cell.
  [[nodiscard]] std::vector<Vec3> lattice_points(std::size_t cell,
                                                 std::span<const Vec3> nodes) const;
  /// A named boundary, as finely divided as the cells; faces do not share points.
  [[nodiscard]] TriMesh boundary(const std::string& name, std::span<const Vec3> nodes) const;

 private:
  [[nodiscard]] std::size_t middle(int a, int b) const;
  void add_face(const std::array<int, 3>& face, std::span<const Vec3> nodes,
                TriMesh& surface) const;
  const TetMesh& mesh_;
  std::map<std::array<int, 2>, std::size_t> edge_node_;
  Lattice lattice_;
};

}  // namespace sanatrix::phantom
