// Smoothing domains of a mesh of linear cells: which cells share a strain (domain_element).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem/layout.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::mechanics {

/// One domain per edge: the edge's cells, and their vertices in ascending order.
class SmoothingDomains {
 public:
  SmoothingDomains() = default;
  SmoothingDomains(std::span<const std::array<int, 4>> cells, const fem::EdgeTable& edges);

  [[nodiscard]] int size() const { return static_cast<int>(first_node_.size()) - 1; }
  [[nodiscard]] std::span<const int> nodes(int domain) const;
  [[nodiscard]] std::span<const int> cells(int domain) const;
  /// Per cell of the domain its corners, counted among the domain's nodes.
  [[nodiscard]] std::span<const std::array<int, 4>> corners(int domain) const;

  /// Cells much softer than the stiffest around an edge stay out of that edge's domain: strain
  /// jumps at their wall, and a mean would hide it. Wounded cells stay out of every domain: without
  /// their own bulk modulus hardly anything would hold them. So do cells whose share of it was
  /// raised (Tissue::guard), which has no effect in a domain.
  void leave_out_soft(std::span<const Tissue> tissue);
  [[nodiscard]] std::span<const std::uint8_t> inside(int domain) const;
  /// Of a cell's volume, the share that lies in no domain.
  [[nodiscard]] double left_out(int cell) const;

 private:
  std::vector<int> first_node_{0}, node_, first_cell_{0}, cell_;
  std::vector<std::array<int, 4>> corner_;
  std::vector<std::uint8_t> inside_;  ///< per entry of cell_
  std::vector<int> times_left_out_;   ///< per cell of the mesh, of its six edges
};

}  // namespace sanatrix::mechanics
