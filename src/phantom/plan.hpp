// The phantom's plan.json: what a radiologist and a surgeon would measure in the prone labels.
#pragma once

#include <string>

#include "phantom/tissue.hpp"

namespace sanatrix::phantom {

/// Keys as in shared plans; positions are measured in the labels, LPS mm, prone.
std::string plan_json(const LabelImage& labels, const Anatomy& anatomy, const std::string& name);

}  // namespace sanatrix::phantom
