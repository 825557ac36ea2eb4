// A time limit that long loops look at.
#pragma once

#include <chrono>

#include "core/error.hpp"

namespace sanatrix::meshing {

class Deadline {
 public:
  explicit Deadline(double seconds)
      : limit_s_(seconds),
        end_(Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))) {}
  [[nodiscard]] double left_s() const {
    return std::chrono::duration<double>(end_ - Clock::now()).count();
  }
  /// Error{Resource} when the time is up.
  void check() const {
    if (left_s() <= 0.0) {
      throw Error(Fault::Resource, fmt::format("meshing took longer than {:g} s", limit_s_),
                  "ask for fewer vertices or raise the time limit (mesh.time_limit_s); a rough "
                  "skin takes long: smooth the labels or the scan");
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  double limit_s_;
  Clock::time_point end_;
};

}  // namespace sanatrix::meshing
