#include "mechanics/smoothing.hpp"

#include <algorithm>

namespace sanatrix::mechanics {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Of the stiffest cell's shear modulus; gland is four times as stiff as fat.
constexpr double much_softer = 0.1;
/// Of whole tissue's; a fresh wound has a hundredth, for about a fortnight less than this.
constexpr double whole_integrity = 0.5;

template <class T>
std::span<const T> part(const std::vector<T>& of, const std::vector<int>& first, int i) {
  return std::span(of).subspan(index(first[index(i)]),
                               index(first[index(i) + 1] - first[index(i)]));
}

}  // namespace

SmoothingDomains::SmoothingDomains(std::span<const std::array<int, 4>> cells,
                                   const fem::EdgeTable& edges)
    : times_left_out_(cells.size(), 0) {
  std::vector<std::vector<int>> around(edges.edges.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (const int e : edges.cell_edges[c]) {
      around[index(e)].push_back(static_cast<int>(c));
    }
  }
  for (const std::vector<int>& own : around) {
    std::vector<int> nodes;
    for (const int c : own) {
      nodes.insert(nodes.end(), cells[index(c)].begin(), cells[index(c)].end());
    }
    std::ranges::sort(nodes);
    nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
    for (const int c : own) {
      std::array<int, 4> corner{};
      std::ranges::transform(cells[index(c)], corner.begin(), [&](int v) {
        return static_cast<int>(std::ranges::lower_bound(nodes, v) - nodes.begin());
      });
      corner_.push_back(corner);
      cell_.push_back(c);
    }
    node_.insert(node_.end(), nodes.begin(), nodes.end());
    first_node_.push_back(static_cast<int>(node_.size()));
    first_cell_.push_back(static_cast<int>(cell_.size()));
  }
  inside_.assign(cell_.size(), 1);
}

std::span<const int> SmoothingDomains::nodes(int domain) const {
  return part(node_, first_node_, domain);
}
std::span<const int> SmoothingDomains::cells(int domain) const {
  return part(cell_, first_cell_, domain);
}
std::span<const std::array<int, 4>> SmoothingDomains::corners(int domain) const {
  return part(corner_, first_cell_, domain);
}
std::span<const std::uint8_t> SmoothingDomains::inside(int domain) const {
  return part(inside_, first_cell_, domain);
}
double SmoothingDomains::left_out(int cell) const {
  return times_left_out_[index(cell)] / 6.0;
}

void SmoothingDomains::leave_out_soft(std::span<const Tissue> tissue) {
  const auto shear = [&](int c) {
    const Tissue& t = tissue[index(c)];
    return t.integrity * (t.c1 + t.c2);
  };
  std::ranges::fill(times_left_out_, 0);
  for (int d = 0; d < size(); ++d) {
    double stiffest = 0.0;
    for (const int c : cells(d)) {
      stiffest = std::max(stiffest, shear(c));
    }
    for (int i = first_cell_[index(d)]; i < first_cell_[index(d) + 1]; ++i) {
      const int c = cell_[index(i)];
      const Tissue& t = tissue[index(c)];
      const bool needs_own_bulk = t.integrity < whole_integrity || t.guard > 1.0;
      inside_[index(i)] = !needs_own_bulk && shear(c) >= much_softer * stiffest ? 1 : 0;
      times_left_out_[index(c)] += inside_[index(i)] != 0 ? 0 : 1;
    }
  }
}

}  // namespace sanatrix::mechanics
