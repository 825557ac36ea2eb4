// What a stage's result depends on. Two results with equal recipes are equal.
#pragma once

#include <map>
#include <string>

#include "pipeline/case.hpp"

namespace sanatrix::pipeline {

struct Recipe {
  std::map<std::string, std::string> entries;  ///< "parameter mesh.target_vertices" -> "5000"
  [[nodiscard]] std::string fingerprint() const;
};

/// From case.json alone: upstream stages enter by their recipes' fingerprints.
Recipe recipe(const Case& patient, Stage stage);
/// Why a result with the old recipe is out of date, in words; empty when it is not.
std::string difference(const Recipe& old, const Recipe& now);

}  // namespace sanatrix::pipeline
