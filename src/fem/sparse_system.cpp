#include "fem/sparse_system.hpp"

#include <algorithm>

#include <petscksp.h>

#include "fem/block_factors.hpp"
#include "fem/block_matrix.hpp"
#include "fem/coarse_space.hpp"
#include "fem/petsc_check.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {

namespace {

/// Krylov iterations after which a kept factorisation is no longer worth keeping.
constexpr int slow_solve = 14;
constexpr int max_direct_iterations = 60;
constexpr int max_iterations = 200;
/// Of factors with fill that are stable: more are a sign that they are not.
constexpr int max_with_fill = 60;
/// Below this many unknowns a factorisation costs next to nothing.
constexpr int small_system = 3000;
/// Above this many unknowns a factorisation takes more memory than a workstation has to spare (7
/// GiB at 200 thousand, 14 GiB and more at 600 thousand); smaller load steps may do without it.
constexpr int large_system = 300'000;

}  // namespace

void ElementList::add(std::span<const int> element_nodes) {
  nodes.insert(nodes.end(), element_nodes.begin(), element_nodes.end());
  offset.push_back(static_cast<int>(nodes.size()));
}

struct SparseSystem::Impl {
  Layout layout;
  std::vector<int> offset, nodes;
  std::vector<std::uint8_t> fixed;
  std::vector<std::size_t> node_of_row;
  std::vector<int> row_of_node;
  std::vector<double> sum;
  BlockMatrix matrix;
  std::unique_ptr<BlockMatrix> narrow;
  BlockFactors factors;
  CoarseSpace coarse;
  bool factors_stale = true;
  int fill = 0;  ///< levels of fill of the incomplete factors
  Smoothed smoothed = Smoothed::System;
  Vec rhs = nullptr, solution = nullptr, here = nullptr;
  VecScatter gather = nullptr;
  KSP two_level = nullptr, direct = nullptr;

  Impl(const Layout& l, const ElementList& elements, std::span<const std::uint8_t> held,
       std::span<const Vec3> positions, std::optional<int> narrow_elements);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// What the preconditioner is made of.
  BlockMatrix& preconditioned() { return narrow ? *narrow : matrix; }
  template <class Value>
  void add_to_vector(int element, RowPart part, const Value& value);
  void make_vectors();
  void make_two_level_solver();
  void make_direct_solver();
  void copy_in(std::span<const double> from, Vec to) const;
  void copy_out(Vec from, std::vector<double>& to) const;
  bool run(KSP solver, double relative_tolerance, int limit, int& iterations) const;
  bool prepare_levels(int levels_of_fill);
  bool solve_by_levels(double relative_tolerance, LinearReport& report);
  void solve_directly(double relative_tolerance, LinearReport& report);
};

SparseSystem::Impl::Impl(const Layout& l, const ElementList& elements,
                         std::span<const std::uint8_t> held, std::span<const Vec3> positions,
                         std::optional<int> narrow_elements)
    : layout(l),
      offset(elements.offset),
      nodes(elements.nodes),
      fixed(held.begin(), held.end()),
      node_of_row(static_cast<std::size_t>(l.own())),
      row_of_node(l.global.size(), -1),
      sum(block * l.global.size()),
      matrix(layout, elements, elements.size(), held,
             narrow_elements ? Beside::None : Beside::Kept),
      narrow(narrow_elements ? std::make_unique<BlockMatrix>(layout, elements, *narrow_elements,
                                                             held, Beside::None)
                             : nullptr),
      factors(preconditioned().local(), layout.own()),
      coarse(layout, preconditioned(), held, positions) {
  for (std::size_t n = 0; n < l.global.size(); ++n) {
    if (l.owns(static_cast<int>(n))) {
      row_of_node[n] = l.global[n] - l.own_begin;
      node_of_row[static_cast<std::size_t>(row_of_node[n])] = n;
    }
  }
  make_vectors();
  make_two_level_solver();
}

SparseSystem::Impl::~Impl() {
  KSPDestroy(&two_level);
  KSPDestroy(&direct);
  VecDestroy(&rhs);
  VecDestroy(&solution);
  VecDestroy(&here);
  VecScatterDestroy(&gather);
}

void SparseSystem::Impl::make_vectors() {
  check(MatCreateVecs(matrix.petsc(), &solution, &rhs), "creating vectors");
  const auto count = static_cast<PetscInt>(layout.global.size());
  const std::vector<PetscInt> globals(layout.global.begin(), layout.global.end());
  check(VecCreateSeq(PETSC_COMM_SELF, block * count, &here), "creating vectors");
  IS wanted = nullptr;
  check(ISCreateBlock(PETSC_COMM_SELF, block, count, globals.data(), PETSC_COPY_VALUES, &wanted),
        "indexing the nodes");
  check(VecScatterCreate(solution, wanted, here, nullptr, &gather), "creating the gather");
  check(ISDestroy(&wanted), "indexing the nodes");
}

/// The smoother of a preconditioner's level.
PetscErrorCode apply_factors(PC pc, Vec from, Vec to) {
  void* factors = nullptr;
  const PetscScalar* r = nullptr;
  PetscScalar* z = nullptr;
  check(PCShellGetContext(pc, &factors), "smoothing");
  check(VecGetArrayRead(from, &r), "smoothing");
  check(VecGetArrayWrite(to, &z), "smoothing");
  static_cast<BlockFactors*>(factors)->apply(r, z);
  check(VecRestoreArrayWrite(to, &z), "smoothing");
  check(VecRestoreArrayRead(from, &r), "smoothing");
  return 0;
}

/// V-cycle of two levels. Smoother: incomplete factors of each rank's node blocks; coarse level:
/// MUMPS.
void SparseSystem::Impl::make_two_level_solver() {
  check(KSPCreate(PETSC_COMM_WORLD, &two_level), "creating the linear solver");
  check(KSPSetType(two_level, KSPGMRES), "choosing GMRES");
  check(KSPSetPCSide(two_level, PC_RIGHT), "preconditioning from the right");
  check(KSPGMRESSetRestart(two_level, max_iterations), "setting the restart");
  check(KSPSetOptionsPrefix(two_level, "sanatrix_"), "naming the solver");
  PC pc = nullptr;
  check(KSPGetPC(two_level, &pc), "getting the preconditioner");
  check(PCSetType(pc, PCMG), "choosing two levels");
  check(PCMGSetLevels(pc, 2, nullptr), "choosing two levels");
  check(PCMGSetGalerkin(pc, PC_MG_GALERKIN_NONE), "choosing two levels");
  check(PCMGSetInterpolation(pc, 1, coarse.interpolation()), "giving the interpolation");
  for (const auto& [key, value] : {std::pair{"-sanatrix_mg_levels_ksp_type", "richardson"},
                                   {"-sanatrix_mg_levels_ksp_max_it", "1"},
                                   {"-sanatrix_mg_levels_pc_type", "shell"},
                                   {"-sanatrix_mg_coarse_ksp_type", "preonly"},
                                   {"-sanatrix_mg_coarse_pc_type", "lu"},
                                   {"-sanatrix_mg_coarse_pc_factor_mat_solver_type", "mumps"}}) {
    PetscBool given = PETSC_FALSE;
    check(PetscOptionsHasName(nullptr, nullptr, key, &given), "reading options");
    if (given == PETSC_FALSE) {
      check(PetscOptionsSetValue(nullptr, key, value), "setting options");
    }
  }
  check(KSPSetFromOptions(two_level), "reading options");
}

void SparseSystem::Impl::make_direct_solver() {
  check(KSPCreate(PETSC_COMM_WORLD, &direct), "creating the direct solver");
  check(KSPSetType(direct, KSPFGMRES), "choosing FGMRES");
  PC pc = nullptr;
  check(KSPGetPC(direct, &pc), "getting the preconditioner");
  check(PCSetType(pc, PCLU), "choosing MUMPS");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "choosing MUMPS");
}

void SparseSystem::Impl::copy_out(Vec from, std::vector<double>& to) const {
  check(VecScatterBegin(gather, from, here, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  check(VecScatterEnd(gather, from, here, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(here, &values), "reading a vector");
  to.assign(values, values + block * layout.global.size());
  check(VecRestoreArrayRead(here, &values), "reading a vector");
}

void SparseSystem::Impl::copy_in(std::span<const double> from, Vec to) const {
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(to, &values), "writing a vector");
  for (std::size_t r = 0; r < node_of_row.size(); ++r) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(block * node_of_row[r]), block,
                values + block * r);
  }
  check(VecRestoreArrayWrite(to, &values), "writing a vector");
}

bool SparseSystem::Impl::run(KSP solver, double relative_tolerance, int limit,
                             int& iterations) const {
  check(KSPSetTolerances(solver, relative_tolerance, PETSC_DEFAULT, 1e6, limit),
        "setting tolerances");
  const PetscErrorCode code = KSPSolve(solver, rhs, solution);
  if (code != 0) {  // a factorisation met a zero pivot or ran out of memory
    return false;
  }
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(solver, &reason), "solving");
  PetscInt n = 0;
  check(KSPGetIterationNumber(solver, &n), "solving");
  iterations += static_cast<int>(n);
  return reason > 0;
}

/// Makes the levels of the matrix of the moment. False where there are no such factors.
bool SparseSystem::Impl::prepare_levels(int levels_of_fill) {
  PC pc = nullptr;
  KSP smoother = nullptr;
  KSP bottom = nullptr;
  const Mat factored = preconditioned().for_factors();
  const bool whole = factors.update(preconditioned().local_for_factors(), levels_of_fill);
  if (largest(whole ? 0.0 : 1.0) > 0.0) {
    return false;
  }
  check(KSPGetPC(two_level, &pc), "getting the preconditioner");
  check(PCMGGetSmoother(pc, 1, &smoother), "getting the smoother");
  check(PCMGGetCoarseSolve(pc, &bottom), "getting the coarse solver");
  const Mat seen = smoothed == Smoothed::System ? preconditioned().petsc() : factored;
  check(KSPSetOperators(smoother, seen, seen), "setting the matrix");
  coarse.update();
  check(KSPSetOperators(bottom, coarse.matrix(), coarse.matrix()), "setting the coarse matrix");
  check(KSPSetOperators(two_level, matrix.petsc(), matrix.petsc()), "setting the matrix");
  check(KSPSetUp(two_level), "setting up the levels");
  check(KSPGetPC(smoother, &pc), "getting the smoother");
  check(PCShellSetContext(pc, &factors), "giving the factors");
  check(PCShellSetApply(pc, apply_factors), "giving the factors");
  return true;
}

bool SparseSystem::Impl::solve_by_levels(double relative_tolerance, LinearReport& report) {
  // Factors that a failure of the levels forced are used up before the levels are tried again.
  if (block * layout.total < small_system || (direct != nullptr && !factors_stale)) {
    return false;
  }
  const auto attempt = [&](int levels_of_fill) {
    int iterations = 0;
    report.converged = prepare_levels(levels_of_fill) &&
                       run(two_level, relative_tolerance,
                           levels_of_fill > 0 ? max_with_fill : max_iterations, iterations);
    report.iterations += iterations;
    return report.converged;
  };
  // Factors may happen to be unstable with fill where they are not without.
  return attempt(fill) || (fill > 0 && attempt(0));
}

void SparseSystem::Impl::solve_directly(double relative_tolerance, LinearReport& report) {
  if (direct == nullptr) {
    make_direct_solver();
  }
  for (int attempt = 0; attempt < 2 && !report.converged; ++attempt) {
    const bool fresh = factors_stale;
    check(KSPSetReusePreconditioner(direct, fresh ? PETSC_FALSE : PETSC_TRUE), "keeping factors");
    check(KSPSetOperators(direct, matrix.petsc(), matrix.petsc()), "setting the matrix");
    report.factorised = report.factorised || fresh;
    int iterations = 0;
    report.converged = run(direct, relative_tolerance, max_direct_iterations, iterations);
    report.iterations += iterations;
    factors_stale = !report.converged || iterations > slow_solve;
    if (fresh) {
      factors_stale = !report.converged;
      break;  // trying again would change nothing
    }
  }
}

SparseSystem::SparseSystem(const Layout& layout, const ElementList& elements,
                           std::span<const std::uint8_t> fixed, std::span<const Vec3> positions,
                           std::optional<int> narrow)
    : impl_(std::make_unique<Impl>(layout, elements, fixed, positions, narrow)) {}

SparseSystem::~SparseSystem() = default;

void SparseSystem::clear(bool with_matrix) {
  std::ranges::fill(impl_->sum, 0.0);
  if (with_matrix) {
    impl_->matrix.clear();
    if (impl_->narrow) {
      impl_->narrow->clear();
    }
  }
}

RowPart SparseSystem::part(int part, int parts) const {
  const auto own = static_cast<long>(impl_->layout.own());
  return {static_cast<int>(own * part / parts), static_cast<int>(own * (part + 1) / parts)};
}

/// Adds value(a, i) to unknown i of the element's node a, where that is free and in the part.
template <class Value>
void SparseSystem::Impl::add_to_vector(int element, RowPart part, const Value& value) {
  const auto e = static_cast<std::size_t>(element);
  const auto first = static_cast<std::size_t>(offset[e]);
  const auto count = static_cast<std::size_t>(offset[e + 1]) - first;
  for (std::size_t a = 0; a < count; ++a) {
    const auto node = static_cast<std::size_t>(nodes[first + a]);
    const int row = row_of_node[node];
    if (row < part.begin || row >= part.end) {
      continue;
    }
    for (std::size_t i = 0; i < block; ++i) {
      sum[block * node + i] += (fixed[node] >> i & 1) != 0 ? 0.0 : value(a, i);
    }
  }
}

void SparseSystem::add(int element, int pressures, std::span<const double> vector,
                       std::span<const double> matrix, RowPart part) {
  const std::size_t with_pressure = static_cast<std::size_t>(pressures);
  const std::size_t first_pressure = vector.size() - with_pressure;
  impl_->add_to_vector(element, part, [&](std::size_t a, std::size_t i) {
    return i < 3 ? vector[3 * a + i] : a < with_pressure ? vector[first_pressure + a] : 0.0;
  });
  if (!matrix.empty()) {
    impl_->matrix.add(element, pressures, matrix, part);
  }
}

void SparseSystem::add_blocks(int element, std::span<const double> vector,
                              std::span<const double> blocks, RowPart part) {
  impl_->add_to_vector(element, part,
                       [&](std::size_t a, std::size_t i) { return vector[block * a + i]; });
  if (!blocks.empty()) {
    impl_->matrix.add_blocks(element, blocks, part);
  }
}

void SparseSystem::add_for_factors(int element, int pressures, std::span<const double> matrix,
                                   RowPart part) {
  if (impl_->narrow) {
    impl_->narrow->add(element, pressures, matrix, part);
  } else {
    impl_->matrix.add_for_factors(element, pressures, matrix, part);
  }
}

void SparseSystem::add_for_factors(std::span<const double> pressure_diagonal) {
  for (std::size_t r = 0; r < impl_->node_of_row.size(); ++r) {
    impl_->preconditioned().add_for_factors(static_cast<int>(r),
                                            pressure_diagonal[impl_->node_of_row[r]]);
  }
}

void SparseSystem::finish_matrix() {
  impl_->matrix.finish();
  if (impl_->narrow) {
    impl_->narrow->finish();
  }
}

const std::vector<double>& SparseSystem::vector() const {
  return impl_->sum;
}

void SparseSystem::set_smoothed(Smoothed smoothed) {
  impl_->smoothed = smoothed;
}

void SparseSystem::set_fill(int levels) {
  impl_->fill = levels;
}

LinearReport SparseSystem::solve(std::span<const double> b, double relative_tolerance,
                                 std::vector<double>& x) {
  impl_->copy_in(b, impl_->rhs);
  LinearReport report;
  const bool affordable = block * impl_->layout.total <= large_system;
  if (!impl_->solve_by_levels(relative_tolerance, report) && affordable) {
    impl_->solve_directly(relative_tolerance, report);
  }
  impl_->copy_out(impl_->solution, x);
  return report;
}

void SparseSystem::forget_factorisation() {
  impl_->factors_stale = true;
}

}  // namespace sanatrix::fem
