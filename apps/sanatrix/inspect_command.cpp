// sanatrix inspect PATH: what is there and what would be chosen, without importing anything.
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "commands.hpp"
#include "pipeline/intake.hpp"
#include "unpacked.hpp"

namespace sanatrix::app {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string numbers(const json& list, const char* between) {
  std::string text;
  for (const json& value : list) {
    text += fmt::format("{}{:.4g}", text.empty() ? "" : between, value.get<double>());
  }
  return text;
}

std::string series_text(const json& s) {
  std::string text =
      fmt::format("{} series {:<2} {} {:<7} {:<10} {:<4} {} voxels of {} mm",
                  s.at("chosen").get<bool>() ? "*" : " ", s.at("series").get<int>(),
                  s.at("modality").get<std::string>(), s.at("weighting").get<std::string>(),
                  s.at("plane").get<std::string>(), s.at("patient_position").get<std::string>(),
                  numbers(s.at("size"), " x "), numbers(s.at("spacing_mm"), " x "));
  if (s.contains("not_chosen_because")) {
    text += "\n            not chosen: " + s["not_chosen_because"].get<std::string>();
  }
  for (const json& warning : s.at("warnings")) {
    text += "\n            warning: " + warning.get<std::string>();
  }
  return text + "\n";
}

std::string text_of(const json& j) {
  if (j.at("kind") != "DICOM") {
    return fmt::format("{}: {} voxels of {} mm, first voxel at LPS {} mm, values {:g} to {:g}\n",
                       j.at("kind").get<std::string>(), numbers(j.at("size"), " x "),
                       numbers(j.at("spacing_mm"), " x "), numbers(j.at("origin_lps_mm"), ", "),
                       j.at("value_min").get<double>(), j.at("value_max").get<double>());
  }
  std::string text;
  for (const json& series : j.at("series")) {
    text += series_text(series);
  }
  text += fmt::format(
      "{} files, {} without an image; {} data elements ({} private) would be left behind\n",
      j.at("files").get<int>(), j.at("files_without_image").get<int>(),
      j.at("elements_that_would_be_left_behind").get<long>(), j.at("private_elements").get<long>());
  return text + (j.contains("nothing_chosen")
                     ? "nothing would be chosen: " + j["nothing_chosen"].get<std::string>() + "\n"
                     : "* would be chosen\n");
}

}  // namespace

void add_inspect(CLI::App& app, Common& common, Command& chosen) {
  struct Arguments {
    std::string path;
    int series = 0;
  };
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "inspect",
      "Example: sanatrix inspect dicom-folder\n\n"
      "Lists the series of a DICOM folder or .zip, or what an image file holds, and what `sanatrix "
      "new`\n"
      "would choose. Imports nothing and prints nothing that identifies the patient.");
  command->add_option("PATH", given->path, "DICOM folder, image file, or a .zip of these")
      ->required();
  command->add_option("--series", given->series, "as if this series were asked for")
      ->check(CLI::Range(1, 100000));
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      // Unpacked where it may be removed again: the archive's own folder may be read-only.
      Unpacked unpacked(fs::temp_directory_path() / fmt::format("inspect-{}", ::getpid()));
      const std::string found =
          pipeline::inspect_image(unpacked(given->path).value_or(""), given->series);
      fmt::print("{}{}", common.json ? found : text_of(json::parse(found)),
                 common.json ? "\n" : "");
      return 0;
    };
  });
}

}  // namespace sanatrix::app
