// What a long computation is given besides its inputs: a way to say how far it is, a way to be
// stopped, and nothing global.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

namespace sanatrix {

struct Event {
  std::string_view stage;  ///< "unload"
  double fraction;         ///< 0..1 of the whole stage
  std::string text;        ///< "gravity 40 %, Newton 3, residual 2.1e-06"
  bool detail = false;     ///< true: only for -v
};

/// Implemented by the CLI and by the tests.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual void on(const Event& event) = 0;
};

/// Hears nothing; for tests and inner solves.
class Silent final : public Listener {
 public:
  void on(const Event&) override {}
};

/// Somebody pressed stop. Not an Error: nobody is at fault.
struct Cancelled final : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

class Context {
 public:
  Context(std::string_view stage, Listener& listener, std::stop_token stop = {},
          std::uint64_t seed = 1)
      : stage_(stage), listener_(&listener), stop_(std::move(stop)), seed_(seed) {}

  /// Call it often. Throws Cancelled when somebody pressed stop.
  void at(double fraction, std::string text = {}) const {
    report(fraction, std::move(text), false);
  }
  /// The same for lines that only a verbose run shows (Newton residuals).
  void detail(double fraction, std::string text) const { report(fraction, std::move(text), true); }
  /// The same work, reporting into a part of the bar.
  [[nodiscard]] Context part(double from, double to) const {
    Context c = *this;
    c.from_ = from_ + (to_ - from_) * from;
    c.to_ = from_ + (to_ - from_) * to;
    return c;
  }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  [[nodiscard]] std::string_view stage() const { return stage_; }

 private:
  void report(double fraction, std::string text, bool is_detail) const {
    if (stop_.stop_requested()) {
      throw Cancelled{};
    }
    listener_->on({stage_, from_ + (to_ - from_) * fraction, std::move(text), is_detail});
  }
  std::string_view stage_;
  Listener* listener_;
  std::stop_token stop_;
  std::uint64_t seed_;
  double from_ = 0.0, to_ = 1.0;
};

}  // namespace sanatrix
