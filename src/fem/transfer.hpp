// Values of the shares of a mesh, in the order of the whole mesh: to and from rank 0, which reads
// and writes files.
#pragma once

#include <span>
#include <vector>

#include "fem/layout.hpp"
#include "fem/mesh_share.hpp"

namespace sanatrix::fem {

/// Vertices, cells or nodes of all shares.
class Transfer {
 public:
  /// number: of every local item in the whole; own: items that this process, and no other, sends.
  /// Collective, as all that follows.
  Transfer(std::vector<int> number, std::vector<bool> own);
  /// `width` values of every local item -> of all items, on rank 0; empty elsewhere.
  [[nodiscard]] std::vector<double> to_leader(std::span<const double> local, int width) const;
  /// The other way: every process gets the values of its items, own and ghosts; what processes
  /// other than rank 0 give is ignored.
  [[nodiscard]] std::vector<double> from_leader(std::span<const double> whole, int width) const;

 private:
  std::vector<int> number_;
  std::vector<bool> own_;
  /// On rank 0: numbers of the items that processes send and that they want, one process after
  /// another.
  std::vector<int> sent_, wanted_;
};

Transfer vertex_transfer(const MeshShare& share);
Transfer cell_transfer(const MeshShare& share);
/// Vertices, then mid-edge nodes where `edges` of the local mesh is not empty. The whole mesh's are
/// numbered as make_edges does; `whole` is looked at on rank 0 only.
Transfer node_transfer(const MeshShare& share, const EdgeTable& edges, const TetMesh& whole);

}  // namespace sanatrix::fem
