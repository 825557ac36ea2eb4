#include "fem/block_matrix.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "fem/four.hpp"
#include "fem/petsc_check.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Pattern by compressed rows, global columns ascending.
struct Pattern {
  std::vector<PetscInt> begin{0}, column;
};

Pattern pattern_of(const Layout& layout, const ElementList& elements, int count,
                   const std::vector<int>& row_of_node) {
  std::vector<std::vector<PetscInt>> rows(index(layout.own()));
  for (int g = layout.own_begin; g < layout.own_end; ++g) {
    rows[index(g - layout.own_begin)].push_back(g);  // a node without elements keeps its diagonal
  }
  for (int e = 0; e < count; ++e) {
    const auto nodes = elements.of(e);
    for (const int a : nodes) {
      if (const int row = row_of_node[index(a)]; row >= 0) {
        for (const int b : nodes) {
          rows[index(row)].push_back(layout.global[index(b)]);
        }
      }
    }
  }
  Pattern pattern;
  for (auto& row : rows) {
    std::ranges::sort(row);
    const auto last = std::ranges::unique(row).begin();
    pattern.column.insert(pattern.column.end(), row.begin(), last);
    pattern.begin.push_back(static_cast<PetscInt>(pattern.column.size()));
    std::vector<PetscInt>().swap(row);
  }
  return pattern;
}

/// y = A x of a sequential matrix of node blocks, by all threads; PETSc has one.
PetscErrorCode multiply(Mat A, Vec x, Vec y) {
  PetscInt rows = 0;
  const PetscInt* begin = nullptr;
  const PetscInt* column = nullptr;
  PetscBool done = PETSC_FALSE;
  PetscScalar* values = nullptr;
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  check(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_TRUE, &rows, &begin, &column, &done), "multiplying");
  check(MatSeqBAIJGetArray(A, &values), "multiplying");
  check(VecGetArrayRead(x, &from), "multiplying");
  check(VecGetArrayWrite(y, &to), "multiplying");
  const int parts = threads();
  side_by_side(parts, [&](int part) {
    const PetscInt end = rows * (part + 1) / parts;
    for (PetscInt r = rows * part / parts; r < end; ++r) {
      Four sum{};
      for (PetscInt b = begin[r]; b < begin[r + 1]; ++b) {
        const double* of = values + 16 * b;
        sum += product(of, from + 4 * column[b]);
      }
      four(to + 4 * r) = sum;
    }
  });
  check(VecRestoreArrayWrite(y, &to), "multiplying");
  check(VecRestoreArrayRead(x, &from), "multiplying");
  check(MatSeqBAIJRestoreArray(A, &values), "multiplying");
  check(MatRestoreRowIJ(A, 0, PETSC_FALSE, PETSC_TRUE, &rows, &begin, &column, &done),
        "multiplying");
  return 0;
}

}  // namespace

PetscInt BlockRows::find(int row, PetscInt wanted) const {
  const auto* first = column + begin[row];
  const auto* last = column + begin[row + 1];
  const auto* at = std::lower_bound(first, last, wanted);
  return at != last && *at == wanted ? static_cast<PetscInt>(at - column) : -1;
}

BlockMatrix::BlockMatrix(const Layout& layout, const ElementList& elements, int count,
                         std::span<const std::uint8_t> fixed, Beside beside)
    : layout_(layout),
      offset_(elements.offset),
      nodes_(elements.nodes),
      fixed_(fixed.begin(), fixed.end()),
      row_of_node_(layout.global.size(), -1) {
  for (std::size_t n = 0; n < row_of_node_.size(); ++n) {
    if (layout.owns(static_cast<int>(n))) {
      row_of_node_[n] = layout.global[n] - layout.own_begin;
    }
  }
  make_pattern(elements, count, beside);
  list_slots(elements, count);
}

BlockMatrix::~BlockMatrix() {
  close(system_);
  close(beside_);
}

void BlockMatrix::make_pattern(const ElementList& elements, int count, Beside beside) {
  const Pattern pattern = pattern_of(layout_, elements, count, row_of_node_);
  const PetscInt own = block * layout_.own();
  const PetscInt all = block * layout_.total;
  Mat& matrix = system_.matrix;
  check(MatCreate(PETSC_COMM_WORLD, &matrix), "creating the matrix");
  check(MatSetSizes(matrix, own, own, all, all), "sizing the matrix");
  check(MatSetBlockSize(matrix, block), "sizing the matrix");
  check(MatSetType(matrix, MATBAIJ), "typing the matrix");
  const PetscInt* begin = pattern.begin.data();
  const PetscInt* column = pattern.column.data();
  if (ranks() == 1) {
    check(MatSeqBAIJSetPreallocationCSR(matrix, block, begin, column, nullptr), "laying out");
  } else {
    check(MatMPIBAIJSetPreallocationCSR(matrix, block, begin, column, nullptr), "laying out");
    const PetscInt* columns = nullptr;
    Mat outside = nullptr;
    check(MatMPIBAIJGetSeqBAIJ(matrix, nullptr, &outside, &columns), "reading the matrix");
    PetscInt width = 0;
    check(MatGetSize(outside, nullptr, &width), "reading the matrix");
    remote_columns_.assign(columns, columns + width / block);
  }
  open(system_);
  if (beside == Beside::Kept) {
    check(MatDuplicate(matrix, MAT_DO_NOT_COPY_VALUES, &beside_.matrix), "copying the matrix");
    open(beside_);
  }
}

void BlockMatrix::open(BlockValues& values) {
  if (ranks() == 1) {
    open(values.matrix, values.local);
    return;
  }
  Mat inside = nullptr;
  Mat outside = nullptr;
  check(MatMPIBAIJGetSeqBAIJ(values.matrix, &inside, &outside, nullptr), "reading the matrix");
  open(inside, values.local);
  open(outside, values.remote);
}

void BlockMatrix::open(Mat part, BlockRows& rows) {
  PetscInt n = 0;
  PetscBool done = PETSC_FALSE;
  rows.matrix = part;
  check(MatGetRowIJ(part, 0, PETSC_FALSE, PETSC_TRUE, &n, &rows.begin, &rows.column, &done),
        "reading the pattern");
  ensure(done == PETSC_TRUE && n == layout_.own(), "PETSc shows {} block rows, not {}", n,
         layout_.own());
  check(MatSeqBAIJGetArray(part, &rows.values), "opening the matrix");
  check(MatSetOperation(part, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)),
        "giving the product");
}

void BlockMatrix::close(BlockValues& values) {
  for (BlockRows* rows : {&values.local, &values.remote}) {
    if (rows->matrix != nullptr) {
      PetscInt n = 0;
      PetscBool done = PETSC_FALSE;
      MatSeqBAIJRestoreArray(rows->matrix, &rows->values);
      MatRestoreRowIJ(rows->matrix, 0, PETSC_FALSE, PETSC_TRUE, &n, &rows->begin, &rows->column,
                      &done);
    }
  }
  MatDestroy(&values.matrix);
}

void BlockMatrix::list_slots(const ElementList& elements, int count) {
  diagonal_.resize(index(layout_.own()));
  for (int r = 0; r < layout_.own(); ++r) {
    diagonal_[index(r)] = system_.local.find(r, r);
  }
  first_slot_.reserve(index(count));
  for (int e = 0; e < count; ++e) {
    first_slot_.push_back(slots_.size());
    for (const int a : elements.of(e)) {
      const int row = row_of_node_[index(a)];
      for (const int b : elements.of(e)) {
        const int g = layout_.global[index(b)];
        if (row < 0) {
          slots_.push_back(-1);
        } else if (layout_.owns(b)) {
          slots_.push_back(system_.local.find(row, g - layout_.own_begin));
        } else {
          const auto at = std::ranges::lower_bound(remote_columns_, g) - remote_columns_.begin();
          slots_.push_back(-2 - system_.remote.find(row, static_cast<PetscInt>(at)));
        }
        if (row >= 0 && (fixed_[index(a)] | fixed_[index(b)]) != 0) {
          held_.push_back({slots_.back(), fixed_[index(a)], fixed_[index(b)]});
        }
      }
    }
  }
  std::ranges::sort(held_, {}, &HeldBlock::slot);
  const auto repeated = std::ranges::unique(held_, {}, &HeldBlock::slot);
  held_.erase(repeated.begin(), repeated.end());
}

void BlockMatrix::clear() {
  clear(system_);
  clear(beside_);
  summed_ = false;
}

void BlockMatrix::clear(BlockValues& values) const {
  for (const BlockRows* rows : {&values.local, &values.remote}) {
    if (rows->matrix != nullptr) {
      std::fill_n(rows->values, 16 * index(rows->begin[index(layout_.own())]), 0.0);
    }
  }
}

void BlockMatrix::add(BlockValues& to_values, int element, int pressures,
                      std::span<const double> values, RowPart part) {
  const int* nodes = nodes_.data() + offset_[index(element)];
  const int count = offset_[index(element) + 1] - offset_[index(element)];
  const int* slots = slots_.data() + first_slot_[index(element)];
  const int size = 3 * count + pressures;
  for (int a = 0; a < count; ++a) {
    const int row = row_of_node_[index(nodes[a])];
    if (row < part.begin || row >= part.end) {
      continue;
    }
    const double* moves = values.data() + static_cast<std::ptrdiff_t>(3 * a * size);
    const double* presses = values.data() + static_cast<std::ptrdiff_t>((3 * count + a) * size);
    for (int b = 0; b < count; ++b) {
      double* to = slot(to_values, slots[a * count + b]);
      for (int k = 0; k < 3; ++k) {
        to[4 * k] += moves[3 * b + k];
        to[4 * k + 1] += moves[size + 3 * b + k];
        to[4 * k + 2] += moves[2 * size + 3 * b + k];
      }
      if (b < pressures) {
        to[12] += moves[3 * count + b];
        to[13] += moves[size + 3 * count + b];
        to[14] += moves[2 * size + 3 * count + b];
      }
      if (a < pressures) {
        for (int k = 0; k < 3; ++k) {
          to[4 * k + 3] += presses[3 * b + k];
        }
        to[15] += b < pressures ? presses[3 * count + b] : 0.0;
      }
    }
  }
}

void BlockMatrix::add_blocks(int element, std::span<const double> blocks, RowPart part) {
  const int* nodes = nodes_.data() + offset_[index(element)];
  const int count = offset_[index(element) + 1] - offset_[index(element)];
  const int* slots = slots_.data() + first_slot_[index(element)];
  for (int a = 0; a < count; ++a) {
    const int row = row_of_node_[index(nodes[a])];
    if (row < part.begin || row >= part.end) {
      continue;
    }
    for (int b = 0; b < count; ++b) {
      double* to = slot(system_, slots[a * count + b]);
      const double* from = blocks.data() + static_cast<std::ptrdiff_t>(16 * (a * count + b));
      for (int i = 0; i < 16; ++i) {
        to[i] += from[i];
      }
    }
  }
}

void BlockMatrix::add_for_factors(int row, double value) {
  BlockValues& to = beside_.matrix != nullptr ? beside_ : system_;
  to.local.values[16 * diagonal_[index(row)] + 15] += value;
}

void BlockMatrix::finish() {
  finish(system_, 1.0);
  if (beside_.matrix != nullptr) {
    finish(beside_, 0.0);
  }
}

void BlockMatrix::finish(BlockValues& values, double held_diagonal) {
  for (const HeldBlock& held : held_) {
    double* entries = slot(values, held.slot);
    for (int k = 0; k < block; ++k) {
      for (int i = 0; i < block; ++i) {
        if ((held.rows >> i & 1) != 0 || (held.columns >> k & 1) != 0) {
          entries[4 * k + i] = 0.0;
        }
      }
    }
  }
  for (std::size_t n = 0; n < fixed_.size(); ++n) {
    if (const int row = row_of_node_[n]; row >= 0) {
      for (int i = 0; i < block; ++i) {
        if ((fixed_[n] >> i & 1) != 0) {
          values.local.values[16 * diagonal_[index(row)] + 5 * i] = held_diagonal;
        }
      }
    }
  }
  check(MatAssemblyBegin(values.matrix, MAT_FINAL_ASSEMBLY), "closing the matrix");
  check(MatAssemblyEnd(values.matrix, MAT_FINAL_ASSEMBLY), "closing the matrix");
}

Mat BlockMatrix::for_factors() {
  if (beside_.matrix == nullptr) {
    return system_.matrix;
  }
  if (!summed_) {
    check(MatAXPY(beside_.matrix, 1.0, system_.matrix, SAME_NONZERO_PATTERN), "adding matrices");
    summed_ = true;
  }
  return beside_.matrix;
}

}  // namespace sanatrix::fem
