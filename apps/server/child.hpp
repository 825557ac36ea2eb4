// Child processes of this program: started without a shell, watched, stopped politely.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sanatrix::server {

/// A process that is not mistaken for a later one of the same number.
struct ProcessId {
  int pid = 0;
  unsigned long long start = 0;  ///< kernel ticks since boot
  [[nodiscard]] bool alive() const;
  /// SIGINT: stop at the next safe point. A second one: stop now.
  void interrupt() const;
};

struct Exit {
  int code = 0;    ///< of the program
  int signal = 0;  ///< that ended it; 0: none
};

/// Starts this very program with these words; output and messages go to files. Error{Resource}.
ProcessId start_child(const std::vector<std::string>& words, const std::filesystem::path& output,
                      const std::filesystem::path& messages);
/// Nothing while the child lives.
std::optional<Exit> exit_of(const ProcessId& child);
/// What this program prints when it is asked with these words; files of ours go to `folder` and are
/// removed. Error{Input} with its last line when it fails, Error{Resource} when it takes too long.
std::string output_of(const std::vector<std::string>& words, const std::filesystem::path& folder,
                      std::chrono::seconds patience);
/// What a failed command says: its last line without the program's name.
std::string told_by(const std::filesystem::path& messages);
/// The last line of a file of messages, without trailing blanks; empty when there is none.
std::string last_line(const std::filesystem::path& file);

}  // namespace sanatrix::server
