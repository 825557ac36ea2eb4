#include "pipeline/segmentation_store.hpp"

#include <nlohmann/json.hpp>

#include "core/archive.hpp"
#include "core/files.hpp"
#include "imaging/skin_landmarks.hpp"
#include "io/image_file.hpp"
#include "io/slicer_segmentation.hpp"

namespace sanatrix::pipeline {
namespace {

std::string landmarks_text(const imaging::Segmentation& segmentation) {
  nlohmann::json list = nlohmann::json::object();
  for (const imaging::SkinLandmark& mark : imaging::skin_landmarks(segmentation)) {
    list[mark.name] = {{"lps_mm", nullptr}, {"confidence", mark.confidence}};
    if (mark.at_mm) {
      list[mark.name]["lps_mm"] = *mark.at_mm;
    } else {
      list[mark.name]["missing"] = mark.missing;
    }
  }
  return list.dump(2) + "\n";
}

}  // namespace

void save_segmentation(const imaging::Segmentation& segmentation,
                       const std::filesystem::path& folder) {
  io::write_labels(segmentation.labels, folder / "labels.nii.gz");
  io::write_slicer_segmentation(segmentation.labels, folder / "segmentation.seg.nrrd");
  io::write_image(segmentation.fibroglandular, folder / "fibroglandular.nii.gz");
  const LabelImage& grid = segmentation.labels;
  Archive archive;  // NIfTI keeps the grid in single precision; this keeps it exactly
  archive.reals["spacing_mm"] = {grid.spacing_mm.begin(), grid.spacing_mm.end()};
  archive.reals["origin_mm"] = {grid.origin_mm.begin(), grid.origin_mm.end()};
  archive.reals["midline_x_mm"] = {segmentation.midline_x_mm};
  for (const std::size_t side : {0U, 1U}) {
    const Vec3& nipple = segmentation.nipple_mm[side];
    archive.reals[side == 0 ? "nipple_right_mm" : "nipple_left_mm"] = {nipple.begin(),
                                                                       nipple.end()};
  }
  archive.save(folder / "landmarks.bin");
  write_text(folder / "landmarks.json", landmarks_text(segmentation));
}

imaging::Segmentation load_segmentation(const std::filesystem::path& folder) {
  imaging::Segmentation segmentation;
  segmentation.labels = io::read_labels(folder / "labels.nii.gz");
  segmentation.fibroglandular = io::read_image(folder / "fibroglandular.nii.gz");
  const Archive archive = Archive::load(folder / "landmarks.bin");
  const auto vec3 = [&](const std::string& name) {
    const std::vector<double>& v = archive.real(name);
    return Vec3{v.at(0), v.at(1), v.at(2)};
  };
  const auto place = [&](auto& image) {
    image.spacing_mm = vec3("spacing_mm");
    image.origin_mm = vec3("origin_mm");
    image.direction = identity3;
  };
  place(segmentation.labels);
  place(segmentation.fibroglandular);
  segmentation.midline_x_mm = archive.real("midline_x_mm").at(0);
  segmentation.nipple_mm = {vec3("nipple_right_mm"), vec3("nipple_left_mm")};
  return segmentation;
}

std::optional<Vec3> sure_sternal_notch(const std::filesystem::path& folder) {
  const nlohmann::json marks = nlohmann::json::parse(read_text(folder / "landmarks.json"));
  const nlohmann::json& notch = marks.at("sternal_notch");
  if (notch.at("confidence").get<double>() < imaging::sure_landmark) {
    return std::nullopt;
  }
  return 1e-3 * notch.at("lps_mm").get<Vec3>();
}

}  // namespace sanatrix::pipeline
