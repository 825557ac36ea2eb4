#include "job_queue.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <map>
#include <mutex>
#include <thread>

#include "child.hpp"
#include "core/error.hpp"
#include "diary.hpp"
#include "guard.hpp"
#include "job_store.hpp"

namespace sanatrix::server {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto look_pause = 150ms;
constexpr auto patience = 20s;  // after which a stop becomes a hard stop
constexpr std::size_t remembered_jobs = 200;

/// Why a command failed, for people: its own last line, or what the system did to it.
std::string reason_of(const Exit& exit, const fs::path& messages) {
  if (exit.signal == SIGKILL) {
    return "the simulation was ended by the system, most likely because memory ran out - choose a "
           "coarser mesh or close other programs; what is finished is kept";
  }
  if (exit.signal != 0) {
    return fmt::format(
        "the simulation crashed (signal {}) - the planner goes on; what is finished "
        "is kept, and the case's run.log tells where it was",
        exit.signal);
  }
  const std::string line = told_by(messages);
  return line.empty() ? fmt::format("it ended with code {}", exit.code) : line;
}

}  // namespace

std::string name_of(JobState state) {
  constexpr std::array names{"queued", "running", "done", "failed", "cancelled"};
  return names[static_cast<std::size_t>(state)];
}

struct JobQueue::Impl {
  fs::path folder, cases;
  JobStore store;
  mutable std::mutex mutex;
  std::condition_variable wake;
  std::vector<StoredJob> jobs;  // oldest first
  std::string cancelled;        // the running job that shall stop
  bool stopping = false;
  long revision = 0;
  std::thread worker;

  Impl(const fs::path& f, fs::path c) : folder(f), cases(std::move(c)), store(f / "queue.sqlite") {
    jobs = store.load();
    while (jobs.size() > remembered_jobs) {
      store.forget(jobs.front().job.id);
      jobs.erase(jobs.begin());
    }
    worker = std::thread([this] { work(); });
  }

  StoredJob* find(const std::string& id) {
    const auto at = std::ranges::find_if(jobs, [&](const auto& j) { return j.job.id == id; });
    return at == jobs.end() ? nullptr : &*at;
  }

  /// Writes a change down; called with the lock held.
  void changed(const StoredJob& stored) {
    store.save(stored);
    ++revision;
  }

  void work() {
    std::unique_lock lock(mutex);
    while (!stopping) {
      // What ran when the last server died comes first.
      auto next = std::ranges::find_if(
          jobs, [](const auto& j) { return j.job.state == JobState::Running; });
      if (next == jobs.end()) {
        next = std::ranges::find_if(jobs,
                                    [](const auto& j) { return j.job.state == JobState::Queued; });
      }
      if (next == jobs.end()) {
        wake.wait(lock);
        continue;
      }
      const std::string id = next->job.id;
      lock.unlock();
      run(id);
      lock.lock();
    }
  }

  void run(const std::string& id) {
    try {
      wait_for_survivor(id);
      while (run_step(id)) {
      }
    } catch (const std::exception& e) {
      finish(id, JobState::Failed, 4, e.what());
    }
  }

  /// A process of a dead server may still be at work: let it, then the step runs again, which is
  /// quick for what is finished.
  void wait_for_survivor(const std::string& id) {
    std::unique_lock lock(mutex);
    const ProcessId process = find(id)->process;
    if (!process.alive()) {
      return;
    }
    Diary diary(cases / find(id)->job.case_id / "run.jsonl");
    bool asked = false;
    while (process.alive() && !stopping) {
      if (cancelled == id && !asked) {
        process.interrupt();
        asked = true;
      }
      revision += diary.update(find(id)->job.progress) ? 1 : 0;
      wake.wait_for(lock, look_pause);
    }
  }

  /// Runs the next step; false when the job is over or shall wait.
  bool run_step(const std::string& id) {
    ProcessId child;
    const fs::path messages = folder / "messages.txt";
    std::optional<Diary> diary;
    {
      const std::scoped_lock lock(mutex);
      StoredJob& stored = *find(id);
      if (stopping) {
        return false;
      }
      if (cancelled == id) {
        end(stored, JobState::Cancelled, 5, "stopped; what is finished is kept");
        return false;
      }
      if (stored.job.step >= stored.job.steps.size()) {
        end(stored, JobState::Done, 0, "");
        return false;
      }
      const Step& step = stored.job.steps[stored.job.step];
      if (step.clear_first) {
        fs::remove_all(*step.clear_first);
      }
      diary.emplace(cases / stored.job.case_id / "run.jsonl");
      diary->skip_old();
      child = start_child(step.words, folder / "output.txt", messages);
      stored.process = child;
      stored.job.state = JobState::Running;
      stored.job.started_s = stored.job.started_s == 0 ? std::time(nullptr) : stored.job.started_s;
      changed(stored);
    }
    const Exit exit = watch(id, child, *diary, messages);
    return conclude(id, exit, messages);
  }

  Exit watch(const std::string& id, const ProcessId& child, Diary& diary,
             const fs::path& messages) {
    std::unique_lock lock(mutex);
    auto asked = std::chrono::steady_clock::time_point::max();
    for (;;) {
      if (const auto exit = exit_of(child)) {
        return *exit;
      }
      const auto now = std::chrono::steady_clock::now();
      const bool must_stop = stopping || cancelled == id;
      if (must_stop &&
          (asked == std::chrono::steady_clock::time_point::max() || now - asked > patience)) {
        child.interrupt();
        asked = now;
      }
      JobProgress& progress = find(id)->job.progress;
      const bool told =
          diary.update(progress) ||
          (progress.finished.empty() && parse_progress_line(last_line(messages), progress));
      revision += told ? 1 : 0;
      wake.wait_for(lock, look_pause);
    }
  }

  bool conclude(const std::string& id, const Exit& exit, const fs::path& messages) {
    const std::scoped_lock lock(mutex);
    StoredJob& stored = *find(id);
    stored.process = {};
    if (exit.signal == 0 && exit.code == 0) {
      ++stored.job.step;
      changed(stored);
      return true;
    }
    if (stopping) {  // goes on with the next server
      stored.job.state = JobState::Queued;
      changed(stored);
      return false;
    }
    if (cancelled == id) {
      end(stored, JobState::Cancelled, 5, "stopped; what is finished is kept");
      return false;
    }
    end(stored, JobState::Failed, exit.code, reason_of(exit, messages));
    return false;
  }

  /// What was uploaded for a job has done its service; it may show and name a person.
  void forget_uploads(const Job& job) const {
    const fs::path uploads = folder / "uploads";
    for (const Step& step : job.steps) {
      for (const std::string& word : step.words) {
        const fs::path part = fs::path(word).lexically_relative(uploads);
        if (!part.empty() && *part.begin() != ".." && *part.begin() != ".") {
          std::error_code none;
          fs::remove_all(uploads / *part.begin(), none);
        }
      }
    }
  }

  /// With the lock held.
  void end(StoredJob& stored, JobState state, int code, const std::string& message) {
    stored.process = {};
    stored.job.state = state;
    stored.job.exit_code = code;
    stored.job.message = message;
    stored.job.ended_s = std::time(nullptr);
    if (cancelled == stored.job.id) {
      cancelled.clear();
    }
    changed(stored);
    if (state == JobState::Done) {
      forget_uploads(stored.job);
    }
  }

  void finish(const std::string& id, JobState state, int code, const std::string& message) {
    const std::scoped_lock lock(mutex);
    end(*find(id), state, code, message);
  }
};

JobQueue::JobQueue(const fs::path& folder, fs::path cases)
    : impl_(std::make_unique<Impl>(folder, std::move(cases))) {}

JobQueue::~JobQueue() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->stopping = true;
  }
  impl_->wake.notify_all();
  impl_->worker.join();
}

std::string JobQueue::add(const std::string& case_id, const std::string& kind,
                          std::vector<Step> steps) {
  const std::scoped_lock lock(impl_->mutex);
  StoredJob stored;
  stored.job = {.id = random_name().substr(0, 12),
                .case_id = case_id,
                .kind = kind,
                .steps = std::move(steps),
                .created_s = std::time(nullptr),
                .message = {},
                .progress = {}};
  impl_->jobs.push_back(stored);
  impl_->changed(stored);
  impl_->wake.notify_all();
  return stored.job.id;
}

void JobQueue::cancel(const std::string& id) {
  const std::scoped_lock lock(impl_->mutex);
  StoredJob* stored = impl_->find(id);
  require(stored != nullptr, "there is no job {}", id);
  if (stored->job.state == JobState::Queued) {
    impl_->end(*stored, JobState::Cancelled, 5, "stopped before it began");
  } else if (stored->job.state == JobState::Running) {
    impl_->cancelled = id;
    ++impl_->revision;
  }
  impl_->wake.notify_all();
}

void JobQueue::resume(const std::string& id) {
  const std::scoped_lock lock(impl_->mutex);
  StoredJob* stored = impl_->find(id);
  require(stored != nullptr, "there is no job {}", id);
  if (stored->job.state == JobState::Failed || stored->job.state == JobState::Cancelled) {
    stored->job.state = JobState::Queued;
    stored->job.message.clear();
    stored->job.progress = {};
    impl_->changed(*stored);
    impl_->wake.notify_all();
  }
}

std::vector<Job> JobQueue::jobs() const {
  const std::scoped_lock lock(impl_->mutex);
  std::vector<Job> result;
  for (auto at = impl_->jobs.rbegin(); at != impl_->jobs.rend(); ++at) {
    result.push_back(at->job);
  }
  return result;
}

std::optional<Job> JobQueue::find(const std::string& id) const {
  const std::scoped_lock lock(impl_->mutex);
  const StoredJob* stored = impl_->find(id);
  return stored == nullptr ? std::nullopt : std::optional(stored->job);
}

bool JobQueue::busy(const std::string& case_id) const {
  const std::scoped_lock lock(impl_->mutex);
  return std::ranges::any_of(impl_->jobs, [&](const StoredJob& j) {
    return j.job.case_id == case_id &&
           (j.job.state == JobState::Running || j.job.state == JobState::Queued);
  });
}

long JobQueue::revision() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->revision;
}

}  // namespace sanatrix::server
