// Answers about cases: making, running, planning, looking.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "answers.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/segmentation_store.hpp"
#include "planner.hpp"
#include "view_api.hpp"

namespace sanatrix::server {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr double mm = 1e-3;

double number(const Request& request, const std::string& name) {
  const std::string text = request.parameter(name);
  double value = 0.0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  require(problem == std::errc{} && end == text.data() + text.size() && std::isfinite(value),
          "{} is not a number", name);
  return value;
}

/// Letter of BI-RADS for a class in words, as the built-in patient has them.
std::string density_letter(const std::string& word) {
  constexpr std::array known{"fatty", "scattered", "heterogeneous", "dense"};
  const auto at = std::ranges::find(known, word);
  require(at != known.end(), "there is no breast density \"{}\"", word);
  return {"abcd"[at - known.begin()]};
}

json named(json summary, const std::string& name) {
  if (!name.empty()) {
    summary["plan_name"] = name;
  }
  return summary;
}

/// The labelled tumour, for cases without a plan.
json marked_tumour(const pipeline::Case& patient) {
  const auto folder = patient.stage_folder(pipeline::Stage::Segment);
  if (!fs::exists(folder / "labels.nii.gz")) {
    return nullptr;
  }
  const imaging::Segmentation s = pipeline::load_segmentation(folder);
  Vec3 sum{};
  double count = 0.0;
  for (int k = 0; k < s.labels.size[2]; ++k) {
    for (int j = 0; j < s.labels.size[1]; ++j) {
      for (int i = 0; i < s.labels.size[0]; ++i) {
        if (s.labels.at(i, j, k) == static_cast<unsigned char>(Label::Tumour)) {
          sum += s.labels.position_mm(i, j, k);
          count += 1.0;
        }
      }
    }
  }
  if (count == 0.0) {
    return nullptr;
  }
  const Vec3 centre = (1.0 / count) * sum;
  const double radius = std::cbrt(count * s.labels.voxel_volume_mm3() * 0.75 / std::numbers::pi);
  return {{"centre_lps_mm", centre},
          {"equivalent_radius_mm", radius},
          {"side", centre[0] > s.midline_x_mm ? "L" : "R"}};
}

}  // namespace

Response Planner::list_cases(const Request&, const Parts&) {
  json list = json::array();
  for (const std::string& id : cases_.ids()) {
    try {
      list.push_back(named(summary(id, cases_.open(id)), cases_.plan_name(id)));
    } catch (const std::exception&) {  // one broken case must not hide the others
      list.push_back({{"id", id}, {"broken", true}});
    }
  }
  return json_answer({{"cases", list}});
}

Response Planner::show_case(const Request&, const Parts& parts) {
  return json_answer(named(summary(parts[0], cases_.open(parts[0])), cases_.plan_name(parts[0])));
}

std::vector<Step> Planner::steps_of_new_case(const json& wish, const std::string& id) const {
  const std::string folder = cases_.folder(id);
  std::vector<Step> steps;
  std::vector<std::string> make{"new", folder};
  if (wish.contains("builtin")) {
    const json& b = wish["builtin"];
    const std::string phantom = cases_.own_folder() / "uploads" / random_name();
    steps.push_back({{"phantom", phantom, "--seed", std::to_string(b.value("seed", 1)),
                      "--volume-cm3", std::to_string(b.value("volume_cm3", 600.0)), "--density",
                      b.value("density", "scattered")},
                     phantom});
    make.insert(make.end(),
                {"--labels", phantom + "/labels.nii.gz", "--plan", phantom + "/plan.json"});
  } else {
    for (const std::string name : {"labels", "image", "scan", "plan", "tumour"}) {
      if (wish.contains(name)) {
        make.insert(make.end(), {"--" + name, uploaded(wish[name]).string()});
      }
    }
    require(make.size() > 2, "nothing was given to make a case from");
    if (!wish.contains("labels") && !wish.contains("image")) {
      require(wish.contains("scan"), "a case needs an MRI, a label volume or a surface scan");
      make.insert(make.end(), {"--pose", "upright"});
      if (wish.contains("density")) {
        make.insert(make.end(), {"--density", density_letter(wish["density"])});
      }
    }
    if (wish.contains("series")) {
      make.insert(make.end(), {"--series", std::to_string(wish["series"].get<int>())});
    }
    if (wish.contains("labels_preset")) {
      make.insert(make.end(), {"--labels-preset", wish["labels_preset"].get<std::string>()});
    }
  }
  steps.push_back({make, folder});
  std::vector<std::string> run{"run", folder, "--to", "supine"};
  for (const std::string& value : assignments(wish.value("set", json::object()))) {
    run.insert(run.end(), {"--set", value});
  }
  steps.push_back({run});
  return steps;
}

Response Planner::create_case(const Request& request, const Parts&) {
  const json wish = body_of(request);
  const std::string id = cases_.free_id(wish.value("name", "patient"));
  for (const Job& job : jobs_.jobs()) {
    require(job.case_id != id || job.state == JobState::Done || job.state == JobState::Failed ||
                job.state == JobState::Cancelled,
            "a case of this name is being made already");
  }
  const std::string job = jobs_.add(id, "create", steps_of_new_case(wish, id));
  return json_answer({{"case", id}, {"job", job}}, 201);
}

Response Planner::delete_case(const Request&, const Parts& parts) {
  require(!jobs_.busy(parts[0]), "this case is being worked on: stop that first");
  cases_.remove(parts[0]);
  return json_answer({{"ok", true}});
}

Response Planner::copy_case(const Request& request, const Parts& parts) {
  const json wish = body_of(request);
  const std::string id = cases_.free_id(wish.value("name", parts[0] + "-plan"));
  cases_.copy_for_plan(parts[0], id);
  return json_answer({{"case", id}}, 201);
}

Response Planner::run_case(const Request& request, const Parts& parts) {
  const json wish = body_of(request);
  const pipeline::Case patient = cases_.open(parts[0]);
  require(!jobs_.busy(parts[0]), "this case is being worked on already");
  std::vector<std::string> run{"run", patient.folder.string()};
  if (wish.contains("plan")) {
    const std::string text = wish["plan"].dump(1);
    surgery::read_plan(text, "plan");
    const fs::path file = cases_.own_folder() / "uploads" / (random_name() + ".json");
    write_text(file, text + "\n");
    run.insert(run.end(), {"--plan", file.string()});
  }
  for (const std::string& value : assignments(wish.value("set", json::object()))) {
    run.insert(run.end(), {"--set", value});
  }
  if (wish.contains("to")) {
    run.insert(run.end(), {"--to", pipeline::info(pipeline::parse_stage(wish["to"])).name});
  }
  std::vector<Step> steps{{run}};
  if (abilities_.report && !wish.contains("to")) {
    steps.push_back({{"report", patient.folder.string()}});
  }
  return json_answer({{"job", jobs_.add(parts[0], "run", steps)}}, 201);
}

Response Planner::scene(const Request&, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  return bundle_answer(scene_bundle(patient, *cases_.view(patient)));
}

Response Planner::healing(const Request&, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  return bundle_answer(healing_bundle(patient, *cases_.view(patient)));
}

Response Planner::volume(const Request&, const Parts& parts) {
  return bundle_answer(volume_bundle(cases_.open(parts[0])));
}

Response Planner::show_plan(const Request& request, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  json answer{{"plan", nullptr}, {"marked_tumour", nullptr}};
  if (patient.has_plan()) {
    surgery::Plan plan = patient.plan();
    const std::string frame = request.parameter("frame");
    if (frame == "supine" || frame == "prone") {
      plan = in_frame(plan, frame == "prone" ? surgery::Frame::Prone : surgery::Frame::Supine,
                      *cases_.view(patient));
    }
    answer["plan"] = json::parse(surgery::write_plan(plan));
  } else {
    answer["marked_tumour"] = marked_tumour(patient);
  }
  return json_answer(answer);
}

Response Planner::preview_plan(const Request& request, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  const surgery::Plan plan = surgery::read_plan(request.body, "plan");
  const auto view = cases_.view(patient);
  const auto detail =
      request.parameter("detail") == "live" ? surgery::Detail::Live : surgery::Detail::Full;
  return bundle_answer(
      preview_bundle(plan, pipeline::preview(plan, *view, patient.parameters, detail), *view));
}

Response Planner::name_plan(const Request& request, const Parts& parts) {
  const json wish = body_of(request);
  const pipeline::Case must_exist = cases_.open(parts[0]);
  require(wish.contains("name") && wish["name"].is_string(), "name is not a text");
  cases_.name_plan(must_exist.folder.filename().string(), wish["name"]);
  return json_answer({{"ok", true}});
}

Response Planner::photograph(const Request&, const Parts& parts) {
  return bundle_answer(photograph_bundle(
      cases_.open(parts[0]), cases_.own_folder() / "uploads" / (random_name() + ".poses")));
}

Response Planner::propose_incision(const Request& request, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  const surgery::Plan plan = surgery::read_plan(request.body, "plan");
  json line = json::array();
  for (const Vec3& p : usual_incision(parts[1], plan, *cases_.view(patient))) {
    line.push_back((1.0 / mm) * p);
  }
  require(line.size() >= 2, "no such incision can be placed here");
  return json_answer({{"line_mm", line}});
}

Response Planner::carry_point(const Request& request, const Parts& parts) {
  const pipeline::Case patient = cases_.open(parts[0]);
  const Vec3 point = mm * Vec3{number(request, "x"), number(request, "y"), number(request, "z")};
  const auto carried = cases_.view(patient)->carry(
      std::array<Vec3, 1>{point}, request.parameter("from"), request.parameter("to"))[0];
  return json_answer({{"point_mm", (1.0 / mm) * carried}});
}

Response Planner::list_files(const Request&, const Parts& parts) {
  return json_answer({{"files", result_files(cases_.open(parts[0]))}});
}

Response Planner::send_file(const Request& request, const Parts& parts) {
  const fs::path file = cases_.result_file(cases_.open(parts[0]), parts[1], parts[2]);
  Response response{.type = content_type(file), .body = {}, .file = file};
  const bool shown = response.type.starts_with("image/png") && request.parameter("save").empty();
  if (!shown) {
    response.headers.emplace_back(
        "Content-Disposition",
        fmt::format("attachment; filename=\"{}-{}\"", parts[0], file.filename().string()));
  }
  return response;
}

}  // namespace sanatrix::server
