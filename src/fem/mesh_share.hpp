// One process's share of a mesh that PETSc's DMPlex distributes: no process keeps the whole.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fem/layout.hpp"
#include "geometry/tet_mesh.hpp"

namespace sanatrix::fem {

class MeshShare {
 public:
  /// Distributes the mesh of rank 0; what the others give is ignored. Collective. layers: 1: every
  /// process has the cells that touch own vertices; 2: and those that touch these cells.
  explicit MeshShare(const TetMesh& whole, int layers = 1);
  ~MeshShare();
  MeshShare(const MeshShare&) = delete;
  MeshShare& operator=(const MeshShare&) = delete;

  /// Own vertices, so many layers of cells around them, and what these cells need. All names are
  /// kept; a named point that is not an own vertex of this process has vertex -1.
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
  /// The same for `width` numbers per vertex.
  void fetch(std::span<double> per_vertex, int width) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A mesh that is not shared (nullptr) belongs to this process as a whole.
inline bool owns_vertex(const MeshShare* share, std::size_t v) {
  return share == nullptr || share->owns_vertex(static_cast<int>(v));
}
inline bool owns_cell(const MeshShare* share, std::size_t c) {
  return share == nullptr || share->owns_cell(static_cast<int>(c));
}
/// Over all shares of what each has counted of its own. Collective where the mesh is shared.
double sum(const MeshShare* share, double mine);
void sum_each(const MeshShare* share, std::span<double> mine);
double largest(const MeshShare* share, double mine);

/// How a mesh lies on the processes: what a model of the cost of more of them is made from.
struct ShareSizes {
  int most_own_vertices, most_ghost_vertices;  ///< of one process
  double mean_ghost_vertices;
};
ShareSizes sizes(const MeshShare& share);  ///< collective

}  // namespace sanatrix::fem
