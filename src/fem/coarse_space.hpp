// Coarse space of a two-level preconditioner: the affine motions and the mean pressure of compact
// groups of nodes. It removes the long waves that incomplete factors cannot see, so that iterations
// hardly grow with the mesh (aggregation without smoothing; doi:10.1007/BF02238511). Rigid motions
// would leave jumps between the groups wherever the body is strained. Seen only inside fem.
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
  static constexpr int modes = 13;
  /// Nodes of a group. Larger groups: cheaper coarse systems, more iterations.
  static constexpr int group_size = 110;

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
    /// 1, x, y, z of every displacement, 1 of the pressure (four would serve no better).
    std::array<double, modes> value{};
  };
  static constexpr int packed = 1 + modes;

  void make_modes(std::span<const std::uint8_t> fixed, std::span<const Vec3> positions);
  void fetch_remote_modes();
  void make_interpolation();
  void make_coarse_pattern();
  static void make_orthonormal(std::span<NodeModes> rows, int first, int end);
  static void add_block(const NodeModes& row, const NodeModes& column, const double* block,
                        double* sum);
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
