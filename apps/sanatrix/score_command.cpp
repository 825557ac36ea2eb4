// sanatrix score CASE PHANTOM: how far the case's shapes are from the phantom's truth.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "pipeline/phantom_files.hpp"

namespace sanatrix::app {
namespace {

int show(const std::string& folder, const std::string& phantom, const Common& common) {
  const pipeline::Case patient = pipeline::open_case(folder);
  const std::vector<pipeline::PoseScore> scores = pipeline::score(patient, phantom);
  nlohmann::json j = nlohmann::json::object();
  for (const pipeline::PoseScore& s : scores) {
    j[s.pose] = {{"mean_mm", s.mean_mm},
                 {"p50_mm", s.p50_mm},
                 {"p90_mm", s.p90_mm},
                 {"p95_mm", s.p95_mm},
                 {"max_mm", s.max_mm}};
    if (!common.json) {
      fmt::print(
          "{:<9} surface error over the breasts: mean {:.2f} mm, 50 % {:.2f}, 90 % {:.2f}, "
          "95 % {:.2f}, max {:.2f}\n",
          s.pose, s.mean_mm, s.p50_mm, s.p90_mm, s.p95_mm, s.max_mm);
    }
  }
  if (common.json) {
    fmt::print("{}\n", j.dump(2));
  }
  return 0;
}

}  // namespace

void add_score(CLI::App& app, Common& common, Command& chosen) {
  struct Arguments {
    std::string folder, phantom;
  };
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "score",
      "Example: sanatrix score out/case out/phantom\n\n"
      "Compares the shapes of a case made from a phantom with the phantom's truth.");
  command->add_option("CASE", given->folder, "case folder")->required();
  command->add_option("PHANTOM", given->phantom, "folder of `sanatrix phantom`")->required();
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return show(given->folder, given->phantom, common);
    };
  });
}

}  // namespace sanatrix::app
