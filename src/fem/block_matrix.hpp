// PETSc matrix of 4 x 4 node blocks, filled straight from element matrices. Seen only inside fem.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <petscmat.h>

#include "fem/layout.hpp"
#include "fem/sparse_system.hpp"

namespace sanatrix::fem {

/// The blocks of this rank's rows by compressed rows: row r has blocks [begin[r], begin[r+1]).
/// A block is stored by columns: entry (i, k) at values[16 b + 4 k + i].
struct BlockRows {
  Mat matrix = nullptr;  ///< sequential
  const PetscInt* begin = nullptr;
  const PetscInt* column = nullptr;
  PetscScalar* values = nullptr;
  [[nodiscard]] PetscInt find(int row, PetscInt wanted) const;
};

class BlockMatrix {
 public:
  BlockMatrix(const Layout& layout, const ElementList& elements,
              std::span<const std::uint8_t> fixed);
  ~BlockMatrix();
  BlockMatrix(const BlockMatrix&) = delete;
  BlockMatrix& operator=(const BlockMatrix&) = delete;

  [[nodiscard]] Mat petsc() const { return matrix_; }
  void clear();
  void add(int element, int pressures, std::span<const double> values, RowPart part);
  /// Unit diagonal for fixed unknowns; tells PETSc that values changed.
  void finish();
  /// Columns of `local` are owned nodes counted from own_begin; columns of `remote` index
  /// remote_columns.
  [[nodiscard]] const BlockRows& local() const { return local_; }
  [[nodiscard]] const BlockRows& remote() const { return remote_; }
  [[nodiscard]] const std::vector<PetscInt>& remote_columns() const { return remote_columns_; }
  /// Adds to the pressure's diagonal entry of an owned row.
  void add_to_pressure_diagonal(int row, double value);

 private:
  void make_pattern(const ElementList& elements);
  void open(Mat part, BlockRows& rows);
  void close(BlockRows& rows);
  void list_slots(const ElementList& elements);
  /// A block with fixed unknowns: bits of the rows and columns that do not count.
  struct HeldBlock {
    int slot;
    std::uint8_t rows, columns;
  };
  [[nodiscard]] double* slot(std::int64_t s) {
    return s >= 0 ? local_.values + 16 * s : remote_.values + 16 * (-s - 2);
  }

  const Layout& layout_;
  std::vector<int> offset_, nodes_;
  std::vector<std::uint8_t> fixed_;
  std::vector<int> row_of_node_;         ///< own row, or -1
  std::vector<std::size_t> first_slot_;  ///< per element
  std::vector<int> slots_;  ///< per node pair: block of local_; -1 not mine; -2 - block of remote_
  std::vector<HeldBlock> held_;
  std::vector<PetscInt> diagonal_;  ///< per own row: its diagonal block
  std::vector<PetscInt> remote_columns_;
  Mat matrix_ = nullptr;
  BlockRows local_, remote_;
};

}  // namespace sanatrix::fem
