// sanatrix serve: the planner in the browser.
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "interrupt.hpp"
#include "server/serve.hpp"

namespace sanatrix::app {
namespace {

int work(const server::ServeOptions& options, const Common& common) {
  server::serve(
      options,
      [&](const std::string& address) {
        if (common.json) {
          fmt::print("{}\n", nlohmann::json{{"address", address}}.dump());
        } else {
          fmt::print(
              "the planner is at {}\nCtrl-C ends it; what is computing goes on next time.\n"
              "Research use only. Not a medical device.\n",
              address);
        }
        std::fflush(stdout);
      },
      interrupted);
  return 0;
}

}  // namespace

void add_serve(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<server::ServeOptions>();
  CLI::App* command = app.add_subcommand(
      "serve",
      "Example: sanatrix serve --cases out/cases --open\n\n"
      "The planner: plan, simulate and compare in the browser; on this machine only, unless\n"
      "--address, --certificate, --key and --token are all given.");
  command->add_option("--cases", given->cases, "folder of cases; made when it is not there")
      ->capture_default_str();
  command->add_option("--port", given->port, "0: any free one")->capture_default_str();
  command
      ->add_option("--address", given->address,
                   "IP address to listen on; another one than this machine's own needs TLS:")
      ->capture_default_str();
  command->add_option("--certificate", given->certificate, "TLS certificate chain (PEM)");
  command->add_option("--key", given->key, "its private key (PEM)");
  command->add_option("--token", given->token,
                      "file with the secret that lets browsers in, 32 letters and digits or more");
  command->add_option("--host", given->host, "name in the browser's address bar");
  command->add_flag("--open", given->open, "start the browser");
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return work(*given, common);
    };
  });
}

}  // namespace sanatrix::app
