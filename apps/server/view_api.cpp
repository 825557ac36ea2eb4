#include "view_api.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "bundle.hpp"
#include "core/error.hpp"
#include "geometry/image_filters.hpp"
#include "io/image_file.hpp"
#include "pipeline/level_set.hpp"
#include "pipeline/result.hpp"
#include "pipeline/segmentation_store.hpp"

namespace sanatrix::server {
namespace {

using nlohmann::json;
using pipeline::CaseView;
using pipeline::Stage;

json mm(const Vec3& p) {
  return {1e3 * p[0], 1e3 * p[1], 1e3 * p[2]};
}

/// The boundary's own numbering of vertices, so that arrays hold nothing of the inside.
struct Shell {
  std::vector<int> vertices;          ///< of the mesh
  std::vector<std::uint32_t> number;  ///< mesh vertex -> shell vertex
  std::vector<std::uint32_t> triangles;
  json groups = json::array();  ///< [{name, first, count}] in triangles
};

Shell make_shell(const TetMesh& mesh) {
  constexpr auto none = ~std::uint32_t{0};
  Shell shell;
  shell.number.assign(mesh.points.size(), none);
  for (std::size_t name = 0; name < mesh.boundary_names.size(); ++name) {
    const std::size_t first = shell.triangles.size() / 3;
    for (const BoundaryFace& face : mesh.faces) {
      if (face.name != static_cast<int>(name)) {
        continue;
      }
      for (const int v : face.vertex) {
        std::uint32_t& number = shell.number[static_cast<std::size_t>(v)];
        if (number == none) {
          number = static_cast<std::uint32_t>(shell.vertices.size());
          shell.vertices.push_back(v);
        }
        shell.triangles.push_back(number);
      }
    }
    shell.groups.push_back({{"name", mesh.boundary_names[name]},
                            {"first", first},
                            {"count", shell.triangles.size() / 3 - first}});
  }
  return shell;
}

/// Per shell vertex: 0 elsewhere, 1 patient's right breast, 2 left.
std::vector<std::uint8_t> breast_of(const meshing::BreastModel& model, const Shell& shell) {
  std::vector<std::uint8_t> of_vertex(model.mesh.points.size(), 0), result;
  for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
    if (model.in_breast[c]) {
      for (const int v : model.mesh.cells[c]) {
        of_vertex[static_cast<std::size_t>(v)] = model.side[c] > 0 ? 2 : 1;
      }
    }
  }
  for (const int v : shell.vertices) {
    result.push_back(of_vertex[static_cast<std::size_t>(v)]);
  }
  return result;
}

void add_in_all_poses(Bundle& bundle, const std::string& name, std::span<const Vec3> points,
                      const std::string& from, const CaseView& view) {
  for (const auto& [pose, carried] : view.carry_to_all(points, from)) {
    bundle.add_mm(fmt::format("{}.{}", name, pose), carried);
  }
}

void add_surface(Bundle& bundle, const std::string& name, const TriMesh& surface,
                 const std::string& from, const CaseView& view) {
  std::vector<std::uint32_t> triangles;
  for (const auto& t : surface.triangles) {
    for (const int v : t) {
      triangles.push_back(static_cast<std::uint32_t>(v));
    }
  }
  bundle.add(name + ".triangles", triangles);
  add_in_all_poses(bundle, name, surface.points, from, view);
}

/// Incisions are paths along edges of the mesh; a scalpel does not go in zigzag.
std::vector<Vec3> smoothed(std::vector<Vec3> line) {
  constexpr int passes = 4;
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<Vec3> old = line;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      line[i] = 0.25 * old[i - 1] + 0.5 * old[i] + 0.25 * old[i + 1];
    }
  }
  return line;
}

/// Several lines as one array; "incision.lengths" tells where they part.
void add_lines(Bundle& bundle, const std::string& name, const std::vector<std::vector<Vec3>>& lines,
               const std::string& from, const CaseView& view) {
  std::vector<std::uint32_t> lengths;
  std::vector<Vec3> all;
  for (const auto& line : lines) {
    lengths.push_back(static_cast<std::uint32_t>(line.size()));
    const std::vector<Vec3> smooth = smoothed(line);
    all.insert(all.end(), smooth.begin(), smooth.end());
  }
  bundle.add(name + ".lengths", lengths);
  add_in_all_poses(bundle, name, all, from, view);
}

void add_wound(Bundle& bundle, const pipeline::Case& patient, const CaseView& view) {
  const auto file = patient.stage_folder(Stage::Surgery) / "wound.bin";
  if (!std::filesystem::exists(file) || !view.has("supine")) {
    return;
  }
  const surgery::Wound wound = pipeline::load_wound(file);
  const TetMesh& mesh = view.model().mesh;
  if (wound.fraction.size() != mesh.cells.size()) {
    return;  // of an older mesh
  }
  const std::vector<Vec3>& supine = view.pose("supine");
  add_surface(
      bundle, "wound",
      pipeline::level_set(mesh, supine, pipeline::to_vertices(mesh, supine, wound.fraction), 0.5),
      "supine", view);
  std::vector<std::vector<Vec3>> lines;
  for (const std::vector<int>& line : wound.incision_vertices) {
    lines.emplace_back();
    for (const int v : line) {
      lines.back().push_back(supine[static_cast<std::size_t>(v)]);
    }
  }
  add_lines(bundle, "incision", lines, "supine", view);
}

json in_poses(const Vec3& point, const std::string& from, const CaseView& view) {
  json result = json::object();
  for (const auto& [pose, carried] : view.carry_to_all(std::array<Vec3, 1>{point}, from)) {
    result[pose] = mm(carried[0]);
  }
  return result;
}

void add_history(Bundle& bundle, const std::vector<recovery::HistoryRow>& history) {
  json days = json::array(), volume = json::array(), moved = json::array();
  for (const recovery::HistoryRow& row : history) {
    days.push_back(row.species.t_day);
    volume.push_back(row.volume_ratio);
    moved.push_back(row.max_displacement_mm);
  }
  bundle.head["history"] = {
      {"day", days}, {"wound_volume_ratio", volume}, {"max_displacement_mm", moved}};
}

/// 2nd to 98th percentile of the image to 0..255.
std::vector<std::uint8_t> to_grey(const std::vector<float>& values) {
  std::vector<float> sorted;
  for (std::size_t i = 0; i < values.size(); i += 17) {  // a sample is enough for percentiles
    sorted.push_back(values[i]);
  }
  std::ranges::sort(sorted);
  const float low = sorted[sorted.size() / 50], high = sorted[sorted.size() * 49 / 50];
  const float scale = high > low ? 255.0F / (high - low) : 0.0F;
  std::vector<std::uint8_t> grey;
  grey.reserve(values.size());
  for (const float v : values) {
    grey.push_back(static_cast<std::uint8_t>(std::clamp((v - low) * scale, 0.0F, 255.0F)));
  }
  return grey;
}

}  // namespace

std::string scene_bundle(const pipeline::Case& patient, const CaseView& view) {
  const meshing::BreastModel& model = view.model();
  const Shell shell = make_shell(model.mesh);
  Bundle bundle;
  bundle.head = {{"captured", patient.scan_only() ? "scan" : "image"},
                 {"groups", shell.groups},
                 {"midline_x_mm", 1e3 * model.midline_x_m},
                 {"poses", json::array()},
                 {"nipple", json::object()}};
  bundle.add("triangles", shell.triangles);
  bundle.add("breast", breast_of(model, shell));
  for (const auto& [name, points] : view.poses()) {
    std::vector<Vec3> surface;
    surface.reserve(shell.vertices.size());
    for (const int v : shell.vertices) {
      surface.push_back(points[static_cast<std::size_t>(v)]);
    }
    bundle.head["poses"].push_back(name);
    bundle.add_mm("points." + name, surface);
  }
  for (const std::size_t side : {0U, 1U}) {
    const auto vertex = static_cast<std::size_t>(model.nipple_vertex[side]);
    bundle.head["nipple"][side == 1 ? "L" : "R"] =
        in_poses(model.mesh.points[vertex], "prone", view);
  }
  if (patient.has_plan()) {
    const surgery::Plan plan = patient.plan();
    bundle.head["tumour"] = {
        {"radius_mm", 1e3 * plan.tumour_radius},
        {"centre", in_poses(plan.tumour_centre, pipeline::pose_of(plan.frame), view)}};
  }
  add_wound(bundle, patient, view);
  return bundle.bytes();
}

std::string healing_bundle(const pipeline::Case& patient, const CaseView& view) {
  const pipeline::CaseResult result = pipeline::load_result(patient);
  const TetMesh& mesh = view.model().mesh;
  require(
      !result.frames.empty() && result.frames[0].points.size() == view.model().mesh.points.size(),
      "healing has not been computed for this model");
  Bundle bundle;
  std::vector<std::uint32_t> cells;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (view.model().side[c] == result.side()) {
      for (const int v : mesh.cells[c]) {
        cells.push_back(static_cast<std::uint32_t>(v));
      }
    }
  }
  bundle.add("cells", cells);
  bundle.head["species"] = json::array();
  for (const healing::Species& s : result.species) {
    bundle.head["species"].push_back({{"key", s.key}, {"label", s.label}, {"healthy", s.healthy}});
  }
  bundle.head["days"] = json::array();
  for (std::size_t f = 0; f < result.frames.size(); ++f) {
    const pipeline::Frame& frame = result.frames[f];
    bundle.head["days"].push_back(frame.t_day);
    bundle.add_mm("points." + std::to_string(f), frame.points);
    bundle.add("species." + std::to_string(f),
               std::vector<float>(frame.species.begin(), frame.species.end()));
  }
  add_history(bundle, result.history);
  return bundle.bytes();
}

std::string volume_bundle(const pipeline::Case& patient) {
  const auto folder = patient.stage_folder(Stage::Segment);
  if (!std::filesystem::exists(folder / "labels.nii.gz")) {
    throw Error(Fault::Input, "the images of this case have not been read yet",
                "run the case at least to the stage segment");
  }
  const imaging::Segmentation segmentation = pipeline::load_segmentation(folder);
  const LabelImage& labels = segmentation.labels;
  Bundle bundle;
  bundle.head = {{"size", labels.size},
                 {"spacing_mm", labels.spacing_mm},
                 {"origin_mm", labels.origin_mm},
                 {"greyscale", false}};
  bundle.add("labels", labels.voxels);
  if (patient.inputs.contains("image")) {
    const Image3<float> image = io::read_image(patient.input("image"));
    std::vector<float> values;
    values.reserve(labels.voxels.size());
    for (int k = 0; k < labels.size[2]; ++k) {
      for (int j = 0; j < labels.size[1]; ++j) {
        for (int i = 0; i < labels.size[0]; ++i) {
          values.push_back(static_cast<float>(sample(image, labels.position_mm(i, j, k))));
        }
      }
    }
    bundle.head["greyscale"] = true;
    bundle.add("grey", to_grey(values));
  }
  return bundle.bytes();
}

std::string preview_bundle(const surgery::Plan& plan, const pipeline::PlanPreview& answer,
                           const CaseView& view) {
  const surgery::Wound& wound = answer.wound;
  const double cm3 = 1e6 * wound.excised_m3;
  Bundle bundle;
  bundle.head = {{"excised_cm3", cm3},
                 {"excised_g", answer.excised_g},
                 {"excised_percent", 100.0 * cm3 / answer.breast_cm3},
                 {"breast_cm3", answer.breast_cm3},
                 {"to_skin_mm", 1e3 * wound.min_skin_distance_m},
                 {"to_chest_mm", 1e3 * wound.min_chest_distance_m},
                 {"quadrant", answer.place.quadrant},
                 {"clock_hour", answer.place.clock_hour},
                 {"from_nipple_mm", answer.place.from_nipple_mm},
                 {"warnings", wound.warnings}};
  const std::string pose = pipeline::pose_of(plan.frame);
  bundle.head["tumour"] = {{"radius_mm", 1e3 * plan.tumour_radius},
                           {"centre", in_poses(plan.tumour_centre, pose, view)}};
  add_surface(bundle, "wound", answer.surface, pose, view);
  add_lines(bundle, "incision", answer.incisions, pose, view);
  return bundle.bytes();
}

}  // namespace sanatrix::server
