// A sparse linear system that is assembled from element contributions again and again with one
// pattern. The seam to PETSc's matrices and linear solvers.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem/layout.hpp"

namespace sanatrix::fem {

/// Elements of this rank: flat lists of global unknowns. An unknown that is held fixed appears as
/// -1: its contributions are dropped.
struct ElementList {
  std::vector<int> offset{0};  ///< element e has dofs[offset[e] .. offset[e+1])
  std::vector<int> dofs;
  void add(std::span<const int> element_dofs);
  [[nodiscard]] int size() const { return static_cast<int>(offset.size()) - 1; }
};

enum class Symmetry { Symmetric, General };

struct LinearReport {
  bool converged = false;
  int iterations = 0;
  bool factorised = false;
};

class SparseSystem {
 public:
  /// fixed: unknowns (of any rank) that are held; they get a unit diagonal and a zero residual.
  /// pressure: per unknown, is it a pressure? (for block preconditioning of large systems)
  SparseSystem(const Layout& layout, const ElementList& elements, std::span<const int> fixed,
               std::vector<bool> pressure, Symmetry symmetry);
  ~SparseSystem();
  SparseSystem(const SparseSystem&) = delete;
  SparseSystem& operator=(const SparseSystem&) = delete;

  /// Dense row-major block of element e; write it, then call assemble_matrix(). Threads may write
  /// different elements at the same time.
  [[nodiscard]] std::span<double> matrix_block(int element);
  [[nodiscard]] std::span<double> vector_block(int element);
  void assemble_matrix();
  /// Sums the element vectors; the result is complete on every rank.
  void assemble_vector(std::vector<double>& full);

  /// x = A^-1 b by FGMRES. First choice is the block preconditioner (incomplete factors of the
  /// displacement block, diagonal Schur complement); where that fails, and for small systems, the
  /// last MUMPS factorisation is used while it is good enough. b and x are complete on every rank.
  LinearReport solve(std::span<const double> b, double relative_tolerance, std::vector<double>& x);
  /// The next solve starts with a fresh factorisation.
  void forget_factorisation();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::fem
