// Coarse space of a two-level preconditioner: the rigid motions and the mean pressure of compact
// groups of nodes. It removes the long waves that incomplete factors cannot see, so that iterations
// hardly grow with the mesh (aggregation without smoothing; doi:10.1007/BF02238511). Seen only
// inside fem.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fem/block_matrix.hpp"
#include "geometry/vec3.hpp"

namespace sanatrix::fem {

class CoarseSpace {
 public:
  static constexpr int rigid = 6, pressures = 1, modes = rigid + pressures;
  /// Nodes of a group. Larger groups: cheaper coarse systems, more iterations.
  static constexpr int group_size = 60;

  CoarseSpace(const Layout& layout, const BlockMatrix& fine, std::span<const std::uint8_t> fixed,
              std::span<const Vec3> positions);
  ~CoarseSpace();
  CoarseSpace(const CoarseSpace&) = delete;
  CoarseSpace& operator=(const CoarseSpace&) = delete;

  [[nodiscard]] Mat interpolation() const { return interpolation_; }
  [[nodiscard]] Mat matrix() const { return coarse_; }
  /// Galerkin product with the fine matrix of the moment. Collective.
  void update();

 private:
  /// What a node contributes to its group's modes.
  struct NodeModes {
    double group = 0.0;  ///< global number; a double because it travels with the rest
    std::array<double, 3 * rigid> displacement{};  ///< [3 mode + i]
    double pressure = 0.0;
  };
  static constexpr int packed = 2 + 3 * rigid;

  void make_modes(std::span<const std::uint8_t> fixed, std::span<const Vec3> positions);
  void fetch_remote_modes();
  void make_interpolation();
  void make_coarse_pattern();
  void add_block(const NodeModes& row, const NodeModes& column, const double* block,
                 double* sum) const;
  [[nodiscard]] int first_row(int group) const;
  [[nodiscard]] std::size_t coarse_place(int group, double neighbour) const;

  const Layout& layout_;
  const BlockMatrix& fine_;
  int groups_ = 0, first_group_ = 0, all_groups_ = 0;
  std::vector<NodeModes> own_, remote_;
  std::vector<PetscInt> begin_{0}, column_;  ///< neighbouring groups of every own group
  std::vector<double> values_;               ///< modes x modes per neighbour, row-major
  Mat interpolation_ = nullptr, coarse_ = nullptr;
};

}  // namespace sanatrix::fem
