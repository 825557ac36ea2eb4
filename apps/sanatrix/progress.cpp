#include "progress.hpp"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

#include "interrupt.hpp"

namespace sanatrix::app {
namespace {

using namespace std::chrono_literals;
constexpr std::chrono::milliseconds terminal_pause = 100ms, plain_pause = 5s, journal_pause = 1s;

}  // namespace

Progress::Progress(const Common& common, bool leads, Journal* journal)
    : speaks_(leads && !common.quiet),
      verbose_(common.verbose),
      terminal_(::isatty(STDERR_FILENO) != 0),
      journal_(journal) {}

void Progress::say(const std::string& line) {
  if (speaks_) {
    renew("");
    fmt::print(stderr, "{}\n", line);
  }
}

void Progress::renew(const std::string& line) {
  if (!speaks_ || !terminal_ || (line.empty() && width_ == 0)) {
    return;
  }
  // Blanks instead of escape codes: works on every terminal and leaves logs clean.
  fmt::print(stderr, "\r{:<{}}{}", line, width_, line.empty() ? "\r" : "");
  std::fflush(stderr);
  width_ = line.size();
}

std::string Progress::remaining(double fraction) const {
  const double gone = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (fraction < 0.02 || gone < 1.0) {
    return "";
  }
  const auto left = static_cast<int>(std::lround(gone * (1.0 - fraction) / fraction));
  return fmt::format(", ETA {}:{:02}", left / 60, left % 60);
}

void Progress::on(const Event& event) {
  pass_on(stop_);
  if (event.detail && event.text.empty()) {
    return;
  }
  if (stage_ != event.stage) {
    stage_ = event.stage;
    begin_ = Clock::now();
  }
  const auto now = Clock::now();
  if (journal_ != nullptr && (event.detail || now - last_noted_ >= journal_pause)) {
    journal_->progress(event);
    last_noted_ = event.detail ? last_noted_ : now;
  }
  const std::string head = letter_.empty() ? stage_ : fmt::format("[{}] {}", letter_, stage_);
  if (event.detail) {
    if (verbose_) {
      say(fmt::format("{}: {}", head, event.text));
    }
    return;
  }
  if (now - last_shown_ < (terminal_ ? terminal_pause : plain_pause)) {
    return;
  }
  last_shown_ = now;
  const std::string line =
      fmt::format("{} {:3.0f} %{}{}{}", head, 100 * event.fraction, remaining(event.fraction),
                  event.text.empty() ? "" : ", ", event.text);
  terminal_ ? renew(line.substr(0, 100)) : say(line);
}

void Progress::started(const pipeline::StageInfo& stage) {
  letter_ = stage.letter;
  stage_ = stage.name;
  begin_ = last_shown_ = Clock::now();
  if (!terminal_) {
    say(fmt::format("[{}] {}: {}", stage.letter, stage.name, stage.title));
  }
  if (journal_ != nullptr) {
    journal_->started(stage);
  }
}

void Progress::finished(const pipeline::StageInfo& stage, const pipeline::StageRecord& record) {
  say(fmt::format("[{}] {}: done in {:.1f} s", stage.letter, stage.name, record.seconds));
  for (const std::string& warning : record.warnings) {
    say(fmt::format("[{}] {}: warning: {}", stage.letter, stage.name, warning));
  }
  if (journal_ != nullptr) {
    journal_->finished(stage, record);
  }
}

void Progress::fresh(const pipeline::StageInfo& stage) {
  if (verbose_) {
    say(fmt::format("[{}] {}: up to date", stage.letter, stage.name));
  }
}

}  // namespace sanatrix::app
