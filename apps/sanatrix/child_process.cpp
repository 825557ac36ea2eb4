#include "child_process.hpp"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"

extern char** environ;

namespace sanatrix::app {
namespace {

std::vector<char*> pointers(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const std::string& word : arguments) {
    argv.push_back(const_cast<char*>(word.c_str()));  // posix_spawn does not write to them
  }
  argv.push_back(nullptr);
  return argv;
}

/// File actions of posix_spawn, freed at the end.
struct Actions {
  posix_spawn_file_actions_t value{};
  Actions() { posix_spawn_file_actions_init(&value); }
  ~Actions() { posix_spawn_file_actions_destroy(&value); }
  Actions(const Actions&) = delete;
  Actions& operator=(const Actions&) = delete;
};

}  // namespace

std::string own_program() {
  std::array<char, 4096> self{};
  ensure(::readlink("/proc/self/exe", self.data(), self.size() - 1) > 0,
         "the program's own file is unknown");
  return self.data();
}

pid_t start_process(const std::vector<std::string>& arguments) {
  Actions actions;
  posix_spawn_file_actions_adddup2(&actions.value, STDERR_FILENO, STDOUT_FILENO);
  auto argv = pointers(arguments);
  pid_t child = 0;
  const int problem = posix_spawnp(&child, argv[0], &actions.value, nullptr, argv.data(), environ);
  if (problem != 0) {
    throw Error(Fault::Resource,
                fmt::format("{} cannot be started: {}", arguments[0], std::strerror(problem)));
  }
  return child;
}

Captured run_captured(const std::vector<std::string>& arguments) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) {
    throw Error(Fault::Resource, fmt::format("no pipe: {}", std::strerror(errno)));
  }
  Actions actions;
  posix_spawn_file_actions_adddup2(&actions.value, pipe[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions.value, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  auto argv = pointers(arguments);
  pid_t child = 0;
  const int problem = posix_spawnp(&child, argv[0], &actions.value, nullptr, argv.data(), environ);
  ::close(pipe[1]);
  Captured captured;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; problem == 0 && (n = ::read(pipe[0], buffer.data(), buffer.size())) != 0;) {
    if (n > 0) {
      captured.output.append(buffer.data(), static_cast<std::size_t>(n));
    } else if (errno != EINTR) {
      break;
    }
  }
  ::close(pipe[0]);
  if (problem == 0) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    captured.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  return captured;
}

}  // namespace sanatrix::app
