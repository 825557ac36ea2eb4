#include "fem/layout.hpp"

#include <algorithm>
#include <numeric>

#include "fem/session.hpp"

namespace sanatrix::fem {

/// Halves space along its longest axis until single nodes remain.
void order_by_place(std::span<const Vec3> positions, std::span<int> nodes) {
  if (nodes.size() < 2) {
    return;
  }
  Vec3 low = positions[static_cast<std::size_t>(nodes[0])];
  Vec3 high = low;
  for (const int n : nodes) {
    const Vec3& p = positions[static_cast<std::size_t>(n)];
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  const Vec3 extent = high - low;
  const auto axis =
      static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
  const auto middle = static_cast<std::ptrdiff_t>(nodes.size() / 2);
  std::nth_element(nodes.begin(), nodes.begin() + middle, nodes.end(), [&](int a, int b) {
    const double pa = positions[static_cast<std::size_t>(a)][axis];
    const double pb = positions[static_cast<std::size_t>(b)][axis];
    return pa != pb ? pa < pb : a < b;
  });
  order_by_place(positions, nodes.first(static_cast<std::size_t>(middle)));
  order_by_place(positions, nodes.subspan(static_cast<std::size_t>(middle)));
}

int EdgeTable::find(int a, int b) const {
  const std::array<int, 2> key{std::min(a, b), std::max(a, b)};
  const auto it = std::lower_bound(edges.begin(), edges.end(), key);
  return it != edges.end() && *it == key ? static_cast<int>(it - edges.begin()) : -1;
}

EdgeTable make_edges(std::span<const std::array<int, 4>> cells) {
  EdgeTable table;
  table.edges.reserve(6 * cells.size());
  for (const auto& cell : cells) {
    for (const auto& [i, j] : EdgeTable::local) {
      const int a = cell[static_cast<std::size_t>(i)];
      const int b = cell[static_cast<std::size_t>(j)];
      table.edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(table.edges.begin(), table.edges.end());
  table.edges.erase(std::unique(table.edges.begin(), table.edges.end()), table.edges.end());
  table.cell_edges.resize(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (std::size_t e = 0; e < 6; ++e) {
      const auto& [i, j] = EdgeTable::local[e];
      table.cell_edges[c][e] =
          table.find(cells[c][static_cast<std::size_t>(i)], cells[c][static_cast<std::size_t>(j)]);
    }
  }
  return table;
}

Layout make_layout(std::span<const Vec3> node_positions) {
  std::vector<int> order(node_positions.size());
  std::iota(order.begin(), order.end(), 0);
  order_by_place(node_positions, order);
  Layout layout;
  layout.total = static_cast<int>(order.size());
  layout.global.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    layout.global[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  const auto share = [&](long r) {
    return static_cast<int>(r * layout.total / ranks());
  };
  layout.own_begin = share(rank());
  layout.own_end = share(rank() + 1);
  return layout;
}

}  // namespace sanatrix::fem
