#include "core/confined_child.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"

namespace sanatrix {
namespace {

// First byte of the answer.
constexpr char answer_ok = 'A', answer_error = 'E', answer_memory = 'M';

void limit(int resource, rlim_t value) {
  const rlimit both{value, value};
  ::setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

/// Address space that this process has now [bytes].
std::uint64_t address_space() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void confine(const ChildLimits& limits) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // it never outlives its parent
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  for (int number = 1; number < NSIG; ++number) {
    ::signal(number, SIG_DFL);  // MPI answers a crash by ending the whole job
  }
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nowhere = ::open("/dev/null", O_RDWR);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);   // parsers print what they find, names of patients too
#if !defined(__SANITIZE_ADDRESS__)  // which reserves terabytes of address space
  limit(RLIMIT_AS, address_space() + limits.memory_bytes);
#endif
  limit(RLIMIT_CPU, static_cast<rlim_t>(limits.seconds));
  limit(RLIMIT_FSIZE, limits.file_bytes);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NOFILE, 64);
}

bool send(int to, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = ::write(to, data, size);
    if (sent < 0 && errno == EINTR) {
      continue;
    }
    if (sent <= 0) {
      return false;
    }
    data += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

void send_answer(int to, char kind, const std::string& text) {
  if (send(to, &kind, 1)) {
    send(to, text.data(), text.size());
  }
}

[[noreturn]] void be_the_child(int to, const ChildLimits& limits,
                               const std::function<std::string()>& work) {
  confine(limits);
  try {
    send_answer(to, answer_ok, work());
  } catch (const Error& e) {
    send_answer(to, answer_error,
                static_cast<char>('0' + static_cast<int>(e.fault())) + std::string(e.what()) +
                    '\0' + e.hint());
  } catch (const std::bad_alloc&) {
    send_answer(to, answer_memory, {});
  } catch (const std::exception& e) {
    send_answer(
        to, answer_error,
        static_cast<char>('0' + static_cast<int>(Fault::Input)) + std::string(e.what()) + '\0');
  }
  ::_exit(0);  // never run the parent's destructors twice
}

/// The whole answer; nothing when the time is over or it is too long.
std::optional<std::string> receive(int from, const ChildLimits& limits) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::seconds(limits.seconds);
  std::string answer;
  std::array<char, 1 << 16> block;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd waiting{from, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, left.count() > 0 ? static_cast<int>(left.count()) : 0);
    if (ready == 0) {
      return std::nullopt;
    }
    const ssize_t count = ready > 0 ? ::read(from, block.data(), block.size()) : -1;
    if (count == 0) {
      return answer;
    }
    if (count < 0) {
      if (errno == EINTR) {
        continue;
      }
      return answer;
    }
    answer.append(block.data(), static_cast<std::size_t>(count));
    if (answer.size() > limits.answer_bytes) {
      return std::nullopt;
    }
  }
}

[[noreturn]] void throw_as_told(const std::string& activity, const std::string& answer) {
  const std::size_t split = std::min(answer.find('\0', 2), answer.size());
  const auto fault = static_cast<Fault>(answer.size() > 1 ? answer[1] - '0' : 1);
  Error error(fault, answer.substr(std::min<std::size_t>(2, answer.size()), split - 2),
              split < answer.size() ? answer.substr(split + 1) : std::string{});
  error.passing_through(activity);
  throw error;
}

}  // namespace

std::string in_confined_child(const std::string& activity, const ChildLimits& limits,
                              const std::function<std::string()>& work) {
  std::array<int, 2> ends{};
  ensure(::pipe2(ends.data(), O_CLOEXEC) == 0, "no pipe: {}", std::strerror(errno));
  std::fflush(nullptr);  // or the child would have our unwritten output too
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    be_the_child(ends[1], limits, work);
  }
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    throw Error(Fault::Resource,
                fmt::format("{}: no new process: {}", activity, std::strerror(errno)));
  }
  std::optional<std::string> answer;
  try {
    answer = receive(ends[0], limits);
  } catch (...) {  // out of memory: the child must not stay behind
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ::close(ends[0]);
    throw;
  }
  ::close(ends[0]);
  if (!answer) {
    ::kill(child, SIGKILL);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const bool out_of_time = !answer || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU);
  if (out_of_time) {
    throw Error(Fault::Resource,
                fmt::format("{}: reading took more than {} s", activity, limits.seconds),
                "the file is damaged or far too large for a breast examination");
  }
  if (!answer->empty() && answer->front() == answer_memory) {
    throw Error(Fault::Resource,
                fmt::format("{}: reading needs more than {} MB of memory", activity,
                            limits.memory_bytes >> 20),
                "the file is damaged or far too large for a breast examination");
  }
  if (!answer->empty() && answer->front() == answer_error) {
    throw_as_told(activity, *answer);
  }
  if (answer->empty() || answer->front() != answer_ok || !WIFEXITED(status) ||
      WEXITSTATUS(status) != 0) {
    throw Error(Fault::Input,
                fmt::format("{}: the file is damaged: its reader {}", activity,
                            WIFSIGNALED(status)
                                ? fmt::format("was ended by a {}", ::strsignal(WTERMSIG(status)))
                                : std::string("ended early")),
                "copy it again from its source");
  }
  answer->erase(0, 1);
  return std::move(*answer);
}

}  // namespace sanatrix
