#include "pipeline/standing_scan.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "geometry/surface_noise.hpp"
#include "io/scan_file.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t most_triangles = 400'000;
constexpr double thinned_edge_m = 0.0015;

json to_json(const Rigid& move) {
  json rows = json::array();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& row = move.rotation[i];
    rows.push_back({row[0], row[1], row[2], 1e3 * move.shift[i]});
  }
  return rows;
}

Rigid rigid_from(const json& rows) {
  Rigid move;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      move.rotation[i][k] = rows.at(i).at(k).get<double>();
    }
    move.shift[i] = 1e-3 * rows.at(i).at(3).get<double>();
  }
  return move;
}

/// What was taken for a nipple, and how sure its place is.
json to_json(const standing::NippleFind& find) {
  using enum standing::NippleSign;
  const char* from = find.sign == Mark     ? "mark"
                     : find.sign == Colour ? "colour"
                     : find.sign == Bump   ? "bump"
                                           : "shape of the breast";
  return {{"from", from}, {"doubt_mm", find.doubt_mm}};
}

/// One mark by its name; names of others are passed over.
void set_mark(standing::ScanLandmarks& marks, const std::string& name, const Vec3& mm) {
  const Vec3 place = 1e-3 * mm;
  if (name == "nipple_R") {
    marks.nipple[0] = place;
  } else if (name == "nipple_L") {
    marks.nipple[1] = place;
  } else if (name == "sternal_notch") {
    marks.sternal_notch = place;
  }
}

standing::ScanLandmarks marks_from(const json& file) {
  standing::ScanLandmarks marks;
  if (file.contains("markups")) {
    for (const json& markup : file.at("markups")) {
      const double flip = markup.value("coordinateSystem", "LPS") == "RAS" ? -1.0 : 1.0;
      for (const json& point : markup.at("controlPoints")) {
        const Vec3 p = point.at("position").get<Vec3>();
        set_mark(marks, point.value("label", ""), {flip * p[0], flip * p[1], p[2]});
      }
    }
    return marks;
  }
  for (const auto& [name, place] : file.at("landmarks_scan_mm").items()) {
    set_mark(marks, name, place.get<Vec3>());
  }
  if (file.contains("up_scan")) {
    marks.up = file.at("up_scan").get<Vec3>();
    require(norm(*marks.up) > 1e-6, "up_scan is zero; write the direction against gravity");
  }
  return marks;
}

}  // namespace

standing::ScanLandmarks read_marks(const std::string& json_text, const std::string& name) {
  try {
    return marks_from(json::parse(json_text));
  } catch (const json::exception& e) {
    throw Error(Fault::Input, fmt::format("{}: these landmarks cannot be used: {}", name, e.what()),
                "write landmarks_scan_mm with nipple_R, nipple_L, sternal_notch, or Slicer markups "
                "with points of these names");
  }
}

namespace {

/// Software lays photographs on a scan as they were taken; only a mirror turns them over. Returns
/// what is to be said about the sides.
std::string check_sides(const TexturedSurface& scan) {
  constexpr double clearly = 0.5;
  const double sense = photograph_sense(scan);
  if (sense < -clearly) {
    throw Error(Fault::Input,
                "scan: its photograph lies on the skin as in a mirror: the scan was mirrored and "
                "left and right are swapped",
                "export it again without a mirror or a negative scale; if the sides are right, "
                "leave the photographs away");
  }
  return sense > clearly ? "left and right are those of the photograph; compare scars and moles"
                         : "nothing in the scan tells left from right if it was mirrored: compare "
                           "scars and moles with the patient";
}

/// What edges as long as these cannot show; nothing on usual scans.
std::optional<std::string> about_resolution(const TriMesh& mesh) {
  constexpr double coarse_m = 0.008;  // an areola is 10 to 30 mm in radius, a nipple 5
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& p = mesh.points[static_cast<std::size_t>(a)];
    area += 0.5 * norm(cross(mesh.points[static_cast<std::size_t>(b)] - p,
                             mesh.points[static_cast<std::size_t>(c)] - p));
  }
  // Of equilateral triangles of the mean area.
  const double edge_m = std::sqrt(4 / std::sqrt(3.0) * area / mesh.triangles.size());
  if (edge_m < coarse_m) {
    return std::nullopt;
  }
  return fmt::format(
      "the scan is coarse: triangles of {:.0f} mm ({} in all); nipples and folds are "
      "smoothed over, give a finer one",
      1e3 * edge_m, mesh.triangles.size());
}

/// The scan of a file without noise that would make a mesh rough; what was taken off is noted.
io::Scan read_calm_scan(const fs::path& file, io::ScanUnit unit) {
  constexpr double most_m = 0.004;  // a fold under a breast is not much wider
  io::Scan scan = io::read_scan(file, unit);
  const double noise_m = noise_of(scan.surface.mesh);
  const int rounds = rounds_for(scan.surface.mesh, noise_m);
  if (rounds == 0) {
    return scan;
  }
  const std::string noise = fmt::format("noise of {:.1f} mm (1 sd of each point)", 1e3 * noise_m);
  if (noise_m > most_m) {
    throw Error(
        Fault::Input,
        fmt::format("scan: it has {}; a model needs less than {:g} mm", noise, 1e3 * most_m),
        "scan the patient again, standing still, or smooth the scan");
  }
  scan.surface.mesh = smoothed(std::move(scan.surface.mesh), rounds);
  scan.notes.push_back(fmt::format(
      "the scan is rough: {} was smoothed away; nipples and folds are smoothed over", noise));
  return scan;
}

}  // namespace

void find_standing_frame(Case& patient) {
  standing::ScanLandmarks marks;
  if (patient.inputs.contains("scan_landmarks")) {
    marks = read_marks(read_text(patient.input("scan_landmarks")), "scan landmarks");
  }
  const io::ScanUnit asked = io::parse_scan_unit(patient.parameters.text("outcome.scan_unit"));
  io::Scan scan = read_calm_scan(patient.input("scan"), asked);
  const std::string about_sides = check_sides(scan.surface);
  const auto find = [&] {
    return during("scan", [&] { return standing::find_frame(scan.surface, marks); });
  };
  standing::ScanFrame frame;
  try {
    frame = find();
  } catch (const Error& in_centimetres) {
    // The size of a small trunk in centimetres is that of a wide one in inches.
    if (asked != io::ScanUnit::Guess || scan.unit != "cm" || marks.nipple[0] || marks.nipple[1]) {
      throw;
    }
    try {
      scan = read_calm_scan(patient.input("scan"), io::ScanUnit::Inch);
      frame = find();
    } catch (const Error&) {
      throw in_centimetres;
    }
  }
  json j{{"unit", scan.unit},
         {"unit_asked", patient.parameters.text("outcome.scan_unit")},
         {"scan_to_patient_lps_mm", to_json(frame.to_patient)},
         {"nipple_lps_mm", {{"R", 1e3 * frame.nipple[0]}, {"L", 1e3 * frame.nipple[1]}}},
         {"nipples", {{"R", to_json(frame.nipple_find[0])}, {"L", to_json(frame.nipple_find[1])}}},
         {"notes", frame.notes}};
  j["notes"].push_back(about_sides);
  if (const auto coarse = about_resolution(scan.surface.mesh)) {
    j["notes"].push_back(*coarse);
  }
  for (const std::string& note : scan.notes) {
    j["notes"].push_back(note);
  }
  if (frame.sternal_notch) {
    j["sternal_notch_lps_mm"] = 1e3 * *frame.sternal_notch;
  }
  const std::string text = j.dump(2) + "\n";
  const std::string file = fmt::format("inputs/scan_frame-{:.8}.json", sha256_of_text(text));
  write_text(patient.folder / file, text);
  patient.inputs["scan_frame"] = {file, sha256_of_text(text)};
}

bool stands_in_unit(const Case& patient) {
  return patient.inputs.contains("scan_frame") &&
         json::parse(read_text(patient.input("scan_frame"))).value("unit_asked", "guess") ==
             patient.parameters.text("outcome.scan_unit");
}

StandingScan load_standing_scan(const Case& patient) {
  const json j = json::parse(read_text(patient.input("scan_frame")));
  StandingScan scan;
  scan.unit = j.at("unit").get<std::string>();
  scan.to_patient = rigid_from(j.at("scan_to_patient_lps_mm"));
  scan.nipple = {1e-3 * j.at("nipple_lps_mm").at("R").get<Vec3>(),
                 1e-3 * j.at("nipple_lps_mm").at("L").get<Vec3>()};
  scan.nipples = j.value("nipples", json::object()).dump();
  scan.notes = j.at("notes").get<std::vector<std::string>>();
  if (j.contains("sternal_notch_lps_mm")) {
    scan.sternal_notch = 1e-3 * j["sternal_notch_lps_mm"].get<Vec3>();
  }
  const io::Scan file = read_calm_scan(patient.input("scan"), io::parse_scan_unit(scan.unit));
  const TriMesh& mesh = file.surface.mesh;
  scan.skin = moved(
      mesh.triangles.size() > most_triangles ? outcome::coarsened(mesh, thinned_edge_m) : mesh,
      scan.to_patient);
  return scan;
}

}  // namespace sanatrix::pipeline
