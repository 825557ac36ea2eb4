// sanatrix status CASE: which stages are fresh, stale, failed or missing, and why.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "tables.hpp"

namespace sanatrix::app {
namespace {

int show(const std::string& folder, const Common& common) {
  const pipeline::Case patient = pipeline::open_case(folder);
  const nlohmann::json stages = stages_json(patient);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"case", patient.pseudonym}, {"stages", stages}}.dump(2));
    return 0;
  }
  for (const nlohmann::json& stage : stages) {
    fmt::print("{:<4} {:<8} {:<8} {:>7.1f} s  {}\n", stage["letter"].get<std::string>(),
               stage["name"].get<std::string>(), stage["state"].get<std::string>(),
               stage["seconds"].get<double>(), stage["reason"].get<std::string>());
  }
  return 0;
}

}  // namespace

void add_status(CLI::App& app, Common& common, Command& chosen) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("status",
                         "Example: sanatrix status out/case --json\n\n"
                         "Says which stages are fresh, stale, failed or missing, and why.");
  command->add_option("CASE", *folder, "case folder")->required();
  add_json(*command, common);
  command->callback([folder, &common, &chosen] {
    chosen = [=, &common] {
      return show(*folder, common);
    };
  });
}

}  // namespace sanatrix::app
