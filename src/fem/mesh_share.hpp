// One process's share of a mesh that PETSc's DMPlex distributes: no process keeps the whole.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "fem/layout.hpp"
#include "geometry/tet_mesh.hpp"

namespace sanatrix::fem {

class MeshShare {
 public:
  /// Distributes the mesh of rank 0; what the others give is ignored. Collective.
  explicit MeshShare(const TetMesh& whole);
  ~MeshShare();
  MeshShare(const MeshShare&) = delete;
  MeshShare& operator=(const MeshShare&) = delete;

  /// Own vertices, every cell that touches one, and what these cells need. All names are kept; a
  /// named point that is not an own vertex of this process has vertex -1.
  [[nodiscard]] const TetMesh& mesh() const;
  /// Numbers in the whole mesh, per local vertex and per local cell.
  [[nodiscard]] const std::vector<int>& vertex() const;
  [[nodiscard]] const std::vector<int>& cell() const;
  /// Every vertex and every cell is owned by exactly one process.
  [[nodiscard]] bool owns_vertex(int v) const;
  [[nodiscard]] bool owns_cell(int c) const;
  [[nodiscard]] int whole_vertices() const;
  [[nodiscard]] int whole_cells() const;
  /// Vertices and, where `edges` (of the local mesh) is not empty, mid-edge nodes. Collective.
  [[nodiscard]] Layout layout(const EdgeTable& edges) const;
  /// Overwrites the entries of vertices that others own by what their owners hold. Collective.
  void fetch(std::vector<std::uint8_t>& per_vertex) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::fem
