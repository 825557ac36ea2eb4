// Step A: the images as they were given. Labels stay in inputs/; a greyscale image must lie where
// the labels lie.
#include <optional>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/image_file.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

constexpr double frame_tolerance_mm = 30.0;  // crops differ; a wrong frame is off by far more

template <class T>
Vec3 centre_mm(const Image3<T>& image) {
  return image.position_mm(0.5 * (image.size[0] - 1), 0.5 * (image.size[1] - 1),
                           0.5 * (image.size[2] - 1));
}

}  // namespace

namespace {

template <class T>
void note_grid(const Image3<T>& image, StageNotes& notes) {
  notes.numbers = {{"size_i", image.size[0]},
                   {"size_j", image.size[1]},
                   {"size_k", image.size[2]},
                   {"spacing_i_mm", image.spacing_mm[0]},
                   {"spacing_j_mm", image.spacing_mm[1]},
                   {"spacing_k_mm", image.spacing_mm[2]}};
}

}  // namespace

StageNotes run_image(const StageInput& in) {
  StageNotes notes;
  std::optional<Image3<float>> image;
  if (in.patient.inputs.contains("image")) {
    image = during("image", [&] { return io::read_image(in.patient.input("image")); });
    note_grid(*image, notes);
  }
  if (in.patient.inputs.contains("image_facts")) {
    const auto facts = nlohmann::json::parse(read_text(in.patient.input("image_facts")));
    for (const auto& warning : facts.value("warnings", nlohmann::json::array())) {
      notes.warnings.push_back(warning.get<std::string>());
    }
  }
  if (!in.patient.inputs.contains("labels")) {
    return notes;
  }
  in.ctx.at(0.5, "labels");
  const LabelImage labels =
      during("labels", [&] { return io::read_labels(in.patient.input("labels")); });
  note_grid(labels, notes);
  if (image) {
    const double apart = norm(centre_mm(*image) - centre_mm(labels));
    if (apart > frame_tolerance_mm) {
      throw Error(Fault::Input,
                  fmt::format("image and labels do not lie in the same place: their centres are "
                              "{:.0f} mm apart",
                              apart),
                  "give an image and labels of the same frame of reference");
    }
  }
  return notes;
}

}  // namespace sanatrix::pipeline
