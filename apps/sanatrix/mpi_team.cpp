#include "mpi_team.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <fmt/format.h>
#include <mpi.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"
#include "failure.hpp"
#include "fem/session.hpp"
#include "interrupt.hpp"

extern char** environ;

namespace sanatrix::app {
namespace {

class MpiTeam final : public pipeline::Team {
 public:
  [[nodiscard]] int rank() const override { return fem::rank(); }
  [[nodiscard]] int size() const override { return fem::ranks(); }
  long share(long value) override {
    MPI_Bcast(&value, 1, MPI_LONG, 0, MPI_COMM_WORLD);
    MPI_Barrier(MPI_COMM_WORLD);
    return value;
  }
};

/// Ranks that wait for a failed one can only be ended from outside.
[[noreturn]] void end_all_ranks(const Failure& failure) {
  if (fem::rank() == 0) {
    fmt::print(stderr, "sanatrix: {}\n", failure.line);
    std::fflush(nullptr);
  } else {
    // The same error usually happens on every rank: leave it to rank 0 to tell the story.
    std::this_thread::sleep_for(std::chrono::seconds(10));
    fmt::print(stderr, "sanatrix: rank {}: {}\n", fem::rank(), failure.line);
  }
  MPI_Abort(MPI_COMM_WORLD, failure.exit_code);
  std::_Exit(failure.exit_code);
}

}  // namespace

int with_team(const std::function<void(pipeline::Team&)>& work) {
  const fem::Session session;
  MpiTeam team;
  try {
    work(team);
  } catch (...) {  // nothing may leave a team of ranks half alive
    const Failure failure = describe(std::current_exception());
    if (team.size() > 1) {
      end_all_ranks(failure);
    }
    fmt::print(stderr, "sanatrix: {}\n", failure.line);
    return failure.exit_code;
  }
  return 0;
}

namespace {

/// Should this process start `mpirun` instead of working itself?
bool must_launch_ranks(const Common& common) {
  return common.ranks > 1 && std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr;
}

/// The same command under `mpirun -n N`; returns its exit code.
int launch_ranks(const Common& common) {
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);  // containers run as root
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  setenv("OMP_NUM_THREADS", "1", 0);  // ranks are the parallelism
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  std::array<char, 4096> self{};
  ensure(::readlink("/proc/self/exe", self.data(), self.size() - 1) > 0,
         "the program does not find itself");
  std::vector<std::string> words{
      "mpirun", "--quiet", "--oversubscribe", "-n", std::to_string(common.ranks), self.data()};
  words.insert(words.end(), common.arguments.begin(), common.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, "mpirun", nullptr, nullptr, argv.data(), environ) != 0) {
    throw Error(Fault::Resource, "mpirun cannot be started",
                "install openmpi-bin, or run without --ranks");
  }
  int state = 0;
  while (::waitpid(child, &state, 0) < 0 && errno == EINTR) {
  }
  if (interrupted()) {
    return exit_interrupted;
  }
  return WIFEXITED(state) ? WEXITSTATUS(state) : exit_code(Fault::Resource);
}

}  // namespace

void add_team_work(CLI::App& command, Common& common, Command& chosen,
                   const std::function<void(pipeline::Team&)>& work) {
  add_ranks(command, common);
  add_json(command, common);
  add_progress(command, common);
  command.callback([=, &common, &chosen] {
    chosen = [=, &common] {
      return must_launch_ranks(common) ? launch_ranks(common) : with_team(work);
    };
  });
}

}  // namespace sanatrix::app
