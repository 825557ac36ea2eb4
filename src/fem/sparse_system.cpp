#include "fem/sparse_system.hpp"

#include <petscksp.h>

#include <algorithm>

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

/// A lagged factorisation is given up when it needs more iterations than a fresh one is worth.
constexpr int slow_solve = 14;
constexpr int max_iterations = 60;
/// Above this many unknowns a factorisation is replaced by block preconditioning.
constexpr int direct_limit = 160000;

}  // namespace

void ElementList::add(std::span<const int> element_dofs) {
  dofs.insert(dofs.end(), element_dofs.begin(), element_dofs.end());
  offset.push_back(static_cast<int>(dofs.size()));
}

struct SparseSystem::Impl {
  std::vector<int> offset;
  std::vector<std::size_t> matrix_offset;
  std::vector<double> matrix_values, vector_values;
  std::size_t fixed_owned = 0;
  int dofs = 0;
  bool stale = true;
  Mat matrix = nullptr;
  Vec sum = nullptr, rhs = nullptr, solution = nullptr, everywhere = nullptr;
  VecScatter gather = nullptr;
  KSP solver = nullptr;
  IS displacement_set = nullptr, pressure_set = nullptr;

  ~Impl() {
    KSPDestroy(&solver);
    MatDestroy(&matrix);
    VecDestroy(&sum);
    VecDestroy(&rhs);
    VecDestroy(&solution);
    VecDestroy(&everywhere);
    VecScatterDestroy(&gather);
    ISDestroy(&displacement_set);
    ISDestroy(&pressure_set);
  }

  void make_patterns(const Layout& layout, const ElementList& elements, std::span<const int> fixed);
  void make_solver(const Layout& layout, const std::vector<bool>& pressure, Symmetry symmetry);
  void copy_out(Vec from, std::vector<double>& full) const;
  PetscInt run(double relative_tolerance, bool& converged) const;
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
  std::fill(matrix_values.end() - static_cast<std::ptrdiff_t>(fixed_owned), matrix_values.end(), 1.0);
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

void SparseSystem::Impl::make_solver(const Layout& layout, const std::vector<bool>& pressure,
                                     Symmetry symmetry) {
  check(KSPCreate(PETSC_COMM_WORLD, &solver), "creating the linear solver");
  check(KSPSetOperators(solver, matrix, matrix), "setting the matrix");
  check(KSPSetType(solver, KSPFGMRES), "choosing FGMRES");
  PC pc = nullptr;
  check(KSPGetPC(solver, &pc), "getting the preconditioner");
  if (symmetry == Symmetry::Symmetric) {
    check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE), "marking symmetry");
    check(MatSetOption(matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE), "marking symmetry");
  }
  if (layout.dofs <= direct_limit) {
    check(PCSetType(pc, symmetry == Symmetry::Symmetric ? PCCHOLESKY : PCLU), "choosing MUMPS");
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "choosing MUMPS");
    return;
  }
  // Large systems: Schur complement with algebraic multigrid (ML) on the displacement block.
  std::vector<PetscInt> u;
  std::vector<PetscInt> p;
  for (int d = layout.own_begin; d < layout.own_end; ++d) {
    (pressure[static_cast<std::size_t>(d)] ? p : u).push_back(d);
  }
  check(ISCreateGeneral(PETSC_COMM_WORLD, static_cast<PetscInt>(u.size()), u.data(),
                        PETSC_COPY_VALUES, &displacement_set), "indexing displacements");
  check(ISCreateGeneral(PETSC_COMM_WORLD, static_cast<PetscInt>(p.size()), p.data(),
                        PETSC_COPY_VALUES, &pressure_set), "indexing pressures");
  check(PCSetType(pc, PCFIELDSPLIT), "choosing block preconditioning");
  check(PCFieldSplitSetIS(pc, "u", displacement_set), "naming the blocks");
  check(PCFieldSplitSetIS(pc, "p", pressure_set), "naming the blocks");
  check(PCFieldSplitSetType(pc, PC_COMPOSITE_SCHUR), "choosing the Schur complement");
  check(PCFieldSplitSetSchurFactType(pc, PC_FIELDSPLIT_SCHUR_FACT_UPPER), "choosing the Schur form");
  check(PCFieldSplitSetSchurPre(pc, PC_FIELDSPLIT_SCHUR_PRE_SELFP, nullptr), "choosing selfp");
  check(PetscOptionsSetValue(nullptr, "-fieldsplit_u_ksp_type", "preonly"), "setting options");
  check(PetscOptionsSetValue(nullptr, "-fieldsplit_u_pc_type", "ml"), "setting options");
  check(PetscOptionsSetValue(nullptr, "-fieldsplit_p_ksp_type", "preonly"), "setting options");
  check(PetscOptionsSetValue(nullptr, "-fieldsplit_p_pc_type", "bjacobi"), "setting options");
  check(PCSetFromOptions(pc), "reading the options of the blocks");
}

void SparseSystem::Impl::copy_out(Vec from, std::vector<double>& full) const {
  check(VecScatterBegin(gather, from, everywhere, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  check(VecScatterEnd(gather, from, everywhere, INSERT_VALUES, SCATTER_FORWARD), "gathering");
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(everywhere, &values), "reading a vector");
  full.assign(values, values + dofs);
  check(VecRestoreArrayRead(everywhere, &values), "reading a vector");
}

PetscInt SparseSystem::Impl::run(double relative_tolerance, bool& converged) const {
  check(KSPSetTolerances(solver, relative_tolerance, PETSC_DEFAULT, 1e6, max_iterations),
        "setting tolerances");
  check(KSPSolve(solver, rhs, solution), "solving");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(solver, &reason), "solving");
  converged = reason > 0;
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(solver, &iterations), "solving");
  return iterations;
}

SparseSystem::SparseSystem(const Layout& layout, const ElementList& elements,
                           std::span<const int> fixed, std::vector<bool> pressure,
                           Symmetry symmetry)
    : impl_(std::make_unique<Impl>()) {
  impl_->dofs = layout.dofs;
  impl_->make_patterns(layout, elements, fixed);
  impl_->make_solver(layout, pressure, symmetry);
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
  Impl& s = *impl_;
  PetscInt begin = 0;
  PetscInt end = 0;
  check(VecGetOwnershipRange(s.rhs, &begin, &end), "writing the right-hand side");
  PetscScalar* values = nullptr;
  check(VecGetArrayWrite(s.rhs, &values), "writing the right-hand side");
  std::copy(b.begin() + begin, b.begin() + end, values);
  check(VecRestoreArrayWrite(s.rhs, &values), "writing the right-hand side");

  LinearReport report;
  for (int attempt = 0; attempt < 2 && !report.converged; ++attempt) {
    const bool fresh = s.stale || attempt > 0;
    if (attempt > 0 && report.factorised) {
      break;  // already a fresh factorisation: trying again would change nothing
    }
    check(KSPSetReusePreconditioner(s.solver, fresh ? PETSC_FALSE : PETSC_TRUE), "keeping factors");
    if (fresh) {
      check(KSPSetOperators(s.solver, s.matrix, s.matrix), "setting the matrix");
      report.factorised = true;
    }
    report.iterations += static_cast<int>(s.run(relative_tolerance, report.converged));
    s.stale = !report.converged || (!fresh && report.iterations > slow_solve);
  }
  s.copy_out(s.solution, x);
  return report;
}

void SparseSystem::forget_factorisation() { impl_->stale = true; }

}  // namespace sanatrix::fem
