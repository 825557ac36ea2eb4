#include "pipeline/result.hpp"

#include <algorithm>

#include "core/files.hpp"
#include "pipeline/json_object.hpp"
#include "pipeline/segmentation_store.hpp"
#include "pipeline/standing_scan.hpp"

namespace sanatrix::pipeline {

CaseResult load_result(const Case& patient) {
  const auto file = [&](Stage stage, const char* name) {
    return patient.stage_folder(stage) / name;
  };
  CaseResult result{
      .model = load_model(file(Stage::Mesh, "model.bin")),
      .plan = surgery::read_plan(read_text(file(Stage::Surgery, "plan.json")), "plan.json"),
      .wound = load_wound(file(Stage::Surgery, "wound.bin")),
      .unloaded = load_shape(file(Stage::Unload, "shape.bin")),
      .supine = load_shape(file(Stage::Supine, "shape.bin")),
      .healed = load_shape(file(Stage::Heal, "shape.bin")),
      .before = load_shape(file(Stage::Upright, "before.bin")),
      .after = load_shape(file(Stage::Upright, "after.bin")),
      .history = load_history(file(Stage::Heal, "history.bin")),
      .species = {},
      .frames = {},
      .landmarks = {},
      .standing = patient.scan_only()};
  const auto biology = healing::make_model(patient.parameters.text("heal.preset"),
                                           patient.parameters.list("heal.overrides"));
  result.species.assign(biology->species().begin(), biology->species().end());
  for (const auto& entry : std::filesystem::directory_iterator(file(Stage::Heal, "frames"))) {
    if (entry.path().extension() == ".bin") {
      result.frames.push_back(load_frame(entry.path()));
    }
  }
  // Above the breasts the skin lies on bone: the notch is in the same place in every pose. A plan
  // knows best.
  const nlohmann::json plan = nlohmann::json::parse(result.plan.document, nullptr, false);
  if (plan.is_object() && plan.contains("sternal_notch_lps_mm")) {
    const std::vector<double> mm = JsonObject(plan, "plan").numbers("sternal_notch_lps_mm", 3);
    result.landmarks["sternal_notch"] = 1e-3 * Vec3{mm[0], mm[1], mm[2]};
  }
  const auto notch = result.standing ? load_standing_scan(patient).sternal_notch
                                     : sure_sternal_notch(patient.stage_folder(Stage::Segment));
  if (notch) {
    result.landmarks.try_emplace("sternal_notch", *notch);
  }
  std::ranges::sort(result.frames, {}, &Frame::t_day);
  return result;
}

}  // namespace sanatrix::pipeline
