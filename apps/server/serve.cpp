#include "serve.hpp"

#include <chrono>
#include <csignal>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <spawn.h>

#include "child.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "planner.hpp"

extern char** environ;

namespace sanatrix::server {
namespace {

namespace fs = std::filesystem;

Abilities abilities_of_this_build(const fs::path& folder) {
  using namespace std::chrono_literals;
  const std::string make = output_of({"new", "--help"}, folder, 20s),
                    all = output_of({"--help"}, folder, 20s);
  return {.dicom = make.find("--series") != std::string::npos,
          .scan = make.find("--scan") != std::string::npos,
          .scan_only = make.find("--pose") != std::string::npos,
          .tumour = make.find("--tumour") != std::string::npos,
          .report = all.find("\n  report ") != std::string::npos};
}

/// Only one server may keep one folder's queue.
class OnlyOne {
 public:
  explicit OnlyOne(const fs::path& file)
      : file_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    struct flock lock {};
    lock.l_type = F_WRLCK;
    if (file_ < 0 || ::fcntl(file_, F_SETLK, &lock) != 0) {
      throw Error(Fault::Resource, "another planner is serving these cases already",
                  "use its window, or give another folder with --cases");
    }
  }
  OnlyOne(const OnlyOne&) = delete;
  OnlyOne& operator=(const OnlyOne&) = delete;

 private:
  int file_;  // closed by the kernel, together with the lock
};

/// Beyond this machine only with everything that protects it there.
void check_address(const ServeOptions& options) {
  const bool at_home = options.address == "127.0.0.1" || options.address == "::1";
  std::string missing;
  for (const auto& [name, value] : {std::pair{"--certificate", &options.certificate},
                                    {"--key", &options.key},
                                    {"--token", &options.token}}) {
    if (value->empty()) {
      missing += missing.empty() ? name : std::string(", ") + name;
    }
  }
  if (!at_home && !missing.empty()) {
    throw Error(Fault::Usage,
                fmt::format("--address {} offers the planner to other machines; missing: {}",
                            options.address, missing),
                "leave --address out, or see docs/user/planner.md, Safety");
  }
  if (options.certificate.empty() != options.key.empty()) {
    throw Error(Fault::Usage, "--certificate and --key go together");
  }
}

std::string token_of(const ServeOptions& options) {
  if (options.token.empty()) {
    return {};
  }
  std::string token = read_text(options.token);
  token.erase(token.find_last_not_of(" \r\n\t") + 1);
  require(token.size() >= 32 &&
              token.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz"
                                      "ABCDEFGHIJKLMNOPQRSTUVWXYZ_-") == std::string::npos,
          "the file of --token must hold one word of at least 32 letters and digits, such as "
          "`openssl rand -hex 16` prints");
  return token;
}

void open_browser(std::string address) {
  std::string program = "xdg-open";
  std::vector<char*> argv{program.data(), address.data(), nullptr};
  pid_t child = 0;
  posix_spawnp(&child, program.c_str(), nullptr, nullptr, argv.data(), environ);
}

}  // namespace

void serve(const ServeOptions& options, const std::function<void(const std::string&)>& ready,
           const std::function<bool()>& stop) {
  std::signal(SIGPIPE, SIG_IGN);
  check_address(options);
  const std::string token = token_of(options);
  CaseStore cases(options.cases);
  const OnlyOne only(cases.own_folder() / "lock");
  const Abilities abilities = abilities_of_this_build(cases.own_folder());
  JobQueue jobs(cases.own_folder(), cases.root());
  Planner planner(cases, jobs, abilities);
  HttpServer server({.address = options.address,
                     .port = options.port,
                     .certificate = options.certificate,
                     .key = options.key},
                    planner);
  const Guard guard({.port = server.port(),
                     .name = options.host.empty() ? options.address : options.host,
                     .secret = !options.certificate.empty(),
                     .token = token},
                    cases.own_folder() / "keys");
  planner.admit(guard);
  ready(guard.start_address());
  if (options.open) {
    open_browser(guard.start_address());
  }
  server.run(stop);
}

}  // namespace sanatrix::server
