// sanatrix version: what this program was made of.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "version.hpp"

namespace sanatrix::app {

void add_version(CLI::App& app, Common& common, Command& chosen) {
  CLI::App* command = app.add_subcommand("version", "Prints version, commit, compiler, libraries.");
  add_json(*command, common);
  command->callback([&common, &chosen] {
    chosen = [&common] {
      const Version& v = version();
      if (common.json) {
        fmt::print("{}\n", nlohmann::json{{"version", v.number},
                                          {"commit", v.commit},
                                          {"compiler", v.compiler},
                                          {"build", v.build},
                                          {"libraries", v.libraries}}
                               .dump(2));
      } else {
        fmt::print("{}\n", version_text());
      }
      return 0;
    };
  });
}

}  // namespace sanatrix::app
