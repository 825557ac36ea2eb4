// sanatrix report CASE and sanatrix compare CASE CASE ...: pages for people.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "progress.hpp"
#include "report/report.hpp"
#include "version.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::vector<std::string> folders;
  std::string out = "comparison.html";
  bool animations = false, photographs = false;
};

report::Program program(const Common& common) {
  const Version& v = version();
  std::string command = "sanatrix";
  for (const std::string& word : common.arguments) {
    // Folders may name a person: only their last part is kept.
    const bool is_option = word.starts_with("-");
    command += " " + (is_option ? word : std::filesystem::path(word).filename().string());
  }
  return {fmt::format("sanatrix {} (commit {}, {}, {})", v.number, v.commit, v.compiler, v.build),
          v.libraries, command};
}

int write(const Arguments& given, const Common& common) {
  Progress progress(common, true, nullptr);
  const pipeline::Case patient = pipeline::open_case(given.folders.front());
  const pipeline::CaseLock lock(given.folders.front());
  const report::Options options{
      given.animations ? report::Animations::Yes : report::Animations::No,
      given.photographs ? report::Photographs::Yes : report::Photographs::No};
  const report::Written written = report::write_report(
      patient, options, program(common), Context("report", progress, progress.stop_token()));
  for (const std::string& note : written.notes) {
    fmt::print(stderr, "sanatrix: note: {}\n", note);
  }
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"folder", written.folder.string()},
                                      {"files", written.files},
                                      {"notes", written.notes}}
                           .dump(2));
  } else {
    fmt::print("{}\n", (written.folder / written.files.front()).string());
  }
  return 0;
}

int compare(const Arguments& given, const Common& common) {
  Progress progress(common, true, nullptr);
  std::vector<pipeline::Case> cases;
  for (const std::string& folder : given.folders) {
    cases.push_back(pipeline::open_case(folder));
  }
  report::write_comparison(cases, program(common), given.out,
                           Context("compare", progress, progress.stop_token()));
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"file", given.out}}.dump(2));
  } else {
    fmt::print("{}\n", given.out);
  }
  return 0;
}

}  // namespace

void add_report(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "report",
      "Example: sanatrix report out/case\n\n"
      "Writes stages/95-report: report.html (all in one file), report.pdf when Chromium is there,\n"
      "pictures, GLB, OBJ and STL (docs/user/report.md).");
  command->add_option("CASE", given->folders, "case folder")->required()->expected(1);
  command->add_flag("--animations", given->animations, "also videos of healing, through ffmpeg");
  command->add_flag("--photographs", given->photographs,
                    "put the patient's photographed skin into GLB and OBJ files");
  add_json(*command, common);
  add_progress(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return write(*given, common);
    };
  });
}

void add_compare(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("compare",
                         "Example: sanatrix compare out/plan-a out/plan-b --out comparison.html\n\n"
                         "Cases side by side on one page, same cameras and scales.");
  command->add_option("CASE", given->folders, "case folders")->required()->expected(2, 12);
  command->add_option("--out", given->out, "HTML file to write")->capture_default_str();
  add_json(*command, common);
  add_progress(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return compare(*given, common);
    };
  });
}

}  // namespace sanatrix::app
