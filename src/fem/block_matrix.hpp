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

/// Values in the pattern: blocks with columns of this rank, and with columns of others.
struct BlockValues {
  Mat matrix = nullptr;
  BlockRows local, remote;
};

/// A second set of values in the same pattern, for the matrix that incomplete factors are made of.
enum class Beside { None, Kept };

/// Holds the values of the system and, if wanted, what is added to it for the factors.
class BlockMatrix {
 public:
  /// From the first `count` elements.
  BlockMatrix(const Layout& layout, const ElementList& elements, int count,
              std::span<const std::uint8_t> fixed, Beside beside);
  ~BlockMatrix();
  BlockMatrix(const BlockMatrix&) = delete;
  BlockMatrix& operator=(const BlockMatrix&) = delete;

  [[nodiscard]] Mat petsc() const { return system_.matrix; }
  void clear();
  void add(int element, int pressures, std::span<const double> values, RowPart part) {
    add(system_, element, pressures, values, part);
  }
  /// The same from 4 x 4 blocks per pair of nodes, each by columns.
  void add_blocks(int element, std::span<const double> blocks, RowPart part);
  void add_for_factors(int element, int pressures, std::span<const double> values, RowPart part) {
    add(beside_, element, pressures, values, part);
  }
  /// The same on the pressure's diagonal entry of an owned row; to the system where nothing is kept
  /// beside it.
  void add_for_factors(int row, double value);
  /// Unit diagonal for fixed unknowns; tells PETSc that values changed.
  void finish();
  /// The system and what was added for the factors, summed when first asked for after finish.
  [[nodiscard]] Mat for_factors();
  /// Its blocks with columns of this rank.
  [[nodiscard]] const BlockRows& local_for_factors() const {
    return beside_.matrix != nullptr ? beside_.local : system_.local;
  }
  /// Columns of `local` are owned nodes counted from own_begin; columns of `remote` index
  /// remote_columns.
  [[nodiscard]] const BlockRows& local() const { return system_.local; }
  [[nodiscard]] const BlockRows& remote() const { return system_.remote; }
  [[nodiscard]] const std::vector<PetscInt>& remote_columns() const { return remote_columns_; }

 private:
  void make_pattern(const ElementList& elements, int count, Beside beside);
  void open(BlockValues& values);
  void open(Mat part, BlockRows& rows);
  static void close(BlockValues& values);
  void clear(BlockValues& values) const;
  void add(BlockValues& to, int element, int pressures, std::span<const double> values,
           RowPart part);
  void finish(BlockValues& values, double held_diagonal);
  void list_slots(const ElementList& elements, int count);
  /// A block with fixed unknowns: bits of the rows and columns that do not count.
  struct HeldBlock {
    int slot;
    std::uint8_t rows, columns;
  };
  [[nodiscard]] static double* slot(const BlockValues& of, std::int64_t s) {
    return s >= 0 ? of.local.values + 16 * s : of.remote.values + 16 * (-s - 2);
  }

  const Layout& layout_;
  std::vector<int> offset_, nodes_;
  std::vector<std::uint8_t> fixed_;
  std::vector<int> row_of_node_;         ///< own row, or -1
  std::vector<std::size_t> first_slot_;  ///< per element
  std::vector<int>
      slots_;  ///< per node pair: block of `local`; -1 not mine; -2 - block of `remote`
  std::vector<HeldBlock> held_;
  std::vector<PetscInt> diagonal_;  ///< per own row: its diagonal block
  std::vector<PetscInt> remote_columns_;
  BlockValues system_, beside_;
  bool summed_ = false;  ///< does beside_ contain the system by now?
};

}  // namespace sanatrix::fem
