// The built-in patient on disk: what a hospital would send, and beside it the truth.
#pragma once

#include <filesystem>
#include <string>

#include "phantom/phantom.hpp"
#include "pipeline/case.hpp"

namespace sanatrix::pipeline {

/// labels.nii.gz, plan.json and truth/. Returns the text of truth/truth.json.
std::string write_phantom(const phantom::Phantom& phantom, const phantom::Options& options,
                          const std::filesystem::path& folder);

/// Distances of the case's surfaces from the phantom's truth, over the breasts' skin [mm].
struct PoseScore {
  std::string pose;  ///< "unloaded"
  double mean_mm, p50_mm, p90_mm, p95_mm, max_mm;
};
std::vector<PoseScore> score(const Case& patient, const std::filesystem::path& phantom_folder);

}  // namespace sanatrix::pipeline
