// An off-screen display and a child process that draws on it. Debian's VTK ends the program when
// there is no X display, so the drawing never happens in the caller's process.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"
#include "render/render.hpp"

namespace sanatrix::render {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

constexpr seconds start_limit{20};  // Xvfb starts within a second on a quiet machine
constexpr int pulse_ms = 50;        // how long a stop request waits

/// Both ends of a pipe; none of them leaks into programs that are started.
class Pipe {
 public:
  Pipe() { ensure(::pipe2(ends_.data(), O_CLOEXEC) == 0, "no pipe: {}", std::strerror(errno)); }
  ~Pipe() {
    close(0);
    close(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  [[nodiscard]] int reading() const { return ends_[0]; }
  [[nodiscard]] int writing() const { return ends_[1]; }
  void close_writing() { close(1); }

 private:
  void close(std::size_t end) {
    if (ends_[end] >= 0) {
      ::close(ends_[end]);
      ends_[end] = -1;
    }
  }
  std::array<int, 2> ends_{-1, -1};
};

/// MPI and PETSc answer a crash by ending the whole job; a child's crash is its own.
void forget_signal_handlers() {
  for (int number = 1; number < NSIG; ++number) {
    ::signal(number, SIG_DFL);
  }
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// A child process that does not outlive this object.
class Child {
 public:
  template <class Work>
  explicit Child(const Work& work) : parent_(::getpid()), pid_(::fork()) {
    ensure(pid_ >= 0, "no new process: {}", std::strerror(errno));
    if (pid_ == 0) {
      // When the caller is killed the child must go too; it may be gone already.
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      // A terminal's Ctrl-C is the caller's, who ends this child when it is time.
      ::setpgid(0, 0);
      forget_signal_handlers();
      if (::getppid() != parent_) {
        ::_exit(1);
      }
      work();
      ::_exit(1);  // work ends the process itself; never run the caller's destructors twice
    }
  }
  ~Child() {
    if (pid_ > 0) {
      ::kill(pid_, SIGTERM);
      if (!exited_within(seconds{2})) {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
      }
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] bool exited_within(seconds limit) {
    const auto end = Clock::now() + limit;
    while (pid_ > 0) {
      if (::waitpid(pid_, &status_, WNOHANG) == pid_) {
        pid_ = -1;
      } else if (Clock::now() > end) {
        return false;
      } else {
        ::usleep(5000);
      }
    }
    return true;
  }
  [[nodiscard]] bool succeeded() const { return WIFEXITED(status_) && WEXITSTATUS(status_) == 0; }
  [[nodiscard]] std::string end() const {
    return WIFSIGNALED(status_) ? ::strsignal(WTERMSIG(status_)) : "no reason given";
  }

 private:
  pid_t parent_;
  pid_t pid_;
  int status_ = 0;
};

/// Everything that is written before all writers close, or nothing when that takes too long.
/// Throws Cancelled.
std::optional<std::string> read_until_closed(int reading, seconds limit, const Context& ctx,
                                             char last = '\0') {
  const auto end = Clock::now() + limit;
  std::string text;
  while (last == '\0' || !text.ends_with(last)) {
    ctx.detail(0.0, {});  // throws Cancelled
    pollfd waiting{reading, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, pulse_ms);
    if (ready == 0) {
      if (Clock::now() > end) {
        return std::nullopt;
      }
      continue;
    }
    std::array<char, 4096> block;
    const ssize_t count = ready > 0 ? ::read(reading, block.data(), block.size()) : -1;
    if (count == 0 || (count < 0 && errno != EINTR)) {
      break;
    }
    text.append(block.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  return text;
}

/// In the child: becomes Xvfb, which writes its display number into the pipe. Without -noreset it
/// would start anew whenever a window closes and refuse the next one meanwhile.
void become_xvfb(const Pipe& number) {
  const int inherited = ::dup(number.writing());  // without close-on-exec
  const int nowhere = ::open("/dev/null", O_RDWR);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  const std::string descriptor = std::to_string(inherited);
  ::execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "1280x1024x24",
           "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
}

/// In the child: draws, and says why not. What the graphics stack prints goes to the caller too.
void draw(const std::function<void()>& work, const std::string& display, const Pipe& report) {
  ::setenv("DISPLAY", display.c_str(), 1);
  ::dup2(report.writing(), STDERR_FILENO);
  try {
    work();
    ::_exit(0);
  } catch (const Error& e) {
    const std::string text = e.one_line();
    [[maybe_unused]] const ssize_t count = ::write(report.writing(), text.data(), text.size());
  } catch (const std::exception& e) {
    [[maybe_unused]] const ssize_t count =
        ::write(report.writing(), e.what(), std::strlen(e.what()));
  }
}

/// The end of what was said, on one line.
std::string one_line(std::string text) {
  constexpr std::size_t longest = 400;
  if (text.size() > longest) {
    text.erase(0, text.size() - longest);
  }
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' && c >= 0; }, ' ');
  return text;
}

/// A child process that draws its share of the work.
class Painter {
 public:
  Painter(const std::function<void()>& work, const std::string& display)
      : child_([&] { draw(work, display, report_); }) {
    report_.close_writing();
  }
  /// Waits for the end; why it did not succeed, or nothing.
  std::optional<std::string> problem(const Context& ctx, seconds limit) {
    const auto said = read_until_closed(report_.reading(), limit, ctx);
    if (!said) {
      return fmt::format("drawing took more than {} s", limit.count());
    }
    if (!child_.exited_within(seconds{5}) || !child_.succeeded()) {
      return "the graphics stack failed: " + (said->empty() ? child_.end() : one_line(*said));
    }
    return std::nullopt;
  }

 private:
  Pipe report_;
  Child child_;
};

}  // namespace

std::optional<std::string> with_display(const std::vector<std::function<void()>>& shares,
                                        const Context& ctx, seconds limit) {
  Pipe number;
  Child xvfb([&] { become_xvfb(number); });
  number.close_writing();
  const auto display = read_until_closed(number.reading(), start_limit, ctx, '\n');
  if (!display || display->empty()) {
    return "no off-screen display could be started - install Xvfb (Debian package xvfb)";
  }
  const std::string name =
      fmt::format(":{}", std::string_view(*display).substr(0, display->size() - 1));
  std::vector<std::unique_ptr<Painter>> painters;
  for (const auto& share : shares) {
    painters.push_back(std::make_unique<Painter>(share, name));
  }
  std::optional<std::string> first_problem;
  for (const auto& painter : painters) {
    if (const auto problem = painter->problem(ctx, limit); problem && !first_problem) {
      first_problem = problem;
    }
  }
  return first_problem;
}

std::optional<std::string> with_display(const std::function<void()>& work, const Context& ctx,
                                        seconds limit) {
  return with_display(std::vector{work}, ctx, limit);
}

}  // namespace sanatrix::render
