// sanatrix new CASE: makes a case folder from labels.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "pipeline/case.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::string folder, labels, image, plan;
  std::string preset = "sanatrix";
  ScanOptions scans;
};

int make(const Arguments& given, const Common& common) {
  pipeline::NewCase inputs{.labels = given.labels,
                           .label_preset = given.preset,
                           .image = {},
                           .plan = {},
                           .scans = given.scans.given()};
  if (!given.image.empty()) {
    inputs.image = given.image;
  }
  if (!given.plan.empty()) {
    inputs.plan = given.plan;
  }
  const pipeline::Case made = pipeline::create_case(given.folder, inputs);
  if (common.json) {
    nlohmann::json j{{"case", made.pseudonym}, {"inputs", nlohmann::json::object()}};
    for (const auto& [name, input] : made.inputs) {
      j["inputs"][name] = input.sha256;
    }
    fmt::print("{}\n", j.dump(2));
  } else {
    fmt::print("created {} ({}); next: sanatrix run {}\n", given.folder, made.pseudonym,
               given.folder);
  }
  return 0;
}

}  // namespace

void add_new(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "new",
      "Example: sanatrix new out/case --labels labels.nii.gz --plan plan.json\n\n"
      "Creates a case folder from a labelled prone MRI (docs/user/labels.md, plan.md).");
  command->add_option("CASE", given->folder, "folder to create")->required();
  command->add_option("--labels", given->labels, "label volume: .nii.gz, .nii, .nrrd, .mha")
      ->required();
  command->add_option("--image", given->image, "greyscale image of the same frame");
  command->add_option("--labels-preset", given->preset, "label table: sanatrix or pelicano")
      ->capture_default_str();
  command->add_option("--plan", given->plan, "surgical plan (JSON)");
  given->scans.add_to(*command);
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return make(*given, common);
    };
  });
}

}  // namespace sanatrix::app
