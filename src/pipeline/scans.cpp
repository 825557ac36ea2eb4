#include "pipeline/scans.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/archive.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_file.hpp"
#include "outcome/scan_target.hpp"
#include "pipeline/json_object.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/standing_scan.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Skin that moves less than this between prone and upright tells where the scan lies.
constexpr double still_m = 0.005;
/// Errors of a prediction count even where the scan's nearest place looks another way.
constexpr double any_way = -1.0;

/// The upright skin before surgery, with the doubt about how far the breasts sag.
outcome::StandingSkin standing_skin(const CaseResult& r, const Skin& skin) {
  outcome::StandingSkin standing;
  standing.surface = skin.before.mesh;
  standing.modes.resize(2);
  for (const int vertex : skin.before.vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    const Vec3& prone = r.model.mesh.points[v];
    const Vec3 unloaded = r.points(r.unloaded)[v], upright = r.points(r.before)[v];
    const double moved = norm(upright - prone) / still_m;
    standing.trust.push_back(1 / (1 + moved * moved));
    standing.modes[0].push_back(upright - unloaded);
    standing.modes[1].push_back(unloaded - prone);
  }
  return standing;
}

/// A pose from the landmarks that were marked on the scan, if any.
std::optional<Rigid> marked_start(const Case& patient, const CaseResult& r, const std::string& name,
                                  double metres_per_unit) {
  const std::string key = name + "_landmarks";
  if (!patient.inputs.contains(key)) {
    return std::nullopt;
  }
  const json j = json::parse(read_text(patient.input(key)), nullptr, false);
  const JsonObject file(j, key);
  const JsonObject marks = file.object("landmarks_scan_mm");
  std::vector<Vec3> on_scan, on_patient;
  const auto add = [&](const std::string& mark, const Vec3& where) {
    if (marks.has(mark)) {
      const std::vector<double> x = marks.numbers(mark, 3);
      on_scan.push_back(metres_per_unit * Vec3{x[0], x[1], x[2]});
      on_patient.push_back(where);
    }
  };
  add("nipple_R", r.points(r.before)[static_cast<std::size_t>(r.model.nipple_vertex[0])]);
  add("nipple_L", r.points(r.before)[static_cast<std::size_t>(r.model.nipple_vertex[1])]);
  for (const auto& [mark, place] : r.landmarks) {
    add(mark, place);
  }
  return outcome::match_landmarks(on_scan, on_patient);
}

/// What a scan's pose depends on.
std::string pose_key(const Case& patient, const std::string& name) {
  std::string key = upright_before_key(patient) + patient.parameters.text("outcome.scan_unit");
  for (const auto& [input, file] : patient.inputs) {
    if (input.starts_with(name)) {
      key += input + file.sha256;
    }
  }
  return sha256_of_text("pose 1 " + key);
}

void store(Archive& archive, const std::string& name, const std::string& key,
           const outcome::Alignment& pose) {
  archive.texts[name + ".key"] = key;
  std::vector<double>& numbers = archive.reals[name + ".pose"];
  for (const auto& row : pose.to_patient.rotation) {
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  const Vec3& t = pose.to_patient.shift;
  numbers.insert(numbers.end(), {t[0], t[1], t[2], pose.median_m, pose.rms_m, pose.overlap});
  archive.reals[name + ".shares"] = pose.mode_shares;
}

std::optional<outcome::Alignment> stored(const Archive& archive, const std::string& name,
                                         const std::string& key) {
  const auto known = archive.texts.find(name + ".key");
  if (known == archive.texts.end() || known->second != key) {
    return std::nullopt;
  }
  const std::vector<double>& n = archive.real(name + ".pose");
  outcome::Alignment pose;
  for (std::size_t i = 0; i < 9; ++i) {
    pose.to_patient.rotation[i / 3][i % 3] = n.at(i);
  }
  pose.to_patient.shift = {n.at(9), n.at(10), n.at(11)};
  pose.median_m = n.at(12);
  pose.rms_m = n.at(13);
  pose.overlap = n.at(14);
  pose.mode_shares = archive.real(name + ".shares");
  return pose;
}

PlacedScan place_scan(const Case& patient, const CaseResult& r, const std::string& name,
                      const outcome::StandingSkin& standing, const Archive& kept, Archive& keep) {
  io::Scan scan = io::read_scan(patient.input(name),
                                io::parse_scan_unit(patient.parameters.text("outcome.scan_unit")));
  const std::string key = pose_key(patient, name);
  std::optional<outcome::Alignment> pose = stored(kept, name, key);
  if (r.standing && name == "scan") {  // she is made of it
    pose = outcome::align_freely({standing.surface, standing.trust, {}}, scan.surface.mesh,
                                 load_standing_scan(patient).to_patient);
    pose->to_patient = load_standing_scan(patient).to_patient;
  } else if (!pose) {
    pose = during(name, [&] {
      return outcome::align(standing, scan.surface.mesh, marked_start(patient, r, name, 1e-3));
    });
  }
  store(keep, name, key, *pose);
  scan.surface.mesh = moved(std::move(scan.surface.mesh), pose->to_patient);
  return {std::move(scan.surface), *pose, scan.unit, scan.notes};
}

/// The breast of the closest vertex of the bent skin; 0 beyond its end.
std::vector<signed char> breasts_on_scan(const Skin& skin, const outcome::Warp& warp,
                                         const TriMesh& scan) {
  const SurfaceTree tree(warp.surface);
  std::vector<signed char> breast;
  for (const Vec3& p : scan.points) {
    const auto hit = tree.closest(p);
    const auto& triangle = warp.surface.triangles[static_cast<std::size_t>(hit.triangle)];
    const std::array<double, 3> w = outcome::weights_in(warp.surface, hit.triangle, hit.point);
    const auto k = static_cast<std::size_t>(std::ranges::max_element(w) - w.begin());
    breast.push_back(hit.distance < 0.02 ? skin.breast[static_cast<std::size_t>(triangle[k])] : 0);
  }
  return breast;
}

std::vector<bool> where(std::span<const signed char> breast, auto&& wanted) {
  std::vector<bool> chosen;
  for (const signed char side : breast) {
    chosen.push_back(wanted(static_cast<int>(side)));
  }
  return chosen;
}

Table1 table1(const TriMesh& surface, std::span<const double> distance,
              std::span<const signed char> breast, int side) {
  return {
      outcome::distance_statistics(surface, distance, where(breast, [](int) { return true; })),
      outcome::distance_statistics(surface, distance, where(breast, [](int b) { return b != 0; })),
      outcome::distance_statistics(surface, distance,
                                   where(breast, [side](int b) { return b == side; }))};
}

PreopScan prepare_preop(const Case& patient, const CaseResult& r, const Skin& skin,
                        const outcome::StandingSkin& standing, const Archive& kept, Archive& keep) {
  PreopScan preop{place_scan(patient, r, "scan", standing, kept, keep), {}, {}, {}};
  const std::string key = pose_key(patient, "scan") + " warp 1";
  const auto known = kept.texts.find("scan.warp_key");
  if (known != kept.texts.end() && known->second == key) {
    preop.warp.surface = skin.before.mesh;
    preop.warp.surface.points = unflatten(kept.real("scan.warp"));
    preop.warp.median_m = kept.real("scan.warp_left").at(0);
  } else {
    // The sag that fitted best is where the bending starts.
    TriMesh start = skin.before.mesh;
    for (std::size_t m = 0; m < preop.placed.pose.mode_shares.size(); ++m) {
      for (std::size_t v = 0; v < start.points.size(); ++v) {
        start.points[v] += preop.placed.pose.mode_shares[m] * standing.modes[m][v];
      }
    }
    preop.warp = outcome::warp_onto(start, preop.placed.surface.mesh);
  }
  keep.texts["scan.warp_key"] = key;
  keep.reals["scan.warp"] = flatten(preop.warp.surface.points);
  keep.reals["scan.warp_left"] = {preop.warp.median_m};
  preop.displacement =
      outcome::carry_to_scan(preop.warp, skin.displacement(), preop.placed.surface.mesh);
  preop.breast = breasts_on_scan(skin, preop.warp, preop.placed.surface.mesh);
  return preop;
}

FollowupScan compare_followup(const CaseResult& r, const Skin& skin, PlacedScan placed) {
  FollowupScan followup{std::move(placed), {}, {}, {}, {}};
  const TriMesh& scan = followup.placed.surface.mesh;
  followup.anchored = table1(skin.after, outcome::signed_distances(skin.after, scan, any_way),
                             skin.breast, r.side());
  outcome::StandingSkin predicted{
      skin.after, std::vector<double>(skin.after.points.size(), 1.0), {}};
  followup.best_fit = outcome::align_freely(predicted, scan, Rigid{}).to_patient;
  followup.distance =
      outcome::signed_distances(skin.after, moved(scan, followup.best_fit), any_way);
  followup.fitted = table1(skin.after, followup.distance, skin.breast, r.side());
  return followup;
}

ObservedChange observe(const CaseResult& r, const PreopScan& preop, const TriMesh& followup) {
  // Skin outside both breasts lays the scans onto each other.
  const TriMesh& before = preop.placed.surface.mesh;
  outcome::StandingSkin standing{before, {}, {}};
  for (const signed char breast : preop.breast) {
    standing.trust.push_back(breast == 0 ? 1.0 : 0.1);
  }
  const Rigid fit = outcome::align_freely(standing, followup, Rigid{}).to_patient;
  ObservedChange change;
  change.inward = outcome::signed_distances(before, moved(followup, fit));
  for (double& d : change.inward) {
    d = -d;
  }
  const auto of_side = [&](int side) {
    return outcome::retraction(before, change.inward,
                               where(preop.breast, [side](int b) { return b == side; }));
  };
  change.operated = of_side(r.side());
  change.other = of_side(-r.side());
  constexpr double least_cosine = 0.3;
  change.operated_straight_back_m = std::numeric_limits<double>::quiet_NaN();
  if (change.operated.vertex >= 0) {
    const Vec3 anterior{0, -1, 0};
    const double cosine =
        dot(vertex_normals(before)[static_cast<std::size_t>(change.operated.vertex)], anterior);
    if (cosine > least_cosine) {
      change.operated_straight_back_m = change.operated.depth_m / cosine;
    }
  }
  return change;
}

json to_json(const outcome::SurfaceDistance& d) {
  if (d.samples == 0) {
    return nullptr;
  }
  return {{"mean_mm", 1e3 * d.mean}, {"std_mm", 1e3 * d.deviation}, {"p50_mm", 1e3 * d.p50},
          {"p90_mm", 1e3 * d.p90},   {"p95_mm", 1e3 * d.p95},       {"max_mm", 1e3 * d.max},
          {"vertices", d.samples}};
}
json to_json(const Table1& t) {
  return {{"whole", to_json(t.whole)},
          {"both_breasts", to_json(t.breasts)},
          {"operated_breast", to_json(t.operated)}};
}
json to_json(const outcome::Retraction& r) {
  return {{"depth_mm", 1e3 * r.depth_m},
          {"p95_mm", 1e3 * r.p95_m},
          {"area_over_3mm_cm2", 1e4 * r.area_3mm_m2},
          {"area_over_5mm_cm2", 1e4 * r.area_5mm_m2}};
}
json to_json(const PlacedScan& scan) {
  json matrix = json::array();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = scan.pose.to_patient.rotation[i];
    matrix.push_back({row[0], row[1], row[2], 1e3 * scan.pose.to_patient.shift[i]});
  }
  matrix.push_back({0, 0, 0, 1});
  return {{"unit", scan.unit},
          {"notes", scan.notes},
          {"triangles", scan.surface.mesh.triangles.size()},
          {"photograph", scan.surface.has_photograph()},
          {"alignment",
           {{"scan_to_patient_lps_mm_4x4", matrix},
            {"median_mm", 1e3 * scan.pose.median_m},
            {"rms_mm", 1e3 * scan.pose.rms_m},
            {"overlap", scan.pose.overlap}}}};
}

}  // namespace

std::vector<Vec3> Skin::displacement() const {
  std::vector<Vec3> moved;
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    moved.push_back(after.points[v] - before.mesh.points[v]);
  }
  return moved;
}

Skin skin_of(const CaseResult& r) {
  Skin skin{.before = extract_surface(r.model.mesh, r.points(r.before), {"skin"}),
            .after = extract_surface(r.model.mesh, r.points(r.after), {"skin"}).mesh,
            .breast = {}};
  std::vector<signed char> of_vertex(r.model.mesh.points.size(), 0);
  for (std::size_t c = 0; c < r.model.mesh.cells.size(); ++c) {
    if (r.model.in_breast[c]) {
      for (const int vertex : r.model.mesh.cells[c]) {
        of_vertex[static_cast<std::size_t>(vertex)] = r.model.side[c];
      }
    }
  }
  for (const int vertex : skin.before.vertex) {
    skin.breast.push_back(of_vertex[static_cast<std::size_t>(vertex)]);
  }
  return skin;
}

Scans load_scans(const Case& patient, const CaseResult& r, const Skin& skin, const fs::path& kept,
                 const fs::path& keep, const Context& ctx) {
  Scans scans;
  if (!patient.inputs.contains("scan") && !patient.inputs.contains("followup")) {
    return scans;
  }
  const Archive old = fs::exists(kept) ? Archive::load(kept) : Archive{};
  Archive now;
  const outcome::StandingSkin standing = standing_skin(r, skin);
  if (patient.inputs.contains("scan")) {
    ctx.at(0.1, "laying the scan onto the patient");
    scans.preop = prepare_preop(patient, r, skin, standing, old, now);
    scans.model_error = table1(
        skin.before.mesh,
        outcome::signed_distances(skin.before.mesh, scans.preop->placed.surface.mesh, any_way),
        skin.breast, r.side());
  }
  if (patient.inputs.contains("followup")) {
    ctx.at(0.3, "comparing with the follow-up scan");
    scans.followup =
        compare_followup(r, skin, place_scan(patient, r, "followup", standing, old, now));
    if (scans.preop) {
      scans.observed = observe(r, *scans.preop, scans.followup->placed.surface.mesh);
    }
  }
  if (!keep.empty()) {
    now.save(keep);
  }
  return scans;
}

json scans_json(const Scans& scans) {
  json j = json::object();
  if (scans.preop) {
    j["preop"] = to_json(scans.preop->placed);
    j["preop"]["warp_left_mm"] = 1e3 * scans.preop->warp.median_m;
    j["preop"]["model_error"] = to_json(*scans.model_error);
  }
  if (scans.followup) {
    j["followup"] = to_json(scans.followup->placed);
    j["followup"]["table1"] = to_json(scans.followup->fitted);
    j["followup"]["table1_chest_fixed"] = to_json(scans.followup->anchored);
  }
  if (scans.observed) {
    j["observed_retraction"] = {{"operated_breast", to_json(scans.observed->operated)},
                                {"other_breast", to_json(scans.observed->other)}};
    const double back = scans.observed->operated_straight_back_m;
    j["observed_retraction"]["operated_breast"]["depth_straight_back_mm"] =
        std::isfinite(back) ? json(1e3 * back) : json(nullptr);
  }
  return j;
}

std::string table1_csv(const FollowupScan& followup) {
  std::string text = "fit,region,mean_mm,std_mm,p50_mm,p90_mm,p95_mm,max_mm,vertices\n";
  const auto add = [&](const char* fit, const Table1& table) {
    for (const auto& [region, d] : {std::pair{"whole", table.whole},
                                    {"both breasts", table.breasts},
                                    {"operated breast", table.operated}}) {
      text += fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{}\n", fit, region,
                          1e3 * d.mean, 1e3 * d.deviation, 1e3 * d.p50, 1e3 * d.p90, 1e3 * d.p95,
                          1e3 * d.max, d.samples);
    }
  };
  add("best rigid fit", followup.fitted);
  add("chest fixed", followup.anchored);
  return text;
}

}  // namespace sanatrix::pipeline
