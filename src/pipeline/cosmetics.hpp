// The case's cosmetic indices: landmarks carried by the tissue, then outcome/metrics.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "outcome/metrics.hpp"
#include "pipeline/scans.hpp"

namespace sanatrix::pipeline {

/// The same outcome if the wound shrinks less or more: displacements in proportion to the loss of
/// volume, which mechanics follows to first order. docs/theory/outcome.md, section 4
struct Contraction {
  std::string key;      ///< "little", "strong"
  std::string meaning;  ///< with its source
  double volume_ratio;  ///< V/V0 of the wound
  double factor;        ///< of the case's displacements
  std::vector<outcome::Metric> metrics;
};

struct Cosmetics {
  outcome::Question question;
  outcome::BodyFrame frame;
  std::vector<outcome::Metric> metrics;
  double chance_bra_above_26mm = 0.0;
  std::string ptosis_before, ptosis_after;  ///< of the treated breast
  std::map<std::string, double> ptosis_chances_before, ptosis_chances_after;
  std::vector<Contraction> contractions;  ///< little, strong; empty when the wound does not shrink
};
Cosmetics cosmetics_of(const CaseResult& result, const Skin& skin);

nlohmann::json cosmetics_json(const Cosmetics& cosmetics);
std::string cosmetics_csv(const Cosmetics& cosmetics);

}  // namespace sanatrix::pipeline
