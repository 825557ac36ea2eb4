#include "report/external.hpp"

#include <chrono>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace sanatrix::report {

std::optional<std::string> run_external(const std::string& program,
                                        const std::vector<std::string>& arguments,
                                        int limit_seconds, const Context& ctx) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t silent;
  ::posix_spawn_file_actions_init(&silent);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_RDWR, 0);
  }
  // A group of its own, so that a browser's children end with it.
  posix_spawnattr_t own_group;
  ::posix_spawnattr_init(&own_group);
  ::posix_spawnattr_setflags(&own_group, POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  const int problem =
      ::posix_spawnp(&child, program.c_str(), &silent, &own_group, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&silent);
  ::posix_spawnattr_destroy(&own_group);
  if (problem != 0) {
    return fmt::format("{} cannot be started: {}", program, std::strerror(problem));
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(limit_seconds);
  int status = 0;
  const auto kill = [&] {
    ::kill(-child, SIGKILL);
    ::waitpid(child, &status, 0);
  };
  while (::waitpid(child, &status, WNOHANG) == 0) {
    try {
      ctx.detail(0.0, {});  // throws Cancelled
    } catch (const Cancelled&) {
      kill();
      throw;
    }
    if (std::chrono::steady_clock::now() > end) {
      kill();
      return fmt::format("{} took more than {} s", program, limit_seconds);
    }
    ::usleep(10000);
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return fmt::format("{} failed", program);
  }
  return std::nullopt;
}

}  // namespace sanatrix::report
