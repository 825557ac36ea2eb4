#include "pipeline/result.hpp"

#include <algorithm>

namespace sanatrix::pipeline {

CaseResult load_result(const Case& patient) {
  const auto file = [&](Stage stage, const char* name) {
    return patient.stage_folder(stage) / name;
  };
  CaseResult result{.model = load_model(file(Stage::Mesh, "model.bin")),
                    .plan = patient.plan(),
                    .wound = load_wound(file(Stage::Surgery, "wound.bin")),
                    .unloaded = load_shape(file(Stage::Unload, "shape.bin")),
                    .supine = load_shape(file(Stage::Supine, "shape.bin")),
                    .healed = load_shape(file(Stage::Heal, "shape.bin")),
                    .before = load_shape(file(Stage::Upright, "before.bin")),
                    .after = load_shape(file(Stage::Upright, "after.bin")),
                    .history = load_history(file(Stage::Heal, "history.bin")),
                    .species = {},
                    .frames = {},
                    .landmarks = {}};
  const auto biology = healing::make_model(patient.parameters.text("heal.preset"),
                                           patient.parameters.list("heal.overrides"));
  result.species.assign(biology->species().begin(), biology->species().end());
  for (const auto& entry : std::filesystem::directory_iterator(file(Stage::Heal, "frames"))) {
    if (entry.path().extension() == ".bin") {
      result.frames.push_back(load_frame(entry.path()));
    }
  }
  std::ranges::sort(result.frames, {}, &Frame::t_day);
  return result;
}

}  // namespace sanatrix::pipeline
