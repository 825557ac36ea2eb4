#include "healing/ghosted_vector.hpp"

#include <petscvec.h>

#include "core/error.hpp"
#include "fem/session.hpp"

namespace sanatrix::healing {

Vec create_ghosted(const System& system) {
  Vec v = nullptr;
  const auto& ghosts = system.ghosts();
  ensure(VecCreateGhost(PETSC_COMM_WORLD, system.own_unknowns(), system.all_unknowns(),
                        static_cast<PetscInt>(ghosts.size()), ghosts.data(), &v) == 0,
         "PETSc did not create a vector of {} unknowns", system.all_unknowns());
  return v;
}

void update_ghosts(Vec v) {
  if (fem::ranks() > 1) {
    VecGhostUpdateBegin(v, INSERT_VALUES, SCATTER_FORWARD);
    VecGhostUpdateEnd(v, INSERT_VALUES, SCATTER_FORWARD);
  }
}

std::vector<double> gathered(std::span<const double> own) {
  const int ranks = fem::ranks();
  const int size = static_cast<int>(own.size());
  std::vector<int> sizes(ranks), offsets(ranks + 1);
  MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, PETSC_COMM_WORLD);
  for (int r = 0; r < ranks; ++r) {
    offsets[r + 1] = offsets[r] + sizes[r];
  }
  std::vector<double> all(offsets.back());
  MPI_Allgatherv(own.data(), size, MPI_DOUBLE, all.data(), sizes.data(), offsets.data(), MPI_DOUBLE,
                 PETSC_COMM_WORLD);
  return all;
}

LocalValues::LocalValues(Vec v) : vector_(v) {
  PetscInt own = 0, all = 0;
  PetscScalar* data = nullptr;
  VecGhostGetLocalForm(v, &local_);
  VecGetLocalSize(v, &own);
  VecGetSize(local_, &all);
  VecGetArray(local_, &data);
  all_ = {data, static_cast<std::size_t>(all)};
  own_ = all_.first(static_cast<std::size_t>(own));
}

LocalValues::~LocalValues() {
  PetscScalar* data = all_.data();
  VecRestoreArray(local_, &data);
  VecGhostRestoreLocalForm(vector_, &local_);
}

}  // namespace sanatrix::healing
