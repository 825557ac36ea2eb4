// sanatrix new CASE: makes a case folder from an image or from labels.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/case_inputs.hpp"
#include "unpacked.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::string folder, labels, image, plan, tumour;
  std::string preset = "sanatrix", pose, density, scan_unit;
  ScanOptions scans;
  int series = 0;
};

std::optional<std::filesystem::path> path_of(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<std::filesystem::path>(text);
}

/// What was noticed while the image was read.
nlohmann::json warnings_of(const pipeline::Case& made) {
  if (!made.inputs.contains("image_facts")) {
    return nlohmann::json::array();
  }
  const auto facts = nlohmann::json::parse(read_text(made.input("image_facts")));
  return facts.value("warnings", nlohmann::json::array());
}

std::vector<std::string> parameters_of(const Arguments& given) {
  std::vector<std::string> parameters;
  if (!given.density.empty()) {
    parameters.push_back("segment.density=" + given.density);
  }
  if (!given.scan_unit.empty()) {
    parameters.push_back("outcome.scan_unit=" + given.scan_unit);
  }
  return parameters;
}

/// What was found on a scan, for a look before the case runs.
std::string frame_words(const nlohmann::json& frame) {
  const auto place = [&](const nlohmann::json& mm) {
    return fmt::format("({:.0f}, {:.0f}, {:.0f})", mm.at(0).get<double>(), mm.at(1).get<double>(),
                       mm.at(2).get<double>());
  };
  std::string words = "nipples at LPS";
  for (const char* side : {"R", "L"}) {
    const nlohmann::json& find = frame.at("nipples").at(side);
    words +=
        fmt::format(" {} {} +-{:.0f} mm (by {})", side, place(frame.at("nipple_lps_mm").at(side)),
                    find.at("doubt_mm").get<double>(), find.at("from").get<std::string>());
  }
  if (frame.contains("sternal_notch_lps_mm")) {
    words += fmt::format(", sternal notch at {} mm", place(frame["sternal_notch_lps_mm"]));
  }
  for (const auto& note : frame.at("notes")) {
    words += "\nnote: " + note.get<std::string>();
  }
  return words;
}

int make(const Arguments& given, const Common& common) {
  const bool scan_only = given.labels.empty() && given.image.empty();
  if (scan_only && given.scans.scan.empty()) {
    throw Error(Fault::Usage, "new needs --image or --labels, or --scan with --pose upright",
                "for example: sanatrix new out/case --image dicom-folder --plan plan.json");
  }
  if (scan_only && given.pose.empty()) {
    throw Error(Fault::Usage, "a case from a scan alone needs the pose in which it was taken",
                "add --pose upright, or give --image or --labels, too");
  }
  if (!scan_only && !(given.pose.empty() && given.density.empty())) {
    throw Error(Fault::Usage, "--pose and --density are for cases from a scan alone",
                "leave them out: with an image or labels, --scan is a scan before surgery");
  }
  Unpacked unpacked(given.folder);
  const pipeline::NewCase inputs{.labels = unpacked(given.labels),
                                 .label_preset = given.preset,
                                 .image = unpacked(given.image),
                                 .series = given.series,
                                 .plan = path_of(given.plan),
                                 .tumour = path_of(given.tumour),
                                 .scans = unpacked(given.scans.given()),
                                 .parameters = parameters_of(given)};
  const pipeline::Case made = pipeline::create_case(given.folder, inputs);
  if (common.json) {
    nlohmann::json j{{"case", made.pseudonym},
                     {"inputs", nlohmann::json::object()},
                     {"warnings", warnings_of(made)}};
    for (const auto& [name, input] : made.inputs) {
      j["inputs"][name] = input.sha256;
    }
    fmt::print("{}\n", j.dump(2));
  } else {
    for (const auto& warning : warnings_of(made)) {
      fmt::print(stderr, "warning: {}\n", warning.get<std::string>());
    }
    if (scan_only) {
      const auto frame = nlohmann::json::parse(read_text(made.input("scan_frame")));
      fmt::print("scan in {}; {}\n", frame.at("unit").get<std::string>(), frame_words(frame));
    }
    fmt::print("created {} ({}); next: sanatrix run {}\n", given.folder, made.pseudonym,
               given.folder);
  }
  return 0;
}

}  // namespace

void add_new(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "new",
      "Examples: sanatrix new out/case --image dicom-folder --plan plan.json\n"
      "          sanatrix new out/case --labels labels.nii.gz --plan plan.json\n"
      "          sanatrix new out/case --scan torso.obj --pose upright --density c\n\n"
      "Creates a case folder from a prone breast MRI (docs/user/images.md, labels.md, plan.md).\n"
      "Nothing that identifies the patient is taken in.");
  command->add_option("CASE", given->folder, "folder to create")->required();
  command->add_option(
      "--labels", given->labels,
      "label volume instead of the automatic segmentation: .nii.gz, .nii, .nrrd, .mha");
  command->add_option("--image", given->image,
                      "prone MRI: DICOM folder, .nii.gz, .nii, .nrrd or .mha, or a .zip of these");
  command
      ->add_option("--series", given->series,
                   "which series of the DICOM folder (number of `sanatrix inspect`)")
      ->check(CLI::Range(1, 100000));
  command->add_option("--labels-preset", given->preset, "label table: sanatrix or pelicano")
      ->capture_default_str();
  command->add_option("--plan", given->plan, "surgical plan (JSON)");
  given->scans.add_to(*command);
  command->add_option("--pose", given->pose, "of a scan without image: upright")
      ->check(CLI::IsMember({"upright"}));
  command->add_option("--scan-unit", given->scan_unit, "of --scan; default: from its size")
      ->check(CLI::IsMember({"mm", "cm", "in", "m"}));
  command
      ->add_option("--density", given->density,
                   "density class of the breasts for a scan without image (default b)")
      ->check(CLI::IsMember({"a", "b", "c", "d"}));
  command->add_option(
      "--tumour", given->tumour,
      "where the tumour is: Slicer markups (.mrk.json) or a mask; default: as the plan "
      "says");
  add_json(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return make(*given, common);
    };
  });
}

}  // namespace sanatrix::app
