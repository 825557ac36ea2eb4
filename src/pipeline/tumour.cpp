#include "pipeline/tumour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "geometry/image_filters.hpp"
#include "io/image_file.hpp"
#include "io/slicer_segmentation.hpp"
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

bool is_image(const std::string& name) {
  return std::ranges::any_of(std::array{".nii.gz", ".nii", ".nrrd", ".mha"},
                             [&](const char* end) { return name.ends_with(end); });
}

/// The mask's centre and the sphere of its volume. Of a Slicer segmentation: its tumour.
TumourSphere from_mask(const std::filesystem::path& file, const std::string& name) {
  const std::optional<LabelImage> named = io::read_slicer_segmentation(file);
  const LabelImage mask = named ? *named : io::read_labels(file);
  Mask inside = image_like<unsigned char>(mask);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    const bool tumour =
        named ? mask.voxels[v] == static_cast<unsigned char>(Label::Tumour) : mask.voxels[v] != 0;
    inside.voxels[v] = tumour ? 1 : 0;
  }
  const Parts parts = connected_parts(inside);
  require(!parts.voxels.empty(), "{}: the mask of the tumour is empty", name);
  if (parts.voxels.size() > 1 && 10 * parts.voxels[1] > parts.voxels[0]) {
    throw Error(
        Fault::Input,
        fmt::format("{}: the mask of the tumour has {} separate parts", name, parts.voxels.size()),
        "give one tumour; several are removed one plan after the other");
  }
  TumourSphere tumour;
  const auto count = static_cast<double>(parts.voxels[0]);
  std::size_t v = 0;
  for (int k = 0; k < mask.size[2]; ++k) {
    for (int j = 0; j < mask.size[1]; ++j) {
      for (int i = 0; i < mask.size[0]; ++i, ++v) {
        if (parts.part[v] == 0) {
          tumour.centre_mm += (1.0 / count) * mask.position_mm(i, j, k);
        }
      }
    }
  }
  tumour.radius_mm = std::cbrt(0.75 / std::numbers::pi * count * mask.voxel_volume_mm3());
  return tumour;
}

TumourSphere from_text(const std::filesystem::path& file, const std::string& name) {
  const std::string text = read_text(file);
  const json document = json::parse(text, nullptr, false);
  if (document.is_object() && document.contains("markups")) {
    try {
      return from_markups(document, name);
    } catch (const json::exception& e) {
      throw Error(Fault::Input,
                  fmt::format("{}: these markups cannot be used: {}", name, e.what()));
    }
  }
  const surgery::Plan plan = surgery::read_plan(text, name);
  require(plan.frame == surgery::Frame::Prone,
          "{}: the tumour is given in the supine pose, but the image is prone", name);
  return {1e3 * plan.tumour_centre, 1e3 * plan.tumour_radius};
}

}  // namespace

TumourSphere read_tumour(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const TumourSphere tumour = is_image(name) ? from_mask(file, name) : from_text(file, name);
  require(tumour.radius_mm >= 0.5 && tumour.radius_mm <= 60.0,
          "{}: the tumour's radius of {:.1f} mm is not within 0.5 to 60 mm", name,
          tumour.radius_mm);
  return tumour;
}

void check_agreement(const TumourSphere& tumour, const surgery::Plan& plan) {
  const Vec3 planned = 1e3 * plan.tumour_centre;
  const double apart = norm(tumour.centre_mm - planned);
  if (plan.frame == surgery::Frame::Prone && apart > 1e3 * plan.tumour_radius + tumour.radius_mm) {
    throw Error(
        Fault::Input,
        fmt::format("plan and --tumour disagree: the plan's tumour lies at x = {:.0f} mm in "
                    "the {} breast, the given one {:.0f} mm away at x = {:.0f} mm",
                    planned[0], plan.side == surgery::Side::Left ? "LEFT" : "RIGHT", apart,
                    tumour.centre_mm[0]),
        "give a plan and a tumour of the same examination (LPS, +x is the patient's left)");
  }
}

std::string tumour_text(const TumourSphere& tumour) {
  return json{{"centre_lps_mm", tumour.centre_mm}, {"radius_mm", tumour.radius_mm}}.dump(2) + "\n";
}

TumourSphere tumour_from(const std::string& text) {
  const json j = json::parse(text);
  return {j.at("centre_lps_mm").get<Vec3>(), j.at("radius_mm").get<double>()};
}

}  // namespace sanatrix::pipeline
