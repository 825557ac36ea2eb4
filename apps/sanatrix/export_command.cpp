// sanatrix export CASE|PROBLEM.json: the model for other programs.
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "core/files.hpp"
#include "pipeline/export.hpp"

namespace sanatrix::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string source, format, out, pose = "upright";
  int order = 1;
};

io::PeerFormat format_of(const std::string& name) {
  return name == "msh"   ? io::PeerFormat::Msh
         : name == "vtu" ? io::PeerFormat::Vtu
         : name == "feb" ? io::PeerFormat::Feb
                         : io::PeerFormat::Inp;
}

int write(const Arguments& given, const Common& common) {
  const fs::path source(given.source);
  const bool is_case = fs::is_directory(source);
  io::PeerModel model = is_case ? pipeline::export_case(pipeline::open_case(source), given.pose)
                                : pipeline::export_problem(pipeline::read_problem(source),
                                                           source.filename().string());
  model.order = given.order;
  const std::string stem = is_case
                               ? fs::weakly_canonical(source).filename().string() + "-" + given.pose
                               : source.stem().string();
  const fs::path file =
      given.out.empty() ? fs::path(stem + "." + given.format) : fs::path(given.out);
  io::write_peer(model, format_of(given.format), file);
  std::vector<std::string> files{file.string()};
  if (given.format == "msh" && given.order == 1) {
    fs::path problem = file;
    problem.replace_extension(".problem.json");
    write_text(problem, pipeline::problem_json(model, file.filename().string()));
    files.push_back(problem.string());
  }
  std::vector<std::string> notes = model.notes;
  if (given.format == "inp" && !model.membranes.empty()) {
    notes.emplace_back(
        "the skin is left out: Abaqus and CalculiX have no Veronda-Westmann membrane");
  }
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"files", files},
                                      {"notes", notes},
                                      {"vertices", model.mesh.points.size()},
                                      {"cells", model.mesh.cells.size()},
                                      {"materials", model.materials.size()},
                                      {"order", model.order}}
                           .dump(2));
    return 0;
  }
  for (const std::string& note : notes) {
    fmt::print(stderr, "sanatrix: note: {}\n", note);
  }
  for (const std::string& name : files) {
    fmt::print("wrote {}\n", name);
  }
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "export",
      "Examples: sanatrix export out/case --format feb --pose supine\n"
      "          sanatrix export hemisphere.json --format inp --order 2 --out hemisphere.inp\n\n"
      "Writes the mechanical model for Gmsh, ParaView, FEBio 4, Abaqus or CalculiX (SI units).");
  command->add_option("SOURCE", given->source, "case folder, or problem file of `sanatrix solve`")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--format", given->format, "msh, vtu, feb or inp")
      ->required()
      ->check(CLI::IsMember({"msh", "vtu", "feb", "inp"}));
  command->add_option("--order", given->order, "1: linear, 2: straight-sided quadratic cells")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  command->add_option("--pose", given->pose, "of a case: prone, supine or upright gravity")
      ->check(CLI::IsMember({"prone", "supine", "upright"}))
      ->capture_default_str();
  command->add_option("--out", given->out, "file to write (default: named after the source)");
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return write(*given, common);
    };
  });
}

}  // namespace sanatrix::app
