// The local engine: one child process per task, so that a crash costs one try of one task.
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <deque>
#include <map>
#include <thread>

#include <sys/wait.h>

#include "child_process.hpp"
#include "core/context.hpp"
#include "core/error.hpp"
#include "sweep_engines.hpp"

namespace sanatrix::app {
namespace {

/// A task whose worker dies this often is given up.
constexpr int most_tries = 5;

class LocalEngine {
 public:
  LocalEngine(const pipeline::Sweep& sweep, std::size_t jobs) : sweep_(sweep), jobs_(jobs) {
    for (const pipeline::SweepTask& task : sweep.tasks) {
      if (!sweep.done(task)) {
        waiting_.push_back(&task);
      }
    }
  }
  ~LocalEngine() {
    for (const auto& [pid, task] : running_) {  // checkpoint and leave
      ::kill(pid, SIGINT);
    }
    for (int status = 0; const auto& [pid, task] : running_) {
      ::waitpid(pid, &status, 0);
    }
  }
  LocalEngine(const LocalEngine&) = delete;
  LocalEngine& operator=(const LocalEngine&) = delete;

  void run(const SweepProgress& progress, const std::stop_token& stop) {
    while (!waiting_.empty() || !running_.empty()) {
      if (stop.stop_requested()) {
        throw Cancelled{};
      }
      while (running_.size() < jobs_ && !waiting_.empty()) {
        start(*waiting_.front());
        waiting_.pop_front();
      }
      while (reap(WNOHANG)) {
      }
      progress(sweep_.tasks.size() - waiting_.size() - running_.size() - given_up_.size(),
               running_.size());
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    if (!given_up_.empty()) {
      throw Error(Fault::Resource,
                  fmt::format("{} tasks died {} times each: {}", given_up_.size(), most_tries,
                              fmt::join(given_up_, ", ")),
                  "run one by hand: sanatrix sweep FILE --task KEY");
    }
  }

 private:
  void start(const pipeline::SweepTask& task) {
    ++tries_[task.key];
    running_[start_process({own_program(), "sweep", sweep_.file.string(), "--out",
                            sweep_.out.string(), "--task", task.key, "-q"})] = &task;
  }

  /// One ended child, if there is one.
  bool reap(int flags) {
    if (running_.empty()) {
      return false;
    }
    int status = 0;
    const pid_t pid = ::waitpid(-1, &status, flags);
    const auto child = running_.find(pid);
    if (child == running_.end()) {
      ensure(pid >= 0 || errno == EINTR, "the workers of the sweep are gone");
      return false;
    }
    const pipeline::SweepTask& task = *child->second;
    running_.erase(child);
    if (!sweep_.done(task)) {
      if (tries_[task.key] < most_tries) {
        waiting_.push_back(&task);
      } else {
        given_up_.push_back(task.key);
      }
    }
    return true;
  }

  const pipeline::Sweep& sweep_;
  std::size_t jobs_;
  std::deque<const pipeline::SweepTask*> waiting_;
  std::map<pid_t, const pipeline::SweepTask*> running_;
  std::map<std::string, int> tries_;
  std::vector<std::string> given_up_;
};

}  // namespace

void sweep_locally(const pipeline::Sweep& sweep, const SweepOptions& options,
                   const SweepProgress& progress, const std::stop_token& stop) {
  setenv("OMP_NUM_THREADS", "1", 0);  // tasks are the parallelism
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  LocalEngine engine(sweep, options.jobs > 0 ? static_cast<std::size_t>(options.jobs) : cores);
  engine.run(progress, stop);
}

}  // namespace sanatrix::app
