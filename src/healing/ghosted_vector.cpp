#include "healing/ghosted_vector.hpp"

#include <petscvec.h>

#include "core/error.hpp"

namespace sanatrix::healing {

Vec create_ghosted(const System& system) {
  Vec v = nullptr;
  const auto& ghosts = system.ghosts();
  const MPI_Comm comm = system.share() == nullptr ? PETSC_COMM_SELF : PETSC_COMM_WORLD;
  ensure(VecCreateGhost(comm, system.own_unknowns(), system.all_unknowns(),
                        static_cast<PetscInt>(ghosts.size()), ghosts.data(), &v) == 0,
         "PETSc did not create a vector of {} unknowns", system.all_unknowns());
  return v;
}

void update_ghosts(Vec v) {
  VecGhostUpdateBegin(v, INSERT_VALUES, SCATTER_FORWARD);
  VecGhostUpdateEnd(v, INSERT_VALUES, SCATTER_FORWARD);
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
