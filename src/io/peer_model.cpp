#include "io/peer_model.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/peer_nodes.hpp"

namespace sanatrix::io {

std::vector<int> PeerNodes::face(const std::array<int, 3>& vertices) const {
  std::vector<int> nodes(vertices.begin(), vertices.end());
  if (!mid_edge.empty()) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto& [i, j] = std::minmax(vertices[a], vertices[(a + 1) % 3]);
      nodes.push_back(mid_edge.at({i, j}));
    }
  }
  return nodes;
}

PeerNodes make_peer_nodes(const PeerModel& model) {
  PeerNodes nodes{model.mesh.points, {}, model.fixed, {}};
  constexpr std::array<std::array<std::size_t, 2>, 6> edges{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (const auto& cell : model.mesh.cells) {
    nodes.cells.emplace_back(cell.begin(), cell.end());
    for (std::size_t e = 0; model.order == 2 && e < edges.size(); ++e) {
      const int a = std::min(cell[edges[e][0]], cell[edges[e][1]]);
      const int b = std::max(cell[edges[e][0]], cell[edges[e][1]]);
      const auto [place, is_new] =
          nodes.mid_edge.try_emplace({a, b}, static_cast<int>(nodes.points.size()));
      if (is_new) {
        const auto i = static_cast<std::size_t>(a);
        const auto j = static_cast<std::size_t>(b);
        nodes.points.push_back(0.5 * (nodes.points[i] + nodes.points[j]));
        nodes.fixed.push_back(nodes.fixed[i] & nodes.fixed[j]);
      }
      nodes.cells.back().push_back(place->second);
    }
  }
  return nodes;
}

void write_peer(const PeerModel& model, PeerFormat format, const std::filesystem::path& file) {
  ensure(model.materials.size() == model.mesh.region_names.size(), "{} materials for {} regions",
         model.materials.size(), model.mesh.region_names.size());
  switch (format) {
    case PeerFormat::Msh:
      return write_text(file, msh_text(model));
    case PeerFormat::Vtu:
      return write_text(file, peer_vtu_text(model));
    case PeerFormat::Feb:
      return write_text(file, feb_text(model));
    case PeerFormat::Inp:
      return write_text(file, inp_text(model));
  }
}

}  // namespace sanatrix::io
