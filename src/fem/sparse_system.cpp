#include "fem/sparse_system.hpp"

#include <algorithm>

#include <petscksp.h>

#include "core/error.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {

namespace {

void check(PetscErrorCode code, const char* doing) {
  if (code != 0) {
    const char* text = nullptr;
    PetscErrorMessage(code, &text, nullptr);
    throw Error(Fault::Internal, fmt::format("PETSc failed while {}: {}", doing,
                                             text != nullptr ? text : "unknown error"));
  }
}

/// Krylov iterations after which a kept factorisation is no longer worth keeping.
constexpr int slow_solve = 14;
constexpr int max_direct_iterations = 60;
constexpr int max_block_iterations = 400;
/// Below this many unknowns a factorisation costs next to nothing.
constexpr int small_system = 3000;

}  // namespace

void ElementList::add(std::span<const int> element_dofs) {
  dofs.insert(dofs.end(), element_dofs.begin(), element_dofs.end());
  offset.push_back(static_cast<int>(dofs.size()));
}

struct SparseSystem::Impl {
  std::vector<int> offset;
  std::vector<std::size_t> matrix_offset;
  std::vector<double> matrix_values, vector_values;
  std::vector<bool> is_pressure;
  std::size_t fixed_owned = 0;
  int dofs = 0;
  bool factors_stale = true;
  Symmetry symmetry = Symmetry::General;
  Mat matrix = nullptr, schur = nullptr;
  Vec sum = nullptr, rhs = nullptr, solution = nullptr, everywhere = nullptr;
  VecScatter gather = nullptr;
  KSP block = nullptr, direct = nullptr;
  IS displacement_set = nullptr, pressure_set = nullptr;

  ~Impl() {
    KSPDestroy(&block);
    KSPDestroy(&direct);
    MatDestroy(&matrix);
    MatDestroy(&schur);
    VecDestroy(&sum);
    VecDestroy(&rhs);
    VecDestroy(&solution);
    VecDestroy(&everywhere);
    VecScatterDestroy(&gather);
    ISDestroy(&displacement_set);
    ISDestroy(&pressure_set);
  }

  void make_patterns(const Layout& layout, const ElementList& elements, std::span<const int> fixed);
  void make_block_solver(const Layout& layout);
  void make_direct_solver();
  void update_schur();
  void copy_in(std::span<const double> full, Vec to) const;
  void copy_out(Vec from, std::vector<double>& full) const;
  bool run(KSP solver, double relative_tolerance, int& iterations) const;
  bool solve_by_blocks(double relative_tolerance, LinearReport& report);
  void solve_directly(double relative_tolerance, LinearReport& report);
};

void SparseSystem::Impl::make_patterns(const Layout& layout, const ElementList& elements,
                                       std::span<const int> fixed) {
  offset = elements.offset;
  matrix_offset.assign(1, 0);
  std::vector<PetscInt> rows;
  std::vector<PetscInt> columns;
  for (int e = 0; e < elements.size(); ++e) {
    const auto begin = static_cast<std::size_t>(offset[static_cast<std::size_t>(e)]);
    const auto end = static_cast<std::size_t>(offset[static_cast<std::size_t>(e) + 1]);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = begin; j < end; ++j) {
        const bool held = elements.dofs[i] < 0 || elements.dofs[j] < 0;
        rows.push_back(held ? -1 : elements.dofs[i]);
        columns.push_back(held ? -1 : elements.dofs[j]);
      }
    }
    matrix_offset.push_back(rows.size());
  }
  for (const int d : fixed) {
    if (layout.owns(d)) {
      rows.push_back(d);
      columns.push_back(d);
      ++fixed_owned;
    }
  }
  matrix_values.assign(rows.size(), 0.0);
  std::fill(matrix_values.end() - static_cast<std::ptrdiff_t>(fixed_owned), matrix_values.end(),
            1.0);
  vector_values.assign(elements.dofs.size(), 0.0);

  const PetscInt own = layout.own_end - layout.own_begin;
  check(MatCreate(PETSC_COMM_WORLD, &matrix), "creating the matrix");
  check(MatSetSizes(matrix, own, own, layout.dofs, layout.dofs), "sizing the matrix");
  check(MatSetType(matrix, MATAIJ), "typing the matrix");
  check(MatSetPreallocationCOO(matrix, static_cast<PetscCount>(rows.size()), rows.data(),
                               columns.data()),
        "laying out the matrix");
  check(VecCreateMPI(PETSC_COMM_WORLD, own, layout.dofs, &sum), "creating the residual");
  check(VecSetOption(sum, VEC_IGNORE_NEGATIVE_INDICES, PETSC_TRUE), "ignoring fixed unknowns");
  std::vector<PetscInt> entries(elements.dofs.begin(), elements.dofs.end());
  check(VecSetPreallocationCOO(sum, static_cast<PetscCount>(entries.size()), entries.data()),
        "laying out the residual");
  check(VecCreateMPI(PETSC_COMM_WORLD, own, layout.dofs, &rhs), "creating the right-hand side");
  check(VecDuplicate(rhs, &solution), "creating the solution");
  check(VecScatterCreateToAll(rhs, &gather, &everywhere), "creating the gather");
}

void SparseSystem::Impl::make_direct_solver() {
  check(KSPCreate(PETSC_COMM_WORLD, &direct), "creating the direct solver");
  check(KSPSetOperators(direct, matrix, matrix), "setting the matrix");
  check(KSPSetType(direct, KSPFGMRES), "choosing FGMRES");
  PC pc = nullptr;
  check(KSPGetPC(direct, &pc), "getting the preconditioner");
  check(PCSetType(pc, symmetry == Symmetry::Symmetric ? PCCHOLESKY : PCLU), "choosing MUMPS");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "choosing MUMPS");
}

/// Upper block factorisation: incomplete factors of the displacement block, and for the Schur
/// complement the diagonal of  A11 - A10 diag(A00)^-1 A01.
void SparseSystem::Impl::make_block_solver(const Layout& layout) {
  check(KSPCreate(PETSC_COMM_WORLD, &block), "creating the linear solver");
  check(KSPSetOperators(block, matrix, matrix), "setting the matrix");
  check(KSPSetType(block, KSPGMRES), "choosing GMRES");
  check(KSPSetPCSide(block, PC_RIGHT), "preconditioning from the right");
  check(KSPGMRESSetRestart(block, max_block_iterations), "setting the restart");
  PC pc = nullptr;
  check(KSPGetPC(block, &pc), "getting the preconditioner");
  std::vector<PetscInt> u;
  std::vector<PetscInt> p;
  for (int d = layout.own_begin; d < layout.own_end; ++d) {
    (is_pressure[static_cast<std::size_t>(d)] ? p : u).push_back(d);
  }
  check(ISCreateGeneral(PETSC_COMM_WORLD, static_cast<PetscInt>(u.size()), u.data(),
                        PETSC_COPY_VALUES, &displacement_set),
        "indexing displacements");
  check(ISCreateGeneral(PETSC_COMM_WORLD, static_cast<PetscInt>(p.size()), p.data(),
                        PETSC_COPY_VALUES, &pressure_set),
        "indexing pressures");
  const auto rows = static_cast<PetscInt>(p.size());
  check(MatCreateAIJ(PETSC_COMM_WORLD, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0,
                     nullptr, &schur),
        "creating the Schur diagonal");
  check(PCSetType(pc, PCFIELDSPLIT), "choosing block preconditioning");
  check(PCFieldSplitSetIS(pc, "u", displacement_set), "naming the blocks");
  check(PCFieldSplitSetIS(pc, "p", pressure_set), "naming the blocks");
  check(PCFieldSplitSetType(pc, PC_COMPOSITE_SCHUR), "choosing the Schur complement");
  check(PCFieldSplitSetSchurFactType(pc, PC_FIELDSPLIT_SCHUR_FACT_UPPER), "choosing its form");
  check(PCFieldSplitSetSchurPre(pc, PC_FIELDSPLIT_SCHUR_PRE_USER, schur), "giving its diagonal");
  for (const auto& [key, value] : {std::pair{"-fieldsplit_u_ksp_type", "preonly"},
                                   {"-fieldsplit_u_pc_type", "bjacobi"},
                                   {"-fieldsplit_u_sub_pc_factor_mat_ordering_type", "rcm"},
                                   {"-fieldsplit_p_ksp_type", "preonly"},
                                   {"-fieldsplit_p_pc_type", "jacobi"}}) {
    check(PetscOptionsSetValue(nullptr, key, value), "setting options");
  }
  check(PCSetFromOptions(pc), "reading the options of the blocks");
}

void SparseSystem::Impl::update_schur() {
  Vec diagonal = sum;  // free between assembly and the next one
  check(MatGetDiagonal(matrix, diagonal), "reading the diagonal");
  std::vector<double> d;
  copy_out(diagonal, d);
  PetscInt begin = 0;
  PetscInt end = 0;
  check(MatGetOwnershipRange(matrix, &begin, &end), "reading rows");
  PetscInt row = 0;
  check(MatGetOwnershipRange(schur, &row, nullptr), "reading rows");
  for (PetscInt i = begin; i < end; ++i) {
    if (!is_pressure[static_cast<std::size_t>(i)]) {
      continue;
    }
    PetscInt n = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix, i, &n, &columns, &values), "reading a row");
    double s = d[static_cast<std::size_t>(i)];
    for (PetscInt k = 0; k < n; ++k) {
      const auto j = static_cast<std::size_t>(columns[k]);
      if (!is_pressure[j]) {
        s -= values[k] * values[k] / std::abs(d[j]);
      }
    }
    check(MatRestoreRow(matrix, i, &n, &columns, &values), "reading a row");
    check(MatSetValue(schur, row, row, s, INSERT_VALUES), "writing the Schur diagonal");
    ++row;
  }
  check(MatAssemblyBegin(schur, MAT_FINAL_ASSEMBLY), "assembling the Schur diagonal");
  check(MatAssemblyEnd(schur, MAT_FINAL_ASSEMBLY), "assembling the Schur diagonal");
}

void SparseSystem::Impl::copy_out(Vec from, std::vector<double>& full) const {
  check(VecScatterBegin(gather, from, everywhere, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  check(VecScatterEnd(gather, from, everywhere, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(everywhere, &values), "reading a vector");
  full.assign(values, values + dofs);
  check(VecRestoreArrayRead(everywhere, &values), "reading a vector");
}

void SparseSystem::Impl::copy_in(std::span<const double> full, Vec to) const {
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(to, &begin, &end), "writing a vector");
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(to, &values), "writing a vector");
  std::copy(full.begin() + begin, full.begin() + end, values);
  check(VecRestoreArrayWrite(to, &values), "writing a vector");
}

bool SparseSystem::Impl::run(KSP solver, double relative_tolerance, int& iterations) const {
  check(KSPSetTolerances(solver, relative_tolerance, PETSC_DEFAULT, 1e6,
                         solver == block ? max_block_iterations : max_direct_iterations),
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

bool SparseSystem::Impl::solve_by_blocks(double relative_tolerance, LinearReport& report) {
  // Factors that a failure of the blocks forced are used up before the blocks are tried again.
  if (dofs < small_system || (direct != nullptr && !factors_stale)) {
    return false;
  }
  update_schur();
  check(KSPSetOperators(block, matrix, matrix), "setting the matrix");
  report.converged = run(block, relative_tolerance, report.iterations);
  return report.converged;
}

void SparseSystem::Impl::solve_directly(double relative_tolerance, LinearReport& report) {
  if (direct == nullptr) {
    make_direct_solver();
  }
  for (int attempt = 0; attempt < 2 && !report.converged; ++attempt) {
    const bool fresh = factors_stale;
    check(KSPSetReusePreconditioner(direct, fresh ? PETSC_FALSE : PETSC_TRUE), "keeping factors");
    check(KSPSetOperators(direct, matrix, matrix), "setting the matrix");
    report.factorised = report.factorised || fresh;
    int iterations = 0;
    report.converged = run(direct, relative_tolerance, iterations);
    report.iterations += iterations;
    factors_stale = !report.converged || iterations > slow_solve;
    if (fresh) {
      factors_stale = !report.converged;
      break;  // trying again would change nothing
    }
  }
}

SparseSystem::SparseSystem(const Layout& layout, const ElementList& elements,
                           std::span<const int> fixed, std::vector<bool> pressure,
                           Symmetry symmetry)
    : impl_(std::make_unique<Impl>()) {
  impl_->dofs = layout.dofs;
  impl_->is_pressure = std::move(pressure);
  impl_->symmetry = symmetry;
  impl_->make_patterns(layout, elements, fixed);
  if (symmetry == Symmetry::Symmetric) {
    check(MatSetOption(impl_->matrix, MAT_SYMMETRIC, PETSC_TRUE), "marking symmetry");
    check(MatSetOption(impl_->matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE), "marking symmetry");
  }
  impl_->make_block_solver(layout);
}

SparseSystem::~SparseSystem() = default;

std::span<double> SparseSystem::matrix_block(int element) {
  const auto e = static_cast<std::size_t>(element);
  return std::span(impl_->matrix_values)
      .subspan(impl_->matrix_offset[e], impl_->matrix_offset[e + 1] - impl_->matrix_offset[e]);
}

std::span<double> SparseSystem::vector_block(int element) {
  const auto e = static_cast<std::size_t>(element);
  const auto begin = static_cast<std::size_t>(impl_->offset[e]);
  return std::span(impl_->vector_values)
      .subspan(begin, static_cast<std::size_t>(impl_->offset[e + 1]) - begin);
}

void SparseSystem::assemble_matrix() {
  check(MatSetValuesCOO(impl_->matrix, impl_->matrix_values.data(), INSERT_VALUES),
        "assembling the matrix");
}

void SparseSystem::assemble_vector(std::vector<double>& full) {
  check(VecSetValuesCOO(impl_->sum, impl_->vector_values.data(), INSERT_VALUES),
        "assembling the residual");
  impl_->copy_out(impl_->sum, full);
}

LinearReport SparseSystem::solve(std::span<const double> b, double relative_tolerance,
                                 std::vector<double>& x) {
  impl_->copy_in(b, impl_->rhs);
  LinearReport report;
  if (!impl_->solve_by_blocks(relative_tolerance, report)) {
    impl_->solve_directly(relative_tolerance, report);
  }
  impl_->copy_out(impl_->solution, x);
  return report;
}

void SparseSystem::forget_factorisation() {
  impl_->factors_stale = true;
}

}  // namespace sanatrix::fem
