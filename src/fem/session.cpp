#include "fem/session.hpp"

#include <numeric>

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

namespace {

/// Without a session there is one process and nobody to talk to.
bool in_session() {
  int started = 0;
  MPI_Initialized(&started);
  return started != 0;
}

}  // namespace

int rank() {
  int r = 0;
  if (in_session()) {
    MPI_Comm_rank(MPI_COMM_WORLD, &r);
  }
  return r;
}

namespace {

double reduce(double mine, MPI_Op how) {
  double all = 0.0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, how, MPI_COMM_WORLD);
  return all;
}

}  // namespace

double sum(double mine) {
  return reduce(mine, MPI_SUM);
}
double largest(double mine) {
  return reduce(mine, MPI_MAX);
}

std::vector<double> gather(const std::vector<double>& mine) {
  const auto count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(ranks()));
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::vector<int> places(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), 0);
  std::vector<double> all(rank() == 0 ? static_cast<std::size_t>(places.back()) +
                                            static_cast<std::size_t>(counts.back())
                                      : 0U);
  MPI_Gatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), places.data(), MPI_DOUBLE,
              0, MPI_COMM_WORLD);
  return all;
}

void broadcast(std::string& text, int from) {
  auto size = static_cast<unsigned long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, from, MPI_COMM_WORLD);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, from, MPI_COMM_WORLD);
}

int ranks() {
  int n = 1;
  if (in_session()) {
    MPI_Comm_size(MPI_COMM_WORLD, &n);
  }
  return n;
}

}  // namespace sanatrix::fem
