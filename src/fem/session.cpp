#include "fem/session.hpp"

#include <petscsys.h>

#include "core/error.hpp"

namespace sanatrix::fem {

Session::Session() {
  // One process may run without mpirun; root is allowed because containers run as root.
  ensure(PetscInitializeNoArguments() == 0, "PETSc did not start");
  PetscPopSignalHandler();  // Ctrl-C and crashes are handled by the command
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);  // codes become Error, not pages of text
}

Session::~Session() {
  PetscFinalize();
}

int rank() {
  int r = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &r);
  return r;
}

int ranks() {
  int n = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &n);
  return n;
}

}  // namespace sanatrix::fem
