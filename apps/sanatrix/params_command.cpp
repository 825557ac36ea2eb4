// sanatrix params: every parameter that --set knows.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "tables.hpp"

namespace sanatrix::app {

void add_params(CLI::App& app, Common& common, Command& chosen) {
  CLI::App* command = app.add_subcommand("params", "Lists the parameters of `sanatrix run --set`.");
  add_json(*command, common);
  command->callback([&common, &chosen] {
    chosen = [&common] {
      fmt::print("{}", common.json ? parameters_json().dump(2) + "\n" : parameters_text());
      return 0;
    };
  });
}

}  // namespace sanatrix::app
