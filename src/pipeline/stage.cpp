#include "pipeline/stage.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace sanatrix::pipeline {

const std::array<StageInfo, 9>& all_stages() {
  using enum Stage;
  static const std::vector<std::string> body{"tissue.", "skin.", "solver."};
  static const std::array<StageInfo, 9> table{{
      {Image, "image", "10-image", "A", "reading the images", 1, {}, {}, false},
      {Segment, "segment", "20-segment", "B", "segmenting", 13, {Image}, {"segment."}, false},
      {Mesh, "mesh", "30-mesh", "C-D", "meshing", 4, {Segment}, {"mesh."}, false},
      {Unload, "unload", "40-unload", "E", "unloading", 2, {Mesh}, body, true},
      {Supine, "supine", "50-supine", "F", "supine pose", 1, {Mesh, Unload}, body, true},
      {Surgery, "surgery", "60-surgery", "G", "surgery", 2, {Mesh, Supine}, {"surgery."}, false},
      {Heal,
       "heal",
       "70-heal",
       "H",
       "healing",
       6,
       {Mesh, Unload, Supine, Surgery},
       {"tissue.", "skin.", "solver.", "heal."},
       true},
      {Upright,
       "upright",
       "80-upright",
       "I-J",
       "upright before and after",
       1,
       {Mesh, Unload, Heal},
       body,
       true},
      {Outcome,
       "outcome",
       "90-outcome",
       "I-J",
       "outcome",
       5,
       {Segment, Mesh, Unload, Supine, Surgery, Heal, Upright},
       {"outcome."},
       false},
  }};
  return table;
}

const StageInfo& info(Stage stage) {
  return all_stages()[static_cast<std::size_t>(stage)];
}

Stage parse_stage(const std::string& name) {
  std::string known;
  for (const StageInfo& stage : all_stages()) {
    if (stage.name == name) {
      return stage.id;
    }
    known += (known.empty() ? "" : ", ") + stage.name;
  }
  throw Error(Fault::Usage, fmt::format("there is no stage '{}'", name),
              fmt::format("write one of: {}", known));
}

}  // namespace sanatrix::pipeline
