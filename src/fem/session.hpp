// Starts and ends MPI and PETSc; one object in main.
#pragma once

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

}  // namespace sanatrix::fem
