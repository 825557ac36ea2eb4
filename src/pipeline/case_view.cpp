#include "pipeline/case_view.hpp"

#include "core/error.hpp"
#include "outcome/outcome.hpp"
#include "pipeline/artefacts.hpp"

namespace sanatrix::pipeline {
namespace {

using Places = std::vector<TetLocator::Place>;

Places places_of(std::span<const Vec3> points, const surgery::Anatomy& anatomy) {
  Places places;
  places.reserve(points.size());
  for (const Vec3& p : points) {
    places.push_back(anatomy.body().nearest(p));
  }
  return places;
}

std::vector<Vec3> placed(const TetMesh& mesh, const Places& places, std::span<const Vec3> pose) {
  std::vector<Vec3> result;
  result.reserve(places.size());
  for (const TetLocator::Place& place : places) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(place.cell)];
    Vec3 q{};
    for (std::size_t i = 0; i < 4; ++i) {
      q += place.barycentric[i] * pose[static_cast<std::size_t>(cell[i])];
    }
    result.push_back(q);
  }
  return result;
}

}  // namespace

CaseView::CaseView(const Case& patient) {
  const auto file = [&](Stage stage, const char* name) {
    return patient.stage_folder(stage) / name;
  };
  if (!std::filesystem::exists(file(Stage::Mesh, "model.bin"))) {
    throw Error(Fault::Input, "this case has no model yet", "run it at least to the stage mesh");
  }
  model_ = load_model(file(Stage::Mesh, "model.bin"));
  poses_["prone"] = model_.mesh.points;
  const auto volumes = outcome::tissue_volumes(
      model_.mesh, model_.mesh.points, model_.fibroglandular, model_.side, model_.in_breast);
  breast_cm3_ = {volumes[0].breast_cm3, volumes[1].breast_cm3};
  const std::array<std::tuple<const char*, Stage, const char*>, 5> others{
      {{"unloaded", Stage::Unload, "shape.bin"},
       {"supine", Stage::Supine, "shape.bin"},
       {"healed", Stage::Heal, "shape.bin"},
       {"before", Stage::Upright, "before.bin"},
       {"after", Stage::Upright, "after.bin"}}};
  for (const auto& [name, stage, shape_file] : others) {
    if (!std::filesystem::exists(file(stage, shape_file))) {
      continue;
    }
    const mechanics::Shape shape = load_shape(file(stage, shape_file)).shape;
    // A pose of an older, different mesh is of no use.
    if (shape.nodes.size() >= model_.mesh.points.size()) {
      const auto points = vertices(model_.mesh, shape);
      poses_[name] = {points.begin(), points.end()};
    }
  }
}

const std::vector<Vec3>& CaseView::pose(const std::string& name) const {
  const auto at = poses_.find(name);
  if (at == poses_.end()) {
    throw Error(Fault::Input, fmt::format("the pose \"{}\" has not been computed", name),
                "run the case further");
  }
  return at->second;
}

std::shared_ptr<const surgery::Anatomy> CaseView::anatomy(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<const surgery::Anatomy>& kept = anatomies_[name];
  if (kept == nullptr) {
    kept = std::make_shared<const surgery::Anatomy>(model_.mesh, pose(name), model_.midline_x_m);
  }
  return kept;
}

std::vector<Vec3> CaseView::carry(std::span<const Vec3> points, const std::string& from,
                                  const std::string& to) const {
  if (from == to || points.empty()) {
    return {points.begin(), points.end()};
  }
  return placed(model_.mesh, places_of(points, *anatomy(from)), pose(to));
}

std::map<std::string, std::vector<Vec3>> CaseView::carry_to_all(std::span<const Vec3> points,
                                                                const std::string& from) const {
  const auto places = places_of(points, *anatomy(from));
  std::map<std::string, std::vector<Vec3>> carried;
  for (const auto& [name, target] : poses_) {
    carried[name] = name == from ? std::vector<Vec3>(points.begin(), points.end())
                                 : placed(model_.mesh, places, target);
  }
  return carried;
}

std::string pose_of(surgery::Frame frame) {
  // "prone" is the pose in which the geometry was captured; of a standing scan it is upright.
  return frame == surgery::Frame::Supine ? "supine" : "prone";
}

surgery::Plan in_frame(const surgery::Plan& plan, surgery::Frame frame, const CaseView& view) {
  if (plan.frame == frame) {
    return plan;
  }
  const std::string from = pose_of(plan.frame), to = pose_of(frame);
  surgery::Plan moved = plan;
  moved.frame = frame;
  const Vec3 centre = plan.tumour_centre;
  moved.tumour_centre = view.carry(std::array<Vec3, 1>{centre}, from, to)[0];
  if (plan.axis) {
    // A short piece of the axis at the tumour turns with the tissue there.
    constexpr double piece = 5e-3;
    const auto ends = view.carry(
        std::array<Vec3, 2>{centre - piece * *plan.axis, centre + piece * *plan.axis}, from, to);
    moved.axis = normalised(ends[1] - ends[0]);
  }
  moved.outline = view.carry(plan.outline, from, to);
  if (moved.segment) {
    moved.segment->apex = view.carry(std::array<Vec3, 1>{plan.segment->apex}, from, to)[0];
  }
  for (auto& line : moved.incisions) {
    line = view.carry(line, from, to);
  }
  return moved;
}

}  // namespace sanatrix::pipeline
