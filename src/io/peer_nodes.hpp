// Nodes and cells of a peer model at its order.
#pragma once

#include <map>

#include "io/peer_model.hpp"

namespace sanatrix::io {

/// Vertices first, then one straight mid-edge node per edge.
struct PeerNodes {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> cells;  ///< 4 or 10 nodes; mid-edges 01, 12, 02, 03, 13, 23
  std::vector<std::uint8_t> fixed;      ///< a mid-edge node is held where both ends are
  std::map<std::array<int, 2>, int> mid_edge;

  /// 3 or 6 nodes of a face; mid-edges 01, 12, 20.
  [[nodiscard]] std::vector<int> face(const std::array<int, 3>& vertices) const;
};
PeerNodes make_peer_nodes(const PeerModel& model);

std::string feb_text(const PeerModel& model);
std::string inp_text(const PeerModel& model);
std::string msh_text(const PeerModel& model);
std::string peer_vtu_text(const PeerModel& model);

}  // namespace sanatrix::io
