// The built-in patient on disk: what a hospital would send, and beside it the truth.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "phantom/phantom.hpp"
#include "pipeline/case.hpp"

namespace sanatrix::pipeline {

/// Before the work, so that a folder that cannot be made costs no time. Error{Resource}.
void make_phantom_folder(const std::filesystem::path& folder);
/// labels.nii.gz, plan.json and truth/. Returns the text of truth/truth.json.
std::string write_phantom(const phantom::Phantom& phantom, const phantom::Options& options,
                          const std::filesystem::path& folder);

/// Distances of the case's surfaces from the phantom's truth, over the breasts' skin [mm].
struct PoseScore {
  std::string pose;  ///< "unloaded"
  double mean_mm, p50_mm, p90_mm, p95_mm, max_mm;
};
/// How well surgery and healing move the skin of the treated breast, standing: displacement from
/// before to after, true and predicted, and the length of their difference [mm].
struct ChangeScore {
  double true_mean_mm, true_max_mm, predicted_mean_mm, predicted_max_mm;
  double error_mean_mm, error_p95_mm, error_max_mm;
};
struct Score {
  std::vector<PoseScore> poses;  ///< the last one "upright after surgery" when it can be compared
  std::optional<ChangeScore> change;
  std::string note;  ///< why there is no comparison after surgery; else empty
};
/// Error{Input} when the case or the truth cannot be read.
Score score(const Case& patient, const std::filesystem::path& phantom_folder);

}  // namespace sanatrix::pipeline
