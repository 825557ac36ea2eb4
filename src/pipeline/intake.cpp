#include "pipeline/intake.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "io/dicom.hpp"
#include "io/image_file.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool is_image_file(const fs::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::any_of(std::array{".nii.gz", ".nii", ".nrrd", ".mha"},
                             [&](const char* end) { return name.ends_with(end); });
}

std::string name_of(io::Weighting weighting) {
  switch (weighting) {
    case io::Weighting::T1:
      return "T1";
    case io::Weighting::T2:
      return "T2";
    case io::Weighting::Other:
      return "other";
    case io::Weighting::Unknown:
      break;
  }
  return "unknown";
}

json rounded(const Vec3& v) {
  json list = json::array();
  for (const double x : v) {
    list.push_back(std::round(x * 1e4) / 1e4);
  }
  return list;
}

json describe(const io::DicomVolume& volume, bool chosen) {
  const io::Acquisition& a = volume.acquisition;
  json j{{"series", volume.index},
         {"series_number", a.series_number},
         {"modality", a.modality.text()},
         {"weighting", name_of(a.weighting)},
         {"plane", volume.plane()},
         {"patient_position", a.patient_position.text()},
         {"size", volume.size},
         {"spacing_mm", rounded(volume.spacing_mm)},
         {"extent_mm", rounded(volume.extent_mm())},
         {"thickness_mm", volume.thickness_mm},
         {"repetition_time_ms", a.repetition_time_ms},
         {"echo_time_ms", a.echo_time_ms},
         {"field_strength_t", a.field_strength_t},
         {"fat_suppressed", a.fat_suppressed},
         {"contrast_agent", a.contrast_agent},
         {"chosen", chosen},
         {"warnings", volume.warnings}};
  if (!volume.unfit.empty()) {
    j["not_chosen_because"] = volume.unfit;
  }
  return j;
}

json describe(const Image3<float>& image) {
  const auto [low, high] = std::minmax_element(image.voxels.begin(), image.voxels.end());
  return {{"size", image.size},
          {"spacing_mm", rounded(image.spacing_mm)},
          {"origin_lps_mm", rounded(image.origin_mm)},
          {"value_min", *low},
          {"value_max", *high}};
}

void require_contrast(const Image3<float>& image, const fs::path& path) {
  const auto [low, high] = std::ranges::minmax_element(image.voxels);
  if (!(*low < *high)) {
    throw Error(Fault::Input,
                fmt::format("{}: all voxels of the image have the value {}",
                            path.filename().string(), *low),
                "export the image again");
  }
}

/// Of another examination of the same patient, before or after an operation, say.
std::optional<int> of_another_examination(const io::DicomFolder& folder,
                                          const io::DicomVolume& chosen) {
  for (const io::DicomVolume& volume : folder.volumes) {
    if (volume.unfit.empty() && volume.slices[0].examination != chosen.slices[0].examination) {
      return volume.index;
    }
  }
  return std::nullopt;
}

GivenImage read_series(const fs::path& path, int series) {
  const io::DicomFolder folder = io::scan_dicom(path);
  const io::DicomVolume& volume = io::choose_volume(folder, series);
  GivenImage given{.image = io::read_dicom(folder, volume), .facts = {}};
  std::vector<std::string> warnings = volume.warnings;
  if (const auto other = of_another_examination(folder, volume); other && series == 0) {
    warnings.push_back(
        fmt::format("series {} was chosen; series {}, of another examination, would do as well",
                    volume.index, *other));
  }
  if (series != 0 && !volume.unfit.empty()) {
    warnings.push_back("the series was chosen by hand although " + volume.unfit);
  }
  if (volume.acquisition.patient_position.text().empty()) {
    warnings.emplace_back("the images do not say how the patient lay; prone is assumed");
  }
  json facts = describe(volume, true);
  facts["warnings"] = warnings;
  facts["source"] = "DICOM";
  // Codes of CID 7050: Basic Application Confidentiality Profile; nothing but voxels and the facts
  // of this file is kept, so no retain option applies.
  facts["deidentification"] = {{"method_codes", {"113100"}},
                               {"elements_left_behind", folder.elements_left_behind},
                               {"private_left_behind", folder.private_left_behind}};
  given.facts = facts.dump(2) + "\n";
  return given;
}

// --- plans ---------------------------------------------------------------------------------------

bool names_somebody(std::string key) {
  std::ranges::transform(key, key.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array<std::string_view, 22> suspicious{
      "patient", "name",    "birth", "date",      "time",      "mrn",        "hospital", "surgeon",
      "author",  "address", "phone", "mail",      "note",      "comment",    "remark",   "descr",
      "source",  "user",    "study", "accession", "physician", "institution"};
  return key == "id" || key.ends_with("_id") || key.ends_with("ID") ||
         std::ranges::any_of(suspicious,
                             [&](std::string_view s) { return key.find(s) != std::string::npos; });
}

/// Texts with a meaning to us: a pose, a side, a place in the breast, a shape.
bool is_coded(const std::string& text) {
  constexpr std::array<std::string_view, 50> known{"l",
                                                   "r",
                                                   "left",
                                                   "right",
                                                   "prone",
                                                   "supine",
                                                   "upright",
                                                   "upper",
                                                   "lower",
                                                   "inner",
                                                   "outer",
                                                   "central",
                                                   "medial",
                                                   "lateral",
                                                   "axillary",
                                                   "tail",
                                                   "retroareolar",
                                                   "quadrant",
                                                   "lps",
                                                   "ras",
                                                   "mm",
                                                   "dicom",
                                                   "patient",
                                                   "frame",
                                                   "configuration",
                                                   "cylinder",
                                                   "axis",
                                                   "chest-wall",
                                                   "normal",
                                                   "through",
                                                   "tumour",
                                                   "centre",
                                                   "from",
                                                   "skin",
                                                   "to",
                                                   "fascia",
                                                   "wedge",
                                                   "ellipsoid",
                                                   "sphere",
                                                   "painted",
                                                   "freehand",
                                                   "radial",
                                                   "circumareolar",
                                                   "periareolar",
                                                   "inframammary",
                                                   "imf",
                                                   "lazy-s",
                                                   "simple",
                                                   "none",
                                                   "hemi-lumpectomy"};
  std::string word;
  bool all = true;
  const auto end_word = [&] {
    all = all && (word.empty() || std::ranges::find(known, word) != known.end());
    word.clear();
  };
  for (const char c : text) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '-') {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (c == ' ' || c == ',' || c == '/' || c == '_') {
      end_word();
    } else {
      return false;
    }
  }
  end_word();
  return all;
}

json without_words(const json& value) {
  if (value.is_object()) {
    json kept = json::object();
    for (const auto& [key, inner] : value.items()) {
      if (names_somebody(key) || (inner.is_string() && !is_coded(inner.get<std::string>()))) {
        continue;
      }
      kept[key] = without_words(inner);
    }
    return kept;
  }
  if (value.is_array()) {
    json kept = json::array();
    for (const json& inner : value) {
      if (!inner.is_string() || is_coded(inner.get<std::string>())) {
        kept.push_back(without_words(inner));
      }
    }
    return kept;
  }
  return value;
}

}  // namespace

GivenImage read_given_image(const fs::path& path, int series) {
  require(fs::exists(path), "{} does not exist", path.string());
  if (!is_image_file(path)) {
    GivenImage given = read_series(path, series);
    require_contrast(given.image, path);
    return given;
  }
  GivenImage given{.image = io::read_image(path), .facts = {}};
  require_contrast(given.image, path);
  json facts = describe(given.image);
  facts["source"] = "image file";
  given.facts = facts.dump(2) + "\n";
  return given;
}

std::string inspect_image(const fs::path& path, int series) {
  require(fs::exists(path), "{} does not exist", path.string());
  if (is_image_file(path)) {
    json j = describe(io::read_image(path));
    j["kind"] = "image file";
    return j.dump(2);
  }
  const io::DicomFolder folder = io::scan_dicom(path);
  json j{{"kind", "DICOM"},
         {"files", folder.files.size()},
         {"files_without_image", folder.files_without_image},
         {"elements_that_would_be_left_behind", folder.elements_left_behind},
         {"private_elements", folder.private_left_behind},
         {"series", json::array()}};
  const io::DicomVolume* chosen = nullptr;
  try {
    chosen = &io::choose_volume(folder, series);
  } catch (const Error& e) {  // nothing fits: that is what the user wants to see
    j["nothing_chosen"] = e.what();
  }
  for (const io::DicomVolume& volume : folder.volumes) {
    j["series"].push_back(describe(volume, &volume == chosen));
  }
  return j.dump(2);
}

std::string anonymous_plan(const std::string& json_text) {
  const json document = json::parse(json_text, nullptr, false);
  return document.is_object() ? without_words(document).dump(1) + "\n" : json_text;
}

}  // namespace sanatrix::pipeline
