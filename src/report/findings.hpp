// What a report needs to know of a finished case.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/cosmetics.hpp"
#include "surgery/place.hpp"

namespace sanatrix::report {

struct Findings {
  pipeline::Case patient;
  pipeline::CaseResult result;
  pipeline::Skin skin;
  pipeline::Scans scans;
  nlohmann::json outcome;  ///< outcome.json
  std::string folder;      ///< name of the case folder, for headings
};
/// Error{Input} when the case's outcome is not up to date.
Findings find(const pipeline::Case& patient, const Context& ctx);

/// The resection as a surgeon says it.
struct PlanInWords {
  std::string side;  ///< "LEFT"
  surgery::Place place;
  double margin_mm = 0, radius_mm = 0, excised_cm3 = 0, excised_g = 0, excised_percent = 0;
  double skin_mm = 0, chest_mm = 0;
};
PlanInWords in_words(const Findings& findings);

}  // namespace sanatrix::report
