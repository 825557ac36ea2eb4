// Progress on stderr: one line that renews itself on a terminal, few plain lines elsewhere.
#pragma once

#include <chrono>
#include <stop_token>
#include <string>

#include "commands.hpp"
#include "journal.hpp"
#include "pipeline/runner.hpp"

namespace sanatrix::app {

class Progress final : public pipeline::Monitor {
 public:
  /// Speaks only on rank 0. `journal` may be null.
  Progress(const Common& common, bool leads, Journal* journal = nullptr);

  void on(const Event& event) override;
  void started(const pipeline::StageInfo& stage) override;
  void finished(const pipeline::StageInfo& stage, const pipeline::StageRecord& record) override;
  void fresh(const pipeline::StageInfo& stage) override;

  /// Stops when the user asked for it.
  [[nodiscard]] std::stop_token stop_token() const { return stop_.get_token(); }

 private:
  using Clock = std::chrono::steady_clock;
  void say(const std::string& line);    ///< a line that stays
  void renew(const std::string& line);  ///< the line that is overwritten
  [[nodiscard]] std::string remaining(double fraction) const;

  bool speaks_, verbose_, terminal_;
  Journal* journal_;
  std::stop_source stop_;
  std::string stage_, letter_;
  Clock::time_point begin_ = Clock::now(), last_shown_{}, last_noted_{};
  std::size_t width_ = 0;  // of the line to overwrite
};

}  // namespace sanatrix::app
