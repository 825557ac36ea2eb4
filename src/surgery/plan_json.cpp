// Plans as JSON: strict where a mistake could harm, silent about keys that are not ours.
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::surgery {
namespace {

using nlohmann::json;

constexpr double mm = 1e-3;

/// Accepted values in millimetres; wide enough for every real plan, narrow enough to catch metres
/// and centimetres written by mistake.
struct Range {
  const char* key;
  double low_mm, high_mm;
};
constexpr Range tumour_radius_range{"tumour.equivalent_radius_mm", 0.5, 60.0};
constexpr Range margin_range{"planned_margin_mm", 0.0, 40.0};
constexpr Range radius_range{"resection.radius_mm", 3.0, 100.0};
// At least 1 mm: the smallest that keeps the excised piece off the skin on the search grid.
constexpr Range clearance_range{"clearance_mm", 1.0, 30.0};
constexpr Range segment_from_range{"resection.segment.from_mm", 0.0, 200.0};
constexpr Range segment_to_range{"resection.segment.to_mm", 5.0, 250.0};
constexpr double narrowest_deg = 5.0, widest_deg = 160.0, degree = std::numbers::pi / 180.0;
constexpr double largest_coordinate_mm = 1000.0;

void check(const Range& range, double value_mm, const std::string& where) {
  require(std::isfinite(value_mm) && value_mm >= range.low_mm && value_mm <= range.high_mm,
          "{}: {} is {} mm, not within {} to {} mm", where, range.key, value_mm, range.low_mm,
          range.high_mm);
}

/// The value under a dotted path, or nullptr.
const json* find(const json& document, const std::string& path) {
  const json* at = &document;
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    const auto next = at->is_object() ? at->find(path.substr(from, dot - from)) : at->end();
    if (next == at->end()) {
      return nullptr;
    }
    at = &*next;
    from = dot + 1;
  }
  return at;
}

double number(const json& value, const std::string& path, const std::string& where) {
  require(value.is_number() && std::isfinite(value.get<double>()), "{}: {} is not a finite number",
          where, path);
  return value.get<double>();
}

std::optional<double> optional_number(const json& document, const std::string& path,
                                      const std::string& where) {
  const json* value = find(document, path);
  return value == nullptr ? std::nullopt : std::optional(number(*value, path, where));
}

Vec3 triple(const json& value, const std::string& path, const std::string& where) {
  require(value.is_array() && value.size() == 3, "{}: {} is not a list of three numbers", where,
          path);
  return {number(value[0], path, where), number(value[1], path, where),
          number(value[2], path, where)};
}

Vec3 position(const json& value, const std::string& path, const std::string& where) {
  const Vec3 p = triple(value, path, where);
  for (const double x : p) {
    require(std::abs(x) <= largest_coordinate_mm, "{}: {} has {} mm; LPS millimetres are expected",
            where, path, x);
  }
  return mm * p;
}

const json& needed(const json& document, const std::string& path, const std::string& where) {
  const json* value = find(document, path);
  require(value != nullptr, "{}: key {} is missing", where, path);
  return *value;
}

std::string text(const json& document, const std::string& path, const std::string& where) {
  const json* value = find(document, path);
  if (value == nullptr) {
    return {};
  }
  require(value->is_string(), "{}: {} is not a text", where, path);
  return value->get<std::string>();
}

Side read_side(const json& document, const std::string& where) {
  const json& side = needed(document, "operated_side", where);
  require(side == "L" || side == "R", "{}: operated_side is {}, write \"L\" or \"R\"", where,
          side.dump());
  return side == "L" ? Side::Left : Side::Right;
}

Frame read_frame(const json& document, const std::string& where) {
  const std::string frame = text(document, "frame", where);
  require(frame.empty() || frame == "prone" || frame == "supine" || frame == "upright",
          "{}: frame is \"{}\", write \"prone\", \"supine\" or \"upright\"", where, frame);
  // The shared plans say their pose in this sentence; a contradiction must not pass silently.
  const std::string coordinates = text(document, "coordinates", where);
  const bool says_supine = coordinates.find("SUPINE") != std::string::npos;
  const bool says_prone = coordinates.find("PRONE") != std::string::npos;
  const bool says_upright = coordinates.find("UPRIGHT") != std::string::npos;
  require(!(says_supine && frame != "supine") && !(says_upright && frame != "upright") &&
              !(says_prone && (frame == "supine" || frame == "upright")),
          "{}: frame is \"{}\" but coordinates says \"{}\"", where,
          frame.empty() ? "prone (default)" : frame, coordinates);
  return frame == "supine" ? Frame::Supine : frame == "upright" ? Frame::Upright : Frame::Prone;
}

void check_side(const Plan& plan, double midline_x_m, const std::string& where) {
  const bool on_left = plan.tumour_centre[0] > midline_x_m;
  require(on_left == (plan.side == Side::Left),
          "{}: operated_side is {} but tumour.centre_lps_mm has x = {:.1f} mm, which is the "
          "patient's {} (midline_x_mm {:.1f})",
          where, plan.side == Side::Left ? "L" : "R", plan.tumour_centre[0] / mm,
          on_left ? "LEFT" : "RIGHT", midline_x_m / mm);
}

void read_resection(const json& document, const std::string& where, Plan& plan) {
  if (const auto radius = optional_number(document, radius_range.key, where)) {
    check(radius_range, *radius, where);
    require(*radius * mm >= plan.tumour_radius,
            "{}: resection.radius_mm {} is smaller than the tumour's {} mm", where, *radius,
            plan.tumour_radius / mm);
    plan.radius = *radius * mm;
  }
  if (const json* axis = find(document, "resection.axis_towards_skin_lps")) {
    const Vec3 a = triple(*axis, "resection.axis_towards_skin_lps", where);
    require(norm(a) > 1e-6, "{}: resection.axis_towards_skin_lps is zero", where);
    plan.axis = normalised(a);
  }
}

std::vector<Vec3> read_outline(const json& document, const std::string& where) {
  std::vector<Vec3> outline;
  const std::string path = "resection.outline_lps_mm";
  if (const json* value = find(document, path)) {
    require(value->is_array() && value->size() >= 3 && value->size() <= 500,
            "{}: {} is not a list of 3 to 500 points", where, path);
    for (const json& point : *value) {
      outline.push_back(position(point, path, where));
    }
  }
  return outline;
}

std::optional<double> optional_length(const json& document, const Range& range,
                                      const std::string& where) {
  const auto length = optional_number(document, range.key, where);
  if (length) {
    check(range, *length, where);
  }
  return length ? std::optional(*length * mm) : std::nullopt;
}

std::optional<Segment> read_segment(const json& document, const std::string& where) {
  const std::string path = "resection.segment";
  const json* value = find(document, path);
  if (value == nullptr) {
    return std::nullopt;
  }
  require(value->is_object(), "{}: {} is not an object with apex_lps_mm", where, path);
  require(find(document, "resection.outline_lps_mm") == nullptr,
          "{}: resection has both a segment and an outline; keep one", where);
  Segment segment;
  segment.apex =
      position(needed(document, path + ".apex_lps_mm", where), path + ".apex_lps_mm", where);
  if (const auto angle = optional_number(document, path + ".angle_deg", where)) {
    require(*angle >= narrowest_deg && *angle <= widest_deg,
            "{}: {}.angle_deg is {}, not within {} to {}", where, path, *angle, narrowest_deg,
            widest_deg);
    segment.angle = *angle * degree;
  }
  segment.from = optional_length(document, segment_from_range, where);
  segment.to = optional_length(document, segment_to_range, where);
  return segment;
}

std::vector<std::vector<Vec3>> read_incisions(const json& document, const std::string& where) {
  std::vector<std::vector<Vec3>> lines;
  const json* value = find(document, "incisions_lps_mm");
  if (value == nullptr) {
    return lines;
  }
  require(value->is_array(), "{}: incisions_lps_mm is not a list of polylines", where);
  for (const json& line : *value) {
    require(line.is_array() && line.size() >= 2,
            "{}: incisions_lps_mm has a polyline of fewer than two points", where);
    lines.emplace_back();
    for (const json& point : line) {
      lines.back().push_back(position(point, "incisions_lps_mm", where));
    }
  }
  return lines;
}

json to_mm(const Vec3& p) {
  return {p[0] / mm, p[1] / mm, p[2] / mm};
}

}  // namespace

Plan read_plan(const std::string& json_text, const std::string& file_name) {
  const json document = json::parse(json_text, nullptr, false);
  require(document.is_object(), "{}: not a JSON object, so not a plan", file_name);
  Plan plan;
  plan.document = document.dump();
  plan.side = read_side(document, file_name);
  plan.frame = read_frame(document, file_name);
  plan.quadrant = text(document, "quadrant", file_name);
  plan.tumour_centre = position(needed(document, "tumour.centre_lps_mm", file_name),
                                "tumour.centre_lps_mm", file_name);
  const double radius = number(needed(document, tumour_radius_range.key, file_name),
                               tumour_radius_range.key, file_name);
  check(tumour_radius_range, radius, file_name);
  plan.tumour_radius = radius * mm;
  if (const auto margin = optional_number(document, margin_range.key, file_name)) {
    check(margin_range, *margin, file_name);
    plan.margin = *margin * mm;
  }
  if (const auto clearance = optional_number(document, clearance_range.key, file_name)) {
    check(clearance_range, *clearance, file_name);
    plan.clearance = *clearance * mm;
  }
  read_resection(document, file_name, plan);
  plan.outline = read_outline(document, file_name);
  plan.segment = read_segment(document, file_name);
  plan.incisions = read_incisions(document, file_name);
  if (const auto midline = optional_number(document, "midline_x_mm", file_name)) {
    check_side(plan, *midline * mm, file_name);
  }
  return plan;
}

std::string write_plan(const Plan& plan) {
  json document = json::parse(plan.document);
  document["operated_side"] = plan.side == Side::Left ? "L" : "R";
  document["frame"] = plan.frame == Frame::Prone    ? "prone"
                      : plan.frame == Frame::Supine ? "supine"
                                                    : "upright";
  document["coordinates"] =
      plan.frame == Frame::Prone    ? "LPS mm, DICOM patient frame, PRONE configuration"
      : plan.frame == Frame::Supine ? "LPS mm, DICOM patient frame, SUPINE configuration"
                                    : "LPS mm, patient frame of the scan, UPRIGHT configuration";
  if (!plan.quadrant.empty()) {
    document["quadrant"] = plan.quadrant;
  }
  document["tumour"]["centre_lps_mm"] = to_mm(plan.tumour_centre);
  document["tumour"]["equivalent_radius_mm"] = plan.tumour_radius / mm;
  document["planned_margin_mm"] = plan.margin / mm;
  document["clearance_mm"] = plan.clearance / mm;
  if (plan.radius) {
    document["resection"]["radius_mm"] = *plan.radius / mm;
  }
  if (plan.axis) {
    document["resection"]["axis_towards_skin_lps"] = *plan.axis;
  }
  if (!plan.outline.empty()) {
    document["resection"]["outline_lps_mm"] = json::array();
    for (const Vec3& p : plan.outline) {
      document["resection"]["outline_lps_mm"].push_back(to_mm(p));
    }
  }
  if (plan.segment) {
    json& segment = document["resection"]["segment"];
    segment["apex_lps_mm"] = to_mm(plan.segment->apex);
    if (plan.segment->angle) {
      segment["angle_deg"] = *plan.segment->angle / degree;
    }
    if (plan.segment->from) {
      segment["from_mm"] = *plan.segment->from / mm;
    }
    if (plan.segment->to) {
      segment["to_mm"] = *plan.segment->to / mm;
    }
  }
  json lines = json::array();
  for (const auto& line : plan.incisions) {
    lines.push_back(json::array());
    for (const Vec3& p : line) {
      lines.back().push_back(to_mm(p));
    }
  }
  if (!lines.empty()) {
    document["incisions_lps_mm"] = lines;
  }
  return document.dump(1) + "\n";
}

void set_plan_value(Plan& plan, const std::string& key, const std::string& value) {
  std::size_t used = 0;
  double number_mm = 0.0;
  try {
    number_mm = std::stod(value, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  require(used > 0 && used == value.size(), "{}={}: not a number in millimetres", key, value);
  // A cylinder that was tumour plus margin stays that when either changes (0.1 mm: rounding in
  // plans).
  const bool follows =
      plan.radius && std::abs(*plan.radius - plan.tumour_radius - plan.margin) < 0.1 * mm;
  const std::string where = key + "=" + value;
  if (key == "margin_mm") {
    check(margin_range, number_mm, where);
    plan.margin = number_mm * mm;
  } else if (key == "tumour_radius_mm") {
    check(tumour_radius_range, number_mm, where);
    plan.tumour_radius = number_mm * mm;
  } else if (key == "clearance_mm") {
    check(clearance_range, number_mm, where);
    plan.clearance = number_mm * mm;
  } else if (key == "radius_mm") {
    check(radius_range, number_mm, where);
    plan.radius = number_mm * mm;
  } else {
    throw Error(Fault::Usage, "unknown plan value " + key,
                "write one of: margin_mm, radius_mm, clearance_mm, tumour_radius_mm");
  }
  if (follows && key != "radius_mm") {
    plan.radius = plan.tumour_radius + plan.margin;
  }
  require(!plan.radius || *plan.radius >= plan.tumour_radius,
          "{}: the resection's radius of {:.1f} mm is smaller than the tumour's {:.1f} mm", where,
          plan.radius.value_or(0.0) / mm, plan.tumour_radius / mm);
}

}  // namespace sanatrix::surgery
