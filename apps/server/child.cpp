#include "child.hpp"

#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "guard.hpp"

extern char** environ;

namespace sanatrix::server {
namespace {

/// Field 22 of /proc/PID/stat; 0 when there is no such process or it is dead already.
unsigned long long start_of(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const auto name_end = text.rfind(')');  // the name may hold blanks
  if (name_end == std::string::npos) {
    return 0;
  }
  std::istringstream rest(text.substr(name_end + 1));
  std::string word, state;
  rest >> state;
  for (int field = 4; field <= 22; ++field) {
    rest >> word;
  }
  return state == "Z" ? 0 : std::stoull(word);
}

/// When memory runs out the kernel should end the simulation, never the server.
void prefer_as_victim(int pid) {
  std::ofstream("/proc/" + std::to_string(pid) + "/oom_score_adj") << "600";
}

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  void open(int descriptor, const std::string& file, int flags) {
    posix_spawn_file_actions_addopen(&actions_, descriptor, file.c_str(), flags, 0600);
  }
  /// Or the child would keep the server's port after the server is gone.
  void close_all_others() { posix_spawn_file_actions_addclosefrom_np(&actions_, 3); }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

}  // namespace

bool ProcessId::alive() const {
  return pid > 0 && start != 0 && start_of(pid) == start;
}

void ProcessId::interrupt() const {
  if (alive()) {
    ::kill(pid, SIGINT);
  }
}

ProcessId start_child(const std::vector<std::string>& words, const std::filesystem::path& output,
                      const std::filesystem::path& messages) {
  std::vector<std::string> all{"sanatrix"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : all) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  FileActions files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  files.open(STDOUT_FILENO, output, O_WRONLY | O_CREAT | O_TRUNC);
  files.open(STDERR_FILENO, messages, O_WRONLY | O_CREAT | O_TRUNC);
  files.close_all_others();
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // A group of its own: Ctrl-C at the server's terminal reaches the child through us only.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  sigset_t defaults;
  sigemptyset(&defaults);
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGCHLD}) {
    sigaddset(&defaults, signal);
  }
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  ProcessId child;
  const int problem =
      posix_spawn(&child.pid, "/proc/self/exe", files.get(), &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (problem != 0) {
    throw Error(Fault::Resource,
                "the simulation cannot be started: " + std::string(std::strerror(problem)),
                "check the free memory");
  }
  child.start = start_of(child.pid);
  prefer_as_victim(child.pid);
  return child;
}

std::optional<Exit> exit_of(const ProcessId& child) {
  int state = 0;
  const pid_t ended = ::waitpid(child.pid, &state, WNOHANG);
  if (ended == 0) {
    return std::nullopt;
  }
  if (ended < 0 || WIFEXITED(state)) {
    return Exit{.code = ended < 0 ? 6 : WEXITSTATUS(state)};
  }
  return Exit{.code = 4, .signal = WTERMSIG(state)};
}

std::string output_of(const std::vector<std::string>& words, const std::filesystem::path& folder,
                      std::chrono::seconds patience) {
  using namespace std::chrono_literals;
  const std::string name = random_name();
  const auto output = folder / (name + ".output"), messages = folder / (name + ".messages");
  const ProcessId child = start_child(words, output, messages);
  std::optional<Exit> exit;
  for (const auto end = std::chrono::steady_clock::now() + patience;
       !(exit = exit_of(child)) && std::chrono::steady_clock::now() < end;) {
    std::this_thread::sleep_for(10ms);
  }
  if (!exit) {
    ::kill(child.pid, SIGKILL);
    ::waitpid(child.pid, nullptr, 0);
  }
  std::string printed = read_text(output);
  const std::string told = told_by(messages);
  std::error_code none;
  std::filesystem::remove(output, none);
  std::filesystem::remove(messages, none);
  if (!exit) {
    throw Error(Fault::Resource, "this takes too long", "give less at once, or a faster disk");
  }
  require(exit->code == 0 && exit->signal == 0, "{}",
          told.empty() ? fmt::format("it ended with code {}", exit->code) : told);
  return printed;
}

std::string told_by(const std::filesystem::path& messages) {
  std::string line = last_line(messages);
  for (const std::string prefix : {"sanatrix: ", "error: "}) {
    if (line.starts_with(prefix)) {
      line.erase(0, prefix.size());
    }
  }
  return line;
}

std::string last_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, last;
  while (std::getline(in, line)) {
    if (line.find_first_not_of(" \r\t") != std::string::npos) {
      last = line;
    }
  }
  last.erase(last.find_last_not_of(" \r\t") + 1);
  return last;
}

}  // namespace sanatrix::server
