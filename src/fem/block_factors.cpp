#include "fem/block_factors.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "fem/four.hpp"

namespace sanatrix::fem {

namespace {

using Block = std::array<double, 16>;

std::size_t index(PetscInt i) {
  return static_cast<std::size_t>(i);
}

/// By Gauss and Jordan with pivots; not finite where there is no inverse.
bool invert(Block& A) {
  Block inverse{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const auto swap_rows = [&](std::size_t a, std::size_t b) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::swap(A[4 * k + a], A[4 * k + b]);
      std::swap(inverse[4 * k + a], inverse[4 * k + b]);
    }
  };
  for (std::size_t p = 0; p < 4; ++p) {
    std::size_t best = p;
    for (std::size_t i = p + 1; i < 4; ++i) {
      best = std::abs(A[4 * p + i]) > std::abs(A[4 * p + best]) ? i : best;
    }
    if (best != p) {
      swap_rows(p, best);
    }
    const double scale = 1.0 / A[4 * p + p];
    for (std::size_t k = 0; k < 4; ++k) {
      A[4 * k + p] *= scale;
      inverse[4 * k + p] *= scale;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const double factor = i == p ? 0.0 : A[4 * p + i];
      for (std::size_t k = 0; k < 4; ++k) {
        A[4 * k + i] -= factor * A[4 * k + p];
        inverse[4 * k + i] -= factor * inverse[4 * k + p];
      }
    }
  }
  A = inverse;
  return std::ranges::all_of(inverse, [](double x) { return std::isfinite(x); });
}

/// The blocks of a range of rows that lie in its columns, both counted from its begin.
struct Graph {
  std::vector<PetscInt> begin{0}, column, slot;  ///< slot: where the block's values are
  Graph(const BlockRows& rows, int first, int end) {
    for (int r = first; r < end; ++r) {
      for (PetscInt b = rows.begin[r]; b < rows.begin[r + 1]; ++b) {
        if (rows.column[b] >= first && rows.column[b] < end) {
          column.push_back(rows.column[b] - first);
          slot.push_back(b);
        }
      }
      begin.push_back(static_cast<PetscInt>(column.size()));
    }
  }
  [[nodiscard]] PetscInt size() const { return static_cast<PetscInt>(begin.size()) - 1; }
  [[nodiscard]] PetscInt degree(PetscInt r) const { return begin[index(r) + 1] - begin[index(r)]; }
};

/// Appends the rows connected with `root`, nearest first, rows of few neighbours before others.
void append_by_distance(const Graph& graph, PetscInt root, std::vector<bool>& seen,
                        std::vector<PetscInt>& order) {
  std::size_t next = order.size();
  order.push_back(root);
  seen[index(root)] = true;
  for (; next < order.size(); ++next) {
    const auto first_new = static_cast<std::ptrdiff_t>(order.size());
    const std::size_t row = index(order[next]);
    for (PetscInt b = graph.begin[row]; b < graph.begin[row + 1]; ++b) {
      const PetscInt neighbour = graph.column[index(b)];
      if (!seen[index(neighbour)]) {
        seen[index(neighbour)] = true;
        order.push_back(neighbour);
      }
    }
    std::stable_sort(order.begin() + first_new, order.end(),
                     [&](PetscInt a, PetscInt b) { return graph.degree(a) < graph.degree(b); });
  }
}

/// Reverse Cuthill-McKee: the order in which factors lose least (doi:10.1145/800195.805928).
std::vector<PetscInt> cuthill_mckee(const Graph& graph) {
  std::vector<PetscInt> order;
  std::vector<bool> seen(index(graph.size()), false);
  for (PetscInt r = 0; r < graph.size(); ++r) {
    if (seen[index(r)]) {
      continue;
    }
    // The farthest from anywhere is at an end of its component.
    std::vector<bool> looked = seen;
    std::vector<PetscInt> component;
    append_by_distance(graph, r, looked, component);
    append_by_distance(graph, component.back(), seen, order);
  }
  std::ranges::reverse(order);
  return order;
}

}  // namespace

/// Blocks of one triangle, row after row in the order in which solving reads them: memory is read
/// in one direction, which is what its cost hangs on.
struct Triangle {
  std::vector<PetscInt> begin{0}, column, slot;  ///< slot: of the matrix, -1 for fill
  std::vector<AlignedBlock> block;

  void add(PetscInt c, PetscInt s) {
    column.push_back(c);
    slot.push_back(s);
  }
  void end_row() { begin.push_back(static_cast<PetscInt>(column.size())); }
  [[nodiscard]] std::size_t first(std::size_t row) const { return index(begin[row]); }
  [[nodiscard]] std::size_t end(std::size_t row) const { return index(begin[row + 1]); }
};

/// One half: its order of rows, and factors by rows of that order.
class BlockFactors::Half {
 public:
  Half(const BlockRows& rows, int first, int end)
      : first_(first), graph_(rows, first, end), order_(cuthill_mckee(graph_)) {
    place_.resize(order_.size());
    for (std::size_t p = 0; p < order_.size(); ++p) {
      place_[index(order_[p])] = static_cast<PetscInt>(p);
    }
    at_.assign(order_.size(), nullptr);
    work_.resize(4 * order_.size());
  }

  bool update(const double* values, int levels);
  void apply(const double* r, double* z);

 private:
  struct Entry {
    PetscInt column, slot;
    int level;
  };
  [[nodiscard]] std::vector<std::vector<Entry>> filled(int levels) const;
  void make_pattern(int levels);
  bool eliminate(std::size_t row, const double* values);
  /// Where U has a row: the last one first.
  [[nodiscard]] std::size_t from_end(std::size_t row) const { return order_.size() - 1 - row; }

  int first_;
  Graph graph_;
  std::vector<PetscInt> order_, place_;  ///< row by place, and place by row
  int levels_ = -1;                      ///< of the pattern
  // Columns are places, ascending in a row. A row of U begins with its diagonal block, inverted.
  Triangle lower_, upper_;
  std::vector<Block> row_;  ///< the one that is eliminated
  std::vector<Block*> at_;  ///< its blocks by column, or nullptr
  std::vector<double> work_;
};

/// A block fills in where eliminating one of lower column produces it, one level above the two
/// that produce it.
std::vector<std::vector<BlockFactors::Half::Entry>> BlockFactors::Half::filled(int levels) const {
  std::vector<std::vector<Entry>> rows(order_.size());
  std::vector<int> level_at(order_.size(), levels + 1);
  for (std::size_t p = 0; p < rows.size(); ++p) {
    std::vector<Entry>& row = rows[p];
    const std::size_t r = index(order_[p]);
    for (PetscInt b = graph_.begin[r]; b < graph_.begin[r + 1]; ++b) {
      row.push_back({place_[index(graph_.column[index(b)])], graph_.slot[index(b)], 0});
      level_at[index(row.back().column)] = 0;
    }
    std::ranges::sort(row, {}, &Entry::column);
    for (std::size_t k = 0; index(row[k].column) < p; ++k) {
      const Entry pivot = row[k];
      for (const Entry& above : rows[index(pivot.column)]) {
        const int level = pivot.level + above.level + 1;
        int& known = level_at[index(above.column)];
        if (above.column <= pivot.column || level >= known) {
          continue;
        }
        const auto at = std::ranges::lower_bound(row, above.column, {}, &Entry::column);
        if (known > levels) {
          row.insert(at, {above.column, -1, level});
        } else {
          at->level = level;
        }
        known = level;
      }
    }
    for (const Entry& entry : row) {
      level_at[index(entry.column)] = levels + 1;
    }
  }
  return rows;
}

void BlockFactors::Half::make_pattern(int levels) {
  levels_ = levels;
  const std::vector<std::vector<Entry>> rows = filled(levels);
  lower_ = {};
  upper_ = {};
  for (std::size_t p = 0; p < rows.size(); ++p) {
    for (const Entry& entry : rows[p]) {
      if (index(entry.column) < p) {
        lower_.add(entry.column, entry.slot);
      }
    }
    lower_.end_row();
  }
  for (std::size_t p = rows.size(); p-- > 0;) {
    for (const Entry& entry : rows[p]) {
      if (index(entry.column) >= p) {
        upper_.add(entry.column, entry.slot);
      }
    }
    upper_.end_row();
  }
  lower_.block.resize(lower_.column.size());
  upper_.block.resize(upper_.column.size());
}

bool BlockFactors::Half::update(const double* values, int levels) {
  if (levels != levels_) {
    make_pattern(levels);
  }
  for (std::size_t row = 0; row < order_.size(); ++row) {
    if (!eliminate(row, values)) {
      return false;
    }
  }
  return true;
}

bool BlockFactors::Half::eliminate(std::size_t row, const double* values) {
  const std::size_t low = lower_.first(row);
  const std::size_t up = upper_.first(from_end(row));
  const std::size_t left = lower_.end(row) - low;
  const std::size_t size = left + upper_.end(from_end(row)) - up;
  row_.assign(size, Block{});
  const auto column_of = [&](std::size_t b) {
    return index(b < left ? lower_.column[low + b] : upper_.column[up + b - left]);
  };
  for (std::size_t b = 0; b < size; ++b) {
    at_[column_of(b)] = &row_[b];
    if (const PetscInt slot = b < left ? lower_.slot[low + b] : upper_.slot[up + b - left];
        slot >= 0) {
      std::copy_n(values + 16 * index(slot), 16, row_[b].begin());
    }
  }
  for (std::size_t b = 0; b < left; ++b) {
    const std::size_t pivot = from_end(column_of(b));
    const AlignedBlock& D = upper_.block[upper_.first(pivot)];
    Block L;
    for (std::size_t k = 0; k < 4; ++k) {
      four(L.data() + 4 * k) = product(row_[b].data(), column(D, k));
    }
    row_[b] = L;
    for (std::size_t u = upper_.first(pivot) + 1; u < upper_.end(pivot); ++u) {
      if (Block* changed = at_[index(upper_.column[u])]; changed != nullptr) {
        for (std::size_t k = 0; k < 4; ++k) {
          four(changed->data() + 4 * k) -= product(L.data(), column(upper_.block[u], k));
        }
      }
    }
  }
  const bool good = invert(row_[left]);
  for (std::size_t b = 0; b < size; ++b) {
    at_[column_of(b)] = nullptr;
    (b < left ? lower_.block[low + b] : upper_.block[up + b - left]) = {row_[b]};
  }
  return good;
}

void BlockFactors::Half::apply(const double* r, double* z) {
  const std::size_t n = order_.size();
  double* y = work_.data();
  const auto less = [&](Four sum, const Triangle& side, std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      sum -= product(side.block[b], y + 4 * index(side.column[b]));
    }
    return sum;
  };
  for (std::size_t p = 0; p < n; ++p) {
    const Four right = four(r + 4 * (index(first_) + index(order_[p])));
    four(y + 4 * p) = less(right, lower_, lower_.first(p), lower_.end(p));
  }
  for (std::size_t q = 0; q < n; ++q) {
    const std::size_t p = from_end(q);
    const std::size_t diagonal = upper_.first(q);
    const Four left = less(four(y + 4 * p), upper_, diagonal + 1, upper_.end(q));
    const Four solved = product(upper_.block[diagonal], left);
    four(y + 4 * p) = four(z + 4 * (index(first_) + index(order_[p]))) = solved;
  }
}

BlockFactors::BlockFactors(const BlockRows& pattern, int rows) {
  halves_.emplace_back(pattern, 0, rows / 2);
  halves_.emplace_back(pattern, rows / 2, rows);
}

BlockFactors::~BlockFactors() = default;

bool BlockFactors::update(const BlockRows& values, int levels_of_fill) {
  std::array<bool, 2> good{};
  side_by_side(
      2, [&](int h) { good[index(h)] = halves_[index(h)].update(values.values, levels_of_fill); });
  return good[0] && good[1];
}

void BlockFactors::apply(const double* r, double* z) {
  side_by_side(2, [&](int h) { halves_[index(h)].apply(r, z); });
}

}  // namespace sanatrix::fem
