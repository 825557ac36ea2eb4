// One exception type: whose fault it is, what happened, where in the work, and what to do next.
#pragma once

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace sanatrix {

/// Whose fault it is; decides the exit code of the command.
enum class Fault {
  Usage,     ///< the command line is wrong                                   exit 1
  Input,     ///< a file, a value or a patient's data cannot be used          exit 2
  Numerics,  ///< the model did not converge                                  exit 3
  Resource,  ///< disk, memory or time limit                                  exit 4
  Internal,  ///< an invariant of ours is broken                              exit 6
};
/// Exit code of a run that was interrupted and can be resumed.
inline constexpr int exit_interrupted = 5;
int exit_code(Fault fault);

class Error : public std::exception {
 public:
  /// what: names the thing, the place and the cause; hint: the next action for the user.
  Error(Fault fault, std::string what, std::string hint = {})
      : fault_(fault), what_(std::move(what)), hint_(std::move(hint)) {}

  [[nodiscard]] const char* what() const noexcept override { return what_.c_str(); }
  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  [[nodiscard]] const std::string& hint() const noexcept { return hint_; }
  [[nodiscard]] const std::vector<std::string>& trail() const noexcept { return trail_; }
  void passing_through(std::string activity) { trail_.push_back(std::move(activity)); }
  /// "unload: gravity 40 %: what (hint)" on one line.
  [[nodiscard]] std::string one_line() const;

 private:
  Fault fault_;
  std::string what_, hint_;
  std::vector<std::string> trail_;  // innermost first
};

/// Precondition on what a user, a file or a patient's data gave us. Always on.
template <class... A>
void require(bool ok, fmt::format_string<A...> text, A&&... args) {
  if (!ok) [[unlikely]] {
    throw Error(Fault::Input, fmt::format(text, std::forward<A>(args)...));
  }
}

/// Invariant of our own code. Always on, cheap enough to stay on.
template <class... A>
void ensure(bool ok, fmt::format_string<A...> text, A&&... args) {
  if (!ok) [[unlikely]] {
    throw Error(Fault::Internal, fmt::format(text, std::forward<A>(args)...),
                "this is a defect of Sanatrix: please report it with the case's run.log");
  }
}

/// Runs work; an Error that leaves it has this activity written on its trail.
template <class F>
decltype(auto) during(std::string activity, F&& work) {
  try {
    return std::forward<F>(work)();
  } catch (Error& e) {
    e.passing_through(std::move(activity));
    throw;
  }
}

}  // namespace sanatrix
