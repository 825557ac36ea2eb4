#include "pipeline/tumour.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::pipeline {
namespace {

using imaging::TumourSphere;
using nlohmann::json;

TumourSphere from_markups(const json& document, const std::string& name) {
  const json& markup = document.at("markups").at(0);
  const double flip = markup.value("coordinateSystem", "LPS") == "RAS" ? -1.0 : 1.0;
  const auto lps = [&](const json& p) {
    const Vec3 v = p.get<Vec3>();
    return Vec3{flip * v[0], flip * v[1], v[2]};
  };
  if (markup.contains("center") && markup.contains("size")) {
    const Vec3 size = markup["size"].get<Vec3>();
    return {lps(markup["center"]), 0.5 * std::cbrt(size[0] * size[1] * size[2])};
  }
  Vec3 centre{};
  std::vector<Vec3> points;
  for (const json& point : markup.at("controlPoints")) {
    points.push_back(lps(point.at("position")));
    centre += points.back();
  }
  if (points.size() < 2) {
    throw Error(Fault::Input,
                fmt::format("{}: one point does not say how large the tumour is", name),
                "draw a line across the tumour, or an ROI around it");
  }
  TumourSphere tumour{(1.0 / static_cast<double>(points.size())) * centre, 0.0};
  for (const Vec3& p : points) {
    tumour.radius_mm = std::max(tumour.radius_mm, norm(p - tumour.centre_mm));
  }
  return tumour;
}

}  // namespace

TumourSphere read_tumour(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::string text = read_text(file);
  const json document = json::parse(text, nullptr, false);
  TumourSphere tumour;
  if (document.is_object() && document.contains("markups")) {
    try {
      tumour = from_markups(document, name);
    } catch (const json::exception& e) {
      throw Error(Fault::Input,
                  fmt::format("{}: these markups cannot be used: {}", name, e.what()));
    }
  } else {
    const surgery::Plan plan = surgery::read_plan(text, name);
    require(plan.frame == surgery::Frame::Prone,
            "{}: the tumour is given in the supine pose, but the image is prone", name);
    tumour = {1e3 * plan.tumour_centre, 1e3 * plan.tumour_radius};
  }
  require(tumour.radius_mm >= 0.5 && tumour.radius_mm <= 60.0,
          "{}: the tumour's radius of {:.1f} mm is not within 0.5 to 60 mm", name,
          tumour.radius_mm);
  return tumour;
}

std::string tumour_text(const TumourSphere& tumour) {
  return json{{"centre_lps_mm", tumour.centre_mm}, {"radius_mm", tumour.radius_mm}}.dump(2) + "\n";
}

TumourSphere tumour_from(const std::string& text) {
  const json j = json::parse(text);
  return {j.at("centre_lps_mm").get<Vec3>(), j.at("radius_mm").get<double>()};
}

}  // namespace sanatrix::pipeline
