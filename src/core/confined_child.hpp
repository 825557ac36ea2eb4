// Runs the reading of foreign files in a child process with limits, so that a crash, a bomb or an
// endless loop in a parser is an error of ours and nothing worse.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace sanatrix {

struct ChildLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< beyond what the caller already uses
  int seconds = 120;                                    ///< of CPU, and of waiting
  std::uint64_t answer_bytes = std::uint64_t{4} << 30;  ///< longest answer that is accepted
  std::uint64_t file_bytes = 0;  ///< largest file that it may write; 0: it can write none
};

/// Calls `work` in a forked child and returns the bytes that it returns. The child can write no
/// file unless `file_bytes` says so, opens few, and what it prints goes nowhere. An Error thrown by
/// `work` arrives with its fault, text and hint. A crash is Error{Input}, a breach of a limit
/// Error{Resource}; both begin with `activity` (which names the file).
std::string in_confined_child(const std::string& activity, const ChildLimits& limits,
                              const std::function<std::string()>& work);

}  // namespace sanatrix
