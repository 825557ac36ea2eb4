// A sparse linear system of node blocks (three displacements and a pressure) that is assembled from
// element contributions again and again with one pattern. The seam to PETSc's matrices and solvers.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/layout.hpp"
#include "geometry/vec3.hpp"

namespace sanatrix::fem {

/// Elements this process evaluates, as lists of its nodes.
struct ElementList {
  std::vector<int> offset{0};
  std::vector<int> nodes;
  void add(std::span<const int> element_nodes);
  [[nodiscard]] int size() const { return static_cast<int>(offset.size()) - 1; }
  [[nodiscard]] std::span<const int> of(int element) const {
    const auto e = static_cast<std::size_t>(element);
    return std::span(nodes).subspan(static_cast<std::size_t>(offset[e]),
                                    static_cast<std::size_t>(offset[e + 1] - offset[e]));
  }
};

/// A range of a process's own rows, counted from zero: what one thread writes.
struct RowPart {
  int begin, end;
};

struct LinearReport {
  bool converged = false;
  int iterations = 0;
  bool factorised = false;
};

/// Whose residual the smoother lowers: the system's, or that of the matrix its factors are made of,
/// where that is far from the system.
enum class Smoothed { System, Factored };

/// Vectors hold `block` values per node of the process, x y z p; only those of owned nodes count,
/// except in solutions, which are complete.
class SparseSystem {
 public:
  /// elements: every element that touches an owned node, so that assembly needs no messages.
  /// fixed: per node, bit i holds unknown i: unit diagonal, zero residual. Positions [m] shape the
  /// coarse space. All calls that speak of a matrix or of solving are collective.
  /// narrow: given, the preconditioner is that of another system of so many of the first elements,
  /// with fewer neighbours, that is close to this one; it consists of what is added for it.
  SparseSystem(const Layout& layout, const ElementList& elements,
               std::span<const std::uint8_t> fixed, std::span<const Vec3> positions,
               std::optional<int> narrow = {});
  ~SparseSystem();
  SparseSystem(const SparseSystem&) = delete;
  SparseSystem& operator=(const SparseSystem&) = delete;

  void clear(bool with_matrix);
  /// The part-th of `parts` equal ranges of rows: threads that write different parts may add the
  /// same element at the same time, and sums do not depend on their number.
  [[nodiscard]] RowPart part(int part, int parts) const;
  /// Adds the rows of one element that lie in the part. Its unknowns: x y z of every node, then the
  /// pressures of the first `pressures` nodes. matrix: row-major, or empty.
  void add(int element, int pressures, std::span<const double> vector,
           std::span<const double> matrix, RowPart part);
  /// The same for elements with a pressure at every node: x y z p per node, and 4 x 4 blocks per
  /// pair of nodes, each by columns, or none.
  void add_blocks(int element, std::span<const double> vector, std::span<const double> blocks,
                  RowPart part);
  /// Adds to the matrix of which incomplete factors are made, beside the system's values or, where
  /// there is a narrow system, alone: the rows of one element as above, or per node an entry of the
  /// pressure's diagonal.
  void add_for_factors(int element, int pressures, std::span<const double> matrix, RowPart part);
  void add_for_factors(std::span<const double> pressure_diagonal);
  /// After the last add.
  void finish_matrix();
  [[nodiscard]] const std::vector<double>& vector() const;

  void set_smoothed(Smoothed smoothed);
  /// Levels of fill of the incomplete factors, 0 at first. One level costs as much as it saves, but
  /// where stiffness jumps by decades it takes a fifth of the iterations (docs/adr, 8).
  void set_fill(int levels);

  /// x = A^-1 b by GMRES. First choice is the two-level preconditioner (incomplete factors of the
  /// node blocks and a coarse space of affine motions); where that fails, and for small systems,
  /// the last MUMPS factorisation is used while it is good enough. Not so for large systems, where
  /// a failure is reported: factors would not fit in memory.
  LinearReport solve(std::span<const double> b, double relative_tolerance, std::vector<double>& x);
  /// The next solve starts with a fresh preconditioner: a run that is resumed here takes the same
  /// path as one that was never stopped.
  void forget_factorisation();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::fem
