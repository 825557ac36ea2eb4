#include "pipeline/wall_range.hpp"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/files.hpp"
#include "pipeline/sweep.hpp"
#include "standing/chest_wall.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// 1 sd [mm] of a wall that was seen in an image or drawn: assumed, five times its mean distance
/// from the truth of synthetic images (docs/theory/segmentation.md).
constexpr double image_wall_doubt_mm = 2.0;

struct Variant {
  const char* key;
  double deeper;  ///< in standard deviations
};
constexpr std::array variants{Variant{"nearer", -1.0}, Variant{"deeper", 1.0}};

double doubt_mm(const Case& patient) {
  return patient.scan_only() ? standing::wall_doubt_mm : image_wall_doubt_mm;
}

Sweep sweep_of(const Case& patient) {
  Sweep sweep;
  sweep.case_folder = patient.folder;
  sweep.out = patient.folder / "wall-range";
  return sweep;
}

SweepTask task_of(const Case& patient, const Variant& variant) {
  const double shift = patient.parameters.number("segment.wall_shift_mm");
  return make_task(
      patient, {},
      {{"segment.wall_shift_mm", fmt::format("{}", shift + variant.deeper * doubt_mm(patient))},
       {"outcome.wall_range", "no"}});
}

/// Shows the stages of a variant as progress of the stage that wants it.
class Inside final : public Monitor {
 public:
  Inside(Monitor& outer, std::string what, double from)
      : outer_(outer), what_(std::move(what)), from_(from) {}
  void on(const Event& event) override {
    const double done = (static_cast<double>(stage_) + event.fraction) / all_stages().size();
    const double share = 1.0 / variants.size();
    outer_.on({info(Stage::Outcome).name, from_ + share * done,
               fmt::format("{}, {} {}", what_, event.stage, event.text), event.detail});
  }
  void started(const StageInfo& stage) override { stage_ = static_cast<int>(stage.id); }
  void finished(const StageInfo&, const StageRecord&) override {}
  void fresh(const StageInfo&) override {}

 private:
  Monitor& outer_;
  std::string what_;
  double from_;
  int stage_ = 0;
};

/// Of a number of the case and of both variants, as far as they could be computed.
json range_of(const json& own, const std::vector<const json*>& others) {
  if (!own.is_number()) {
    return nullptr;
  }
  double low = own, high = own;
  for (const json* other : others) {
    if (other->is_number()) {
      low = std::min(low, other->get<double>());
      high = std::max(high, other->get<double>());
    }
  }
  return {{"low", low}, {"high", high}};
}

void add_index_ranges(json& outcome, const std::vector<json>& variants_found) {
  for (json& metric : outcome["cosmetics"]["metrics"]) {
    std::vector<const json*> changes;
    for (const json& found : variants_found) {
      for (const json& other : found.at("cosmetics").at("metrics")) {
        if (other.at("key") == metric.at("key")) {
          changes.push_back(&other.at("change"));
        }
      }
    }
    metric["wall_range"] = changes.empty() ? json() : range_of(metric.at("change"), changes);
  }
}

}  // namespace

void run_wall_variants(const Case& patient, Monitor& monitor, Team& team,
                       const std::stop_token& stop) {
  if (patient.parameters.text("outcome.wall_range") != "yes") {
    return;
  }
  const Sweep sweep = sweep_of(patient);
  double done = 0.0;
  for (const Variant& variant : variants) {
    Inside inside(monitor, fmt::format("chest wall {:g} mm {}", doubt_mm(patient), variant.key),
                  done);
    run_task(sweep, task_of(patient, variant), inside, team, stop);
    done += 1.0 / variants.size();
  }
}

void add_wall_range(const Case& patient, json& outcome) {
  outcome["wall_range"] = nullptr;
  std::vector<json> found;
  if (patient.parameters.text("outcome.wall_range") == "yes") {
    const Sweep sweep = sweep_of(patient);
    json range{{"moved_mm", doubt_mm(patient)}, {"failed", json::object()}};
    for (const Variant& variant : variants) {
      const json result = json::parse(read_text(sweep.result_file(task_of(patient, variant))));
      if (result.at("status") == "ok") {
        found.push_back(result.at("outcome"));
      } else {
        range["failed"][variant.key] = result.at("error");
      }
    }
    for (const char* key :
         {"/breast_volume_cm3/R", "/breast_volume_cm3/L", "/excised_cm3", "/excised_percent",
          "/resection_to_chest_mm", "/wound_volume_ratio_final", "/max_displacement_upright_mm",
          "/mean_displacement_upright_mm"}) {
      const json::json_pointer at(key);
      std::vector<const json*> others;
      for (const json& other : found) {
        others.push_back(&other.at(at));
      }
      range[at] = range_of(outcome.at(at), others);
    }
    outcome["wall_range"] = std::move(range);
  }
  add_index_ranges(outcome, found);
}

}  // namespace sanatrix::pipeline
