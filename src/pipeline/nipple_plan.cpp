// Plans of a surgeon without an image: where the tumour lies as seen from the nipple.
#include <cmath>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "pipeline/standing_scan.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;

/// Of a quadrant ("upper outer"), the middle of its hours; nothing for other words.
std::optional<double> quadrant_hour(const json& plan, bool left) {
  const std::string quadrant = plan.value("quadrant", "");
  const bool upper = quadrant.starts_with("upper"), lower = quadrant.starts_with("lower");
  const bool outer = quadrant.ends_with("outer"), inner = quadrant.ends_with("inner");
  if (!(upper || lower) || !(outer || inner)) {
    return std::nullopt;
  }
  const double right_hand = upper ? 1.5 : 4.5;  // the patient's left is on the right hand
  return left == outer ? right_hand : 12.0 - right_hand;
}

/// Hours on the clock face as one sees it who faces the patient; the same for both breasts.
double clock_hour(const json& tumour, const json& plan, bool left, const std::string& name) {
  const std::optional<double> quadrant = quadrant_hour(plan, left);
  if (tumour.contains("clock")) {
    const json& clock = tumour["clock"];
    double hour = -1, minute = 0;
    if (clock.is_number()) {
      hour = clock.get<double>();
    } else if (clock.is_string()) {
      char rest = 0;
      const int read =
          std::sscanf(clock.get<std::string>().c_str(), "%lf:%lf%c", &hour, &minute, &rest);
      hour = read >= 1 && read <= 2 && minute >= 0 && minute < 60 ? hour + minute / 60 : -1;
    }
    require(hour >= 0 && hour <= 13, "{}: tumour.clock is {}; write an hour such as 2 or \"10:30\"",
            name, clock.dump());
    // An hour beyond its border a quadrant may still be called by its name.
    const double apart = quadrant ? std::abs(std::remainder(hour - *quadrant, 12.0)) : 0.0;
    require(apart <= 2.5,
            "{}: {} o'clock is not {} of the patient's {} breast (clock as seen facing her, 3 is "
            "her left); correct operated_side, tumour.clock or quadrant",
            name, clock.dump(), plan.value("quadrant", ""), left ? "left" : "right");
    return hour;
  }
  require(quadrant.has_value(),
          "{}: neither tumour.clock nor a quadrant (upper outer, lower inner, ...) says in which "
          "direction from the nipple the tumour lies",
          name);
  return *quadrant;
}

double length_mm(const json& tumour, const char* key, double low, double high,
                 const std::string& name) {
  const json value = tumour.value(key, json());
  require(value.is_number(), "{}: tumour.{} is missing or not a number [mm]", name, key);
  const double mm = value.get<double>();
  require(mm >= low && mm <= high, "{}: tumour.{} is {} mm, not within {} to {} mm", name, key, mm,
          low, high);
  return mm;
}

/// Walks on the skin from the nipple in the upright plane through a frontal direction.
class Walk {
 public:
  explicit Walk(const TriMesh& skin) : skin_(skin), tree_(skin), normal_(vertex_normals(skin)) {}

  /// Place and outward normal after a length [m].
  [[nodiscard]] std::pair<Vec3, Vec3> go(const Vec3& from, const Vec3& frontal,
                                         double length) const {
    constexpr double step = 5e-4;
    const Vec3 across = cross(frontal, Vec3{0, -1, 0});  // of the plane
    Vec3 at = tree_.closest(from).point, heading = frontal, normal = normal_at(at);
    for (double gone = 0; gone < length; gone += step) {
      Vec3 along = cross(across, normal);
      along = dot(along, heading) < 0 ? -1.0 * along : along;
      if (norm(along) > 0.1) {
        heading = normalised(along);
      }
      const Vec3 next = tree_.closest(at + step * heading).point;
      const double off = dot(next - from, across);
      at = next - off * across;
      normal = normal_at(at);
    }
    return {tree_.closest(at).point, normal};
  }

 private:
  [[nodiscard]] Vec3 normal_at(const Vec3& p) const {
    const auto& t = skin_.triangles[static_cast<std::size_t>(tree_.closest(p).triangle)];
    Vec3 sum{};
    for (const int v : t) {
      sum += normal_[static_cast<std::size_t>(v)];
    }
    return normalised(sum);
  }
  const TriMesh& skin_;
  SurfaceTree tree_;
  std::vector<Vec3> normal_;
};

}  // namespace

std::string placed_plan(const std::string& json_text, const StandingScan& scan,
                        const std::string& name) {
  json plan = json::parse(json_text, nullptr, false);
  if (!plan.is_object() || !plan.contains("tumour") || !plan["tumour"].is_object() ||
      !plan["tumour"].contains("from_nipple_mm")) {
    return json_text;
  }
  json& tumour = plan["tumour"];
  require(!tumour.contains("centre_lps_mm"),
          "{}: the tumour has both centre_lps_mm and from_nipple_mm; keep one", name);
  const std::string side = plan.value("operated_side", json("")).dump();
  require(side == "\"L\"" || side == "\"R\"", "{}: operated_side is {}, write \"L\" or \"R\"", name,
          side);
  const bool left = side == "\"L\"";
  const double hour = clock_hour(tumour, plan, left, name);
  const double distance = 1e-3 * length_mm(tumour, "from_nipple_mm", 0, 150, name);
  const double depth = 1e-3 * length_mm(tumour, "depth_mm", 0, 120, name);
  const double diameter = length_mm(tumour, "diameter_mm", 1, 120, name);
  const double angle = hour * std::numbers::pi / 6;
  const auto [place, normal] = Walk(scan.skin).go(scan.nipple[left ? 1 : 0],
                                                  {std::sin(angle), 0, std::cos(angle)}, distance);
  tumour["clock"] = hour;
  tumour["centre_lps_mm"] = 1e3 * (place - depth * normal);
  tumour["equivalent_radius_mm"] = 0.5 * diameter;
  plan["frame"] = "upright";
  plan["midline_x_mm"] = 0.0;
  return plan.dump(1) + "\n";
}

}  // namespace sanatrix::pipeline
