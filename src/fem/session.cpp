#include "fem/session.hpp"

#include <cstdlib>
#include <numeric>

#include <petscsys.h>

#include "core/error.hpp"

namespace sanatrix::fem {

Session::Session() {
  // One process may run without mpirun: Open MPI then need not start a daemon for processes that
  // join later.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
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

double sum_before(double mine) {
  double before = 0.0;  // which rank 0 keeps
  MPI_Exscan(&mine, &before, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return before;
}

void sum_each(std::span<double> mine) {
  MPI_Allreduce(MPI_IN_PLACE, mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM,
                MPI_COMM_WORLD);
}

namespace {

/// On rank 0: how many numbers every rank has, and where they begin among all.
struct Places {
  std::vector<int> count, begin;
  explicit Places(int mine) : count(static_cast<std::size_t>(ranks())), begin(count.size()) {
    MPI_Gather(&mine, 1, MPI_INT, count.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::exclusive_scan(count.begin(), count.end(), begin.begin(), 0);
  }
};

}  // namespace

std::vector<double> gather(const std::vector<double>& mine) {
  const auto count = static_cast<int>(mine.size());
  const Places places(count);
  std::vector<double> all(
      rank() == 0 ? static_cast<std::size_t>(places.begin.back() + places.count.back()) : 0U);
  MPI_Gatherv(mine.data(), count, MPI_DOUBLE, all.data(), places.count.data(), places.begin.data(),
              MPI_DOUBLE, 0, MPI_COMM_WORLD);
  return all;
}

std::vector<double> scatter(const std::vector<double>& all, std::size_t mine) {
  const auto count = static_cast<int>(mine);
  const Places places(count);
  std::vector<double> values(mine);
  MPI_Scatterv(all.data(), places.count.data(), places.begin.data(), MPI_DOUBLE, values.data(),
               count, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  return values;
}

void broadcast(std::string& text, int from) {
  auto size = static_cast<unsigned long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, from, MPI_COMM_WORLD);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, from, MPI_COMM_WORLD);
}

void broadcast(std::vector<double>& numbers, int from) {
  auto size = static_cast<unsigned long>(numbers.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, from, MPI_COMM_WORLD);
  numbers.resize(size);
  MPI_Bcast(numbers.data(), static_cast<int>(size), MPI_DOUBLE, from, MPI_COMM_WORLD);
}

int ranks() {
  int n = 1;
  if (in_session()) {
    MPI_Comm_size(MPI_COMM_WORLD, &n);
  }
  return n;
}

}  // namespace sanatrix::fem
