#include "pipeline/case_inputs.hpp"

#include <functional>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "imaging/segmentation.hpp"
#include "io/image_file.hpp"
#include "io/scan_file.hpp"
#include "io/slicer_segmentation.hpp"
#include "pipeline/intake.hpp"
#include "pipeline/standing_scan.hpp"
#include "pipeline/tumour.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One of the extensions of single-file images, or Error{Input}.
std::string image_extension(const fs::path& file) {
  const std::string name = file.filename().string();
  for (std::string known : {".nii.gz", ".nii", ".nrrd", ".mha"}) {
    if (name.ends_with(known)) {
      return known;
    }
  }
  throw Error(Fault::Input, fmt::format("{}: this is not an image file that can be read", name),
              "give a .nii.gz, .nii, .nrrd or .mha file");
}

/// Writes a file of the case under a neutral name (the given one may name a person), read-only.
InputFile take_in(const fs::path& folder, const std::string& name,
                  const std::function<void(const fs::path&)>& write) {
  const fs::path to = folder / "inputs" / name;
  write(to);
  fs::permissions(to, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read);
  return {"inputs/" + name, sha256_of_file(to)};
}

/// Labels are written anew: headers of image files may name a person too. What Slicer saved is
/// brought to our label table by the names of its segments.
void take_in_labels(const fs::path& file, Case& patient) {
  const std::string extension = image_extension(file);
  const std::optional<LabelImage> named = io::read_slicer_segmentation(file);
  const LabelImage labels = named ? *named : io::read_labels(file);
  if (named) {
    patient.label_preset = "sanatrix";
  }
  patient.inputs["labels"] = take_in(patient.folder, "labels" + extension,
                                     [&](const fs::path& to) { io::write_labels(labels, to); });
}

void take_in_image(const GivenImage& given, Case& patient) {
  patient.inputs["image"] = take_in(patient.folder, "image.nrrd",
                                    [&](const fs::path& to) { io::write_image(given.image, to); });
  patient.inputs["image_facts"] = take_in(patient.folder, "image.json",
                                          [&](const fs::path& to) { write_text(to, given.facts); });
}

/// Labels hold their tumour; to an image it must be told.
std::optional<imaging::TumourSphere> tumour_of(const NewCase& given) {
  std::optional<surgery::Plan> plan;
  if (given.plan) {
    plan = surgery::read_plan(read_text(*given.plan), given.plan->filename());
  }
  if (given.tumour) {
    const imaging::TumourSphere tumour = read_tumour(*given.tumour);
    if (plan) {
      check_agreement(tumour, *plan);
    }
    return tumour;
  }
  const bool told = plan && plan->frame == surgery::Frame::Prone && !given.labels;
  return told ? std::optional(read_tumour(*given.plan)) : std::nullopt;
}

void check_plan(const fs::path& file) {
  surgery::read_plan(read_text(file), file.filename());
}

/// Coordinates in a pose in which this patient was not captured would be silently wrong.
void check_pose(const Case& patient, const surgery::Plan& plan, const std::string& name) {
  const bool fits = plan.frame == surgery::Frame::Supine ||
                    (plan.frame == surgery::Frame::Upright) == patient.scan_only();
  require(fits, "{}: the plan's coordinates are of the {} pose, but this case was made from a {}",
          name, patient.scan_only() ? "prone" : "upright",
          patient.scan_only() ? "standing scan; say where the tumour lies from the nipple, or use "
                                "frame \"upright\" (docs/user/plan.md)"
                              : "prone image");
}

std::string plan_text(const Case& patient, const fs::path& file) {
  const std::string text = read_text(file);
  return patient.scan_only()
             ? placed_plan(text, load_standing_scan(patient), file.filename().string())
             : text;
}

/// A new frame of the scan moves a plan that is given from the nipple along; the coordinates of
/// other plans would mean another place.
void place_again(Case& patient) {
  find_standing_frame(patient);
  if (!patient.has_plan()) {
    return;
  }
  json plan = json::parse(read_text(patient.input("plan")));
  require(plan.at("tumour").contains("from_nipple_mm"),
          "the case's plan has coordinates of its scan as it was placed before; make a new case "
          "with the new scan or landmarks");
  plan["tumour"].erase("centre_lps_mm");
  const std::string text =
      anonymous_plan(placed_plan(plan.dump(), load_standing_scan(patient), "plan"));
  patient.inputs["plan"] =
      take_in(patient.folder, fmt::format("plan-{:.8}.json", sha256_of_text(text)),
              [&](const fs::path& to) { write_text(to, text); });
}

void take_in_landmarks(Case& patient, const std::string& name, const fs::path& file) {
  const std::string text = read_text(file);
  const json j = json::parse(text, nullptr, false);
  require(j.is_object() &&
              (j.contains("landmarks_scan_mm") || (patient.scan_only() && j.contains("markups"))),
          "{}: it has no object landmarks_scan_mm with nipple_L, nipple_R, sternal_notch",
          file.filename().string());
  patient.inputs[name] =
      take_in(patient.folder, fmt::format("{}-{:.8}.json", name, sha256_of_text(text)),
              [&](const fs::path& to) { write_text(to, text); });
}

void take_in_scan(Case& patient, const std::string& name, const fs::path& file) {
  io::read_scan(file, io::parse_scan_unit(patient.parameters.text("outcome.scan_unit")));
  std::erase_if(patient.inputs, [&](const auto& entry) {
    return entry.first == name || entry.first.starts_with(name + ".");
  });
  const std::string stem = fmt::format("{}-{:.8}", name, sha256_of_file(file));
  const std::vector<std::string> copies = io::copy_scan(file, patient.folder / "inputs", stem);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const fs::path copy = patient.folder / "inputs" / copies[i];
    const std::string key = i == 0 ? name : fmt::format("{}.{}", name, i);
    patient.inputs[key] = {"inputs/" + copies[i], sha256_of_file(copy)};
    fs::permissions(copy, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read);
  }
}

}  // namespace

Case create_case(const fs::path& folder, const NewCase& given) {
  require(!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder)),
          "{}: this folder exists already and is not empty", folder.filename().string());
  imaging::parse_label_preset(given.label_preset);
  const bool scan_only = !given.labels && !given.image;
  ensure(!scan_only || given.scans.contains("scan"), "a case needs labels, an image or a scan");
  std::optional<GivenImage> image;
  if (given.image) {
    image = read_given_image(*given.image, given.series);
  }
  if (given.plan && !scan_only) {
    check_plan(*given.plan);
  }
  const std::optional<imaging::TumourSphere> tumour = scan_only ? std::nullopt : tumour_of(given);
  const fs::path place = fs::absolute(folder).lexically_normal();
  const fs::path final = place.filename().empty() ? place.parent_path() : place;
  const fs::path aside = final.parent_path() / fmt::format(".{}.new", final.filename().string());
  std::error_code problem;
  fs::remove_all(aside, problem);
  fs::create_directories(aside / "inputs", problem);
  if (problem) {
    throw Error(Fault::Resource, fmt::format("{}: cannot be created: {}", final.filename().string(),
                                             problem.message()));
  }
  Case patient;
  patient.folder = aside;
  patient.label_preset = given.label_preset;
  try {
    if (given.labels) {
      take_in_labels(*given.labels, patient);
    }
    if (image) {
      take_in_image(*image, patient);
    }
    for (const std::string& assignment : given.parameters) {
      patient.parameters.set(assignment);
    }
    replace_scans(patient, given.scans);
    if (given.plan) {
      replace_plan(patient, *given.plan);
    }
    if (tumour) {
      patient.inputs["tumour"] = take_in(
          aside, "tumour.json", [&](const fs::path& to) { write_text(to, tumour_text(*tumour)); });
    }
  } catch (...) {
    fs::remove_all(aside, problem);
    throw;
  }
  const std::string first = given.labels ? "labels" : given.image ? "image" : "scan";
  patient.pseudonym = fmt::format("case-{:.8}", patient.inputs[first].sha256);
  save_case(patient);
  fs::remove(final, problem);  // the empty folder, if there was one
  fs::rename(aside, final);
  sync_to_disk(final.parent_path());
  patient.folder = final;
  return patient;
}

void replace_plan(Case& patient, const fs::path& plan_file) {
  const std::string given = plan_text(patient, plan_file);
  check_pose(patient, surgery::read_plan(given, plan_file.filename()), plan_file.filename());
  // Named by content: a kill before case.json is saved leaves the old plan in force.
  const std::string text = anonymous_plan(given);
  const std::string name = fmt::format("plan-{:.8}.json", sha256_of_text(text));
  patient.inputs["plan"] =
      take_in(patient.folder, name, [&](const fs::path& to) { write_text(to, text); });
}

void drop_plan(Case& patient) {
  patient.inputs.erase("plan");
  patient.parameters.reset("surgery.");
}

void replace_scans(Case& patient, const std::map<std::string, fs::path>& files) {
  if (files.contains("scan") && patient.scan_only()) {
    patient.inputs.erase("scan_landmarks");  // those were marked on the scan before
  }
  for (const auto& [name, file] : files) {
    name.ends_with("_landmarks") ? take_in_landmarks(patient, name, file)
                                 : take_in_scan(patient, name, file);
  }
  // Once, when scan, landmarks and unit are all there.
  if (patient.scan_only() &&
      (files.contains("scan") || files.contains("scan_landmarks") || !stands_in_unit(patient))) {
    place_again(patient);
  }
}

}  // namespace sanatrix::pipeline
