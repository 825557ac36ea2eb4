// The case's cosmetic indices: landmarks carried by the tissue, then outcome/metrics.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "outcome/metrics.hpp"
#include "pipeline/scans.hpp"

namespace sanatrix::pipeline {

struct Cosmetics {
  outcome::Question question;
  outcome::BodyFrame frame;
  std::vector<outcome::Metric> metrics;
  double chance_bra_above_26mm = 0.0;
  std::string ptosis_before, ptosis_after;  ///< of the treated breast
};
Cosmetics cosmetics_of(const CaseResult& result, const Skin& skin);

nlohmann::json cosmetics_json(const Cosmetics& cosmetics);
std::string cosmetics_csv(const Cosmetics& cosmetics);

}  // namespace sanatrix::pipeline
