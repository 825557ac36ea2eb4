#include "fem/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/parallel.hpp"
#include "fem/petsc_check.hpp"

namespace sanatrix::fem {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// What is left of a mode after the earlier ones, relative to its size, for it to count.
constexpr double independent = 1e-6;

/// An unknown's modes are [first_mode(unknown), first_mode(unknown + 1)).
constexpr int first_mode(int unknown) {
  return unknown < block ? 4 * unknown : CoarseSpace::modes;
}

}  // namespace

CoarseSpace::CoarseSpace(const Layout& layout, const BlockMatrix& fine,
                         std::span<const std::uint8_t> fixed, std::span<const Vec3> positions)
    : layout_(layout), fine_(fine) {
  groups_ = layout.own() == 0 ? 0 : std::max(1, layout.own() / group_size);
  MPI_Exscan(&groups_, &first_group_, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(&groups_, &all_groups_, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  make_modes(fixed, positions);
  fetch_remote_modes();
  make_interpolation();
  make_coarse_pattern();
}

CoarseSpace::~CoarseSpace() {
  MatDestroy(&interpolation_);
  MatDestroy(&coarse_);
}

int CoarseSpace::first_row(int group) const {
  return static_cast<int>(static_cast<long>(group) * layout_.own() / std::max(groups_, 1));
}

/// Modes [first, end) on the rows, orthonormal; what depends on earlier ones (a group of few or
/// mostly held nodes) becomes zero.
void CoarseSpace::make_orthonormal(std::span<NodeModes> rows, int first, int end) {
  const auto product = [&](int a, int b) {
    double sum = 0.0;
    for (const NodeModes& row : rows) {
      sum += row.value[index(a)] * row.value[index(b)];
    }
    return sum;
  };
  for (int m = first; m < end; ++m) {
    const double before = product(m, m);
    for (int earlier = first; earlier < m; ++earlier) {
      const double share = product(m, earlier);
      for (NodeModes& row : rows) {
        row.value[index(m)] -= share * row.value[index(earlier)];
      }
    }
    const double left = product(m, m);
    const double scale = left > independent * before ? 1.0 / std::sqrt(left) : 0.0;
    for (NodeModes& row : rows) {
      row.value[index(m)] *= scale;
    }
  }
}

/// Affine functions of the free unknowns, orthonormal within each group.
void CoarseSpace::make_modes(std::span<const std::uint8_t> fixed, std::span<const Vec3> positions) {
  std::vector<std::size_t> node_of_row(index(layout_.own()));
  for (std::size_t n = 0; n < layout_.global.size(); ++n) {
    if (layout_.owns(static_cast<int>(n))) {
      node_of_row[index(layout_.global[n] - layout_.own_begin)] = n;
    }
  }
  own_.resize(node_of_row.size());
  for (int g = 0; g < groups_; ++g) {
    const auto rows =
        std::span(own_).subspan(index(first_row(g)), index(first_row(g + 1) - first_row(g)));
    const auto nodes = std::span(node_of_row).subspan(index(first_row(g)), rows.size());
    Vec3 centre{};
    for (const std::size_t n : nodes) {
      centre += (1.0 / static_cast<double>(nodes.size())) * positions[n];
    }
    double radius = 0.0;
    for (const std::size_t n : nodes) {
      radius = std::max(radius, norm(positions[n] - centre));
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Vec3 x = (radius > 0.0 ? 1.0 / radius : 0.0) * (positions[nodes[r]] - centre);
      rows[r].group = first_group_ + g;
      const std::array<double, 4> functions{1.0, x[0], x[1], x[2]};
      for (int i = 0; i < block; ++i) {
        for (int m = first_mode(i); m < first_mode(i + 1); ++m) {
          const bool is_free = (fixed[nodes[r]] >> i & 1) == 0;
          rows[r].value[index(m)] = is_free ? functions[index(m - first_mode(i))] : 0.0;
        }
      }
    }
    for (int i = 0; i < block; ++i) {
      make_orthonormal(rows, first_mode(i), first_mode(i + 1));
    }
  }
}

void CoarseSpace::fetch_remote_modes() {
  const auto& columns = fine_.remote_columns();
  remote_.resize(columns.size());
  Vec own = nullptr;
  Vec remote = nullptr;
  const auto own_size = packed * layout_.own();
  const auto remote_size = packed * static_cast<PetscInt>(columns.size());
  check(VecCreateMPI(PETSC_COMM_WORLD, own_size, PETSC_DETERMINE, &own), "packing modes");
  check(VecCreateSeq(PETSC_COMM_SELF, remote_size, &remote), "packing modes");
  double* values = nullptr;
  check(VecGetArray(own, &values), "packing modes");
  for (const NodeModes& row : own_) {
    *values++ = row.group;
    values = std::ranges::copy(row.value, values).out;
  }
  values -= own_size;
  check(VecRestoreArray(own, &values), "packing modes");
  IS wanted = nullptr;
  VecScatter scatter = nullptr;
  check(ISCreateBlock(PETSC_COMM_SELF, packed, static_cast<PetscInt>(columns.size()),
                      columns.data(), PETSC_COPY_VALUES, &wanted),
        "fetching modes");
  check(VecScatterCreate(own, wanted, remote, nullptr, &scatter), "fetching modes");
  check(VecScatterBegin(scatter, own, remote, INSERT_VALUES, SCATTER_FORWARD), "fetching modes");
  check(VecScatterEnd(scatter, own, remote, INSERT_VALUES, SCATTER_FORWARD), "fetching modes");
  const double* got = nullptr;
  check(VecGetArrayRead(remote, &got), "fetching modes");
  const double* at = got;
  for (NodeModes& node : remote_) {
    node.group = *at++;
    std::copy_n(at, modes, node.value.begin());
    at += modes;
  }
  check(VecRestoreArrayRead(remote, &got), "fetching modes");
  VecScatterDestroy(&scatter);
  ISDestroy(&wanted);
  VecDestroy(&own);
  VecDestroy(&remote);
}

void CoarseSpace::make_interpolation() {
  check(
      MatCreateAIJ(PETSC_COMM_WORLD, block * layout_.own(), modes * groups_, block * layout_.total,
                   modes * all_groups_, first_mode(1), nullptr, 0, nullptr, &interpolation_),
      "creating the interpolation");
  for (int r = 0; r < layout_.own(); ++r) {
    const NodeModes& node = own_[index(r)];
    for (int i = 0; i < block; ++i) {
      const PetscInt row = block * (layout_.own_begin + r) + i;
      for (int m = first_mode(i); m < first_mode(i + 1); ++m) {
        const PetscInt column = modes * static_cast<PetscInt>(node.group) + m;
        check(MatSetValue(interpolation_, row, column, node.value[index(m)], INSERT_VALUES),
              "filling the interpolation");
      }
    }
  }
  check(MatAssemblyBegin(interpolation_, MAT_FINAL_ASSEMBLY), "filling the interpolation");
  check(MatAssemblyEnd(interpolation_, MAT_FINAL_ASSEMBLY), "filling the interpolation");
}

void CoarseSpace::make_coarse_pattern() {
  for (int g = 0; g < groups_; ++g) {
    std::set<PetscInt> neighbours{static_cast<PetscInt>(first_group_ + g)};
    for (int r = first_row(g); r < first_row(g + 1); ++r) {
      for (PetscInt b = fine_.local().begin[r]; b < fine_.local().begin[r + 1]; ++b) {
        neighbours.insert(static_cast<PetscInt>(own_[index(fine_.local().column[b])].group));
      }
      if (fine_.remote().matrix != nullptr) {
        for (PetscInt b = fine_.remote().begin[r]; b < fine_.remote().begin[r + 1]; ++b) {
          neighbours.insert(static_cast<PetscInt>(remote_[index(fine_.remote().column[b])].group));
        }
      }
    }
    column_.insert(column_.end(), neighbours.begin(), neighbours.end());
    begin_.push_back(static_cast<PetscInt>(column_.size()));
  }
  values_.resize(column_.size() * modes * modes);
  std::vector<PetscInt> row_begin{0};
  std::vector<PetscInt> columns;
  for (int g = 0; g < groups_; ++g) {
    for (int m = 0; m < modes; ++m) {
      for (PetscInt k = begin_[index(g)]; k < begin_[index(g + 1)]; ++k) {
        for (int n = 0; n < modes; ++n) {
          columns.push_back(modes * column_[index(k)] + n);
        }
      }
      row_begin.push_back(static_cast<PetscInt>(columns.size()));
    }
  }
  const PetscInt own = modes * groups_;
  const PetscInt all = modes * all_groups_;
  check(MatCreate(PETSC_COMM_WORLD, &coarse_), "creating the coarse matrix");
  check(MatSetSizes(coarse_, own, own, all, all), "sizing the coarse matrix");
  check(MatSetType(coarse_, MATAIJ), "typing the coarse matrix");
  check(MatSeqAIJSetPreallocationCSR(coarse_, row_begin.data(), columns.data(), nullptr),
        "laying out the coarse matrix");
  check(MatMPIAIJSetPreallocationCSR(coarse_, row_begin.data(), columns.data(), nullptr),
        "laying out the coarse matrix");
}

std::size_t CoarseSpace::coarse_place(int group, double neighbour) const {
  const auto first = column_.begin() + begin_[index(group)];
  const auto last = column_.begin() + begin_[index(group + 1)];
  const auto at = std::lower_bound(first, last, static_cast<PetscInt>(neighbour));
  return static_cast<std::size_t>(at - column_.begin()) * modes * modes;
}

/// sum += Q_row^T A Q_column
void CoarseSpace::add_block(const NodeModes& row, const NodeModes& column, const double* block_of,
                            double* sum) {
  for (int i = 0; i < block; ++i) {
    std::array<double, modes> AQ{};  // its row i
    for (int k = 0; k < block; ++k) {
      for (int m = first_mode(k); m < first_mode(k + 1); ++m) {
        AQ[index(m)] = block_of[block * k + i] * column.value[index(m)];
      }
    }
    for (int m = first_mode(i); m < first_mode(i + 1); ++m) {
      for (int n = 0; n < modes; ++n) {
        sum[modes * m + n] += row.value[index(m)] * AQ[index(n)];
      }
    }
  }
}

void CoarseSpace::update() {
  std::ranges::fill(values_, 0.0);
  side_by_side(groups_, [&](int g) {
    for (int r = first_row(g); r < first_row(g + 1); ++r) {
      const auto add_all = [&](const BlockRows& rows, const std::vector<NodeModes>& columns) {
        for (PetscInt b = rows.begin[r]; b < rows.begin[r + 1]; ++b) {
          const NodeModes& column = columns[index(rows.column[b])];
          add_block(own_[index(r)], column, rows.values + 16 * b,
                    values_.data() + coarse_place(g, column.group));
        }
      };
      add_all(fine_.local(), own_);
      if (fine_.remote().matrix != nullptr) {
        add_all(fine_.remote(), remote_);
      }
    }
    double* own_block = values_.data() + coarse_place(g, first_group_ + g);
    for (std::size_t m = 0; m < modes; ++m) {  // a mode without a node answers for itself
      double& diagonal = own_block[modes * m + m];
      diagonal = diagonal == 0.0 ? 1.0 : diagonal;
    }
  });
  std::array<PetscInt, modes> rows{};
  std::array<PetscInt, modes> columns{};
  for (int g = 0; g < groups_; ++g) {
    for (PetscInt k = begin_[index(g)]; k < begin_[index(g + 1)]; ++k) {
      for (int m = 0; m < modes; ++m) {
        rows[index(m)] = modes * (first_group_ + g) + m;
        columns[index(m)] = modes * column_[index(k)] + m;
      }
      check(MatSetValues(coarse_, modes, rows.data(), modes, columns.data(),
                         values_.data() + index(k) * modes * modes, INSERT_VALUES),
            "filling the coarse matrix");
    }
  }
  check(MatAssemblyBegin(coarse_, MAT_FINAL_ASSEMBLY), "filling the coarse matrix");
  check(MatAssemblyEnd(coarse_, MAT_FINAL_ASSEMBLY), "filling the coarse matrix");
}

}  // namespace sanatrix::fem
