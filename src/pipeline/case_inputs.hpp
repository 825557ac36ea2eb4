// What a case is made of: it is created from its inputs, and plan and scans are replaced later.
// Everything is taken in anonymously (pipeline/intake.hpp).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/case.hpp"

namespace sanatrix::pipeline {

/// At least one of labels, image and a scan; a scan alone makes a case of the standing patient.
struct NewCase {
  std::optional<std::filesystem::path> labels;
  std::string label_preset = "sanatrix";
  std::optional<std::filesystem::path> image;  ///< DICOM folder, or an image file
  int series = 0;                              ///< of the DICOM folder; 0: chosen by the program
  std::optional<std::filesystem::path> plan;
  std::optional<std::filesystem::path>
      tumour;  ///< for images; else the plan's (pipeline/tumour.hpp)
  std::map<std::string, std::filesystem::path> scans;  ///< as for replace_scans
  std::vector<std::string> parameters;                 ///< "key=value", kept in the case
};
/// Creates the folder completely or not at all. Error{Input} when it exists and is not empty, or
/// when an input cannot be read.
Case create_case(const std::filesystem::path& folder, const NewCase& given);

/// Takes the plan away, and the surgery.* parameters that changed it.
void drop_plan(Case& patient);
void replace_plan(Case& patient, const std::filesystem::path& plan_file);
/// Attaches surface scans in the place of earlier ones: "scan" (before surgery) and "followup",
/// with material file and photographs; and the landmarks marked on them: "scan_landmarks",
/// "followup_landmarks". A case of a scan alone is then placed anew, its plan with it.
/// Error{Input} when one cannot be used.
void replace_scans(Case& patient, const std::map<std::string, std::filesystem::path>& files);

}  // namespace sanatrix::pipeline
