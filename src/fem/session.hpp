// Starts and ends MPI and PETSc; one object in main.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace sanatrix::fem {

class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

int rank();   ///< of this process in MPI_COMM_WORLD
int ranks();  ///< number of processes

// Over all processes, the same on each; collective.
double sum(double mine);
double largest(double mine);
/// Over the processes of lower rank only.
double sum_before(double mine);
/// What all processes give, in the order of ranks, on rank 0; empty elsewhere.
std::vector<double> gather(const std::vector<double>& mine);
/// The other way: what rank 0 holds for all, in the order of ranks; each says how many it takes.
std::vector<double> scatter(const std::vector<double>& all, std::size_t mine);
/// Adds up entry by entry over all processes.
void sum_each(std::span<double> mine);
/// Replaces the text by that of one process. Collective.
void broadcast(std::string& text, int from = 0);
/// The same for numbers.
void broadcast(std::vector<double>& numbers, int from = 0);

}  // namespace sanatrix::fem
