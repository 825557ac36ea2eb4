// sanatrix score CASE PHANTOM: how far the case's shapes are from the phantom's truth.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "pipeline/phantom_files.hpp"

namespace sanatrix::app {
namespace {

nlohmann::json to_json(const pipeline::PoseScore& s) {
  return {{"mean_mm", s.mean_mm},
          {"p50_mm", s.p50_mm},
          {"p90_mm", s.p90_mm},
          {"p95_mm", s.p95_mm},
          {"max_mm", s.max_mm}};
}
nlohmann::json to_json(const pipeline::ChangeScore& s) {
  return {{"true_mean_mm", s.true_mean_mm},
          {"true_max_mm", s.true_max_mm},
          {"predicted_mean_mm", s.predicted_mean_mm},
          {"predicted_max_mm", s.predicted_max_mm},
          {"error_mean_mm", s.error_mean_mm},
          {"error_p95_mm", s.error_p95_mm},
          {"error_max_mm", s.error_max_mm}};
}

void print(const pipeline::Score& score) {
  for (const pipeline::PoseScore& s : score.poses) {
    fmt::print(
        "{:<22}surface error over the breasts: mean {:.2f} mm, 50 % {:.2f}, 90 % {:.2f}, "
        "95 % {:.2f}, max {:.2f}\n",
        s.pose, s.mean_mm, s.p50_mm, s.p90_mm, s.p95_mm, s.max_mm);
  }
  if (const auto& c = score.change) {
    fmt::print(
        "change by surgery, treated breast: true mean {:.2f} mm, max {:.2f}; predicted {:.2f}, "
        "{:.2f}; error mean {:.2f}, 95 % {:.2f}, max {:.2f}\n",
        c->true_mean_mm, c->true_max_mm, c->predicted_mean_mm, c->predicted_max_mm,
        c->error_mean_mm, c->error_p95_mm, c->error_max_mm);
  }
}

int show(const std::string& folder, const std::string& phantom, const Common& common) {
  const pipeline::Score score = pipeline::score(pipeline::open_case(folder), phantom);
  if (!score.note.empty()) {
    fmt::print(stderr, "sanatrix: note: nothing to say about surgery: {}\n", score.note);
  }
  if (!common.json) {
    print(score);
    return 0;
  }
  nlohmann::json j = nlohmann::json::object();
  for (const pipeline::PoseScore& s : score.poses) {
    j[s.pose] = to_json(s);
  }
  if (score.change) {
    j["change by surgery"] = to_json(*score.change);
  }
  fmt::print("{}\n", j.dump(2));
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
