// sanatrix phantom DIR: writes the built-in synthetic patient.
#include <fmt/format.h>

#include "commands.hpp"
#include "interrupt.hpp"
#include "mpi_team.hpp"
#include "pipeline/phantom_files.hpp"
#include "progress.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::string folder;
  phantom::Options options;
  std::string density = "scattered";
};

int make(const Arguments& given, const Common& common) {
  return with_team([&](pipeline::Team& team) {
    phantom::Options options = given.options;
    options.density = phantom::parse_density(given.density);
    if (team.leads()) {
      pipeline::make_phantom_folder(given.folder);
    }
    Progress progress(common, team.leads());
    const Context ctx("phantom", progress, progress.stop_token(), options.seed);
    const phantom::Phantom made = phantom::make_phantom(options, ctx);
    if (!team.leads()) {
      return;
    }
    const std::string truth = pipeline::write_phantom(made, options, given.folder);
    if (common.json) {
      fmt::print("{}", truth);
    } else {
      fmt::print("wrote labels.nii.gz, plan.json and truth/ into {}\n", given.folder);
    }
  });
}

}  // namespace

void add_phantom(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "phantom",
      "Example: sanatrix phantom out/phantom --seed 7 --volume-cm3 450 --density dense\n\n"
      "Writes the built-in synthetic patient: prone labels, a plan, and the true shapes.");
  command->add_option("DIR", given->folder, "folder to write")->required();
  command->add_option("--seed", given->options.seed, "another number, another patient")
      ->capture_default_str();
  command->add_option("--volume-cm3", given->options.volume_cm3, "of one breast, unloaded")
      ->check(CLI::Range(150.0, 1500.0))
      ->capture_default_str();
  command->add_option("--density", given->density, "fatty, scattered, heterogeneous or dense")
      ->check(CLI::IsMember({"fatty", "scattered", "heterogeneous", "dense"}))
      ->capture_default_str();
  add_json(*command, common);
  add_progress(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return make(*given, common);
    };
  });
}

}  // namespace sanatrix::app
