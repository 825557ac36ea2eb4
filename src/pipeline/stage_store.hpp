// Results of stages on disk: complete or absent, never half. A new result is made in a folder
// aside and takes the old one's place by renaming.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/recipe.hpp"

namespace sanatrix::pipeline {

/// stage.json of a finished stage.
struct StageRecord {
  Recipe recipe;
  double seconds = 0.0;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> numbers;  ///< what a reader of a log wants to know
  std::vector<std::string> files;                       ///< relative to the stage's folder
};
std::optional<StageRecord> read_record(const Case& patient, Stage stage);

enum class State { Fresh, Stale, Failed, Missing };
struct StageStatus {
  Stage stage;
  State state;
  std::string reason;  ///< one line; empty when fresh
  double seconds = 0.0;
  std::vector<std::string> warnings;
};
std::string name_of(State state);  ///< "fresh"
StageStatus status(const Case& patient, Stage stage);

/// The folder aside in which a stage makes its result.
std::filesystem::path aside_folder(const Case& patient, Stage stage);
/// Removes what dead runs left, finishes a half-done replacement, and keeps a folder aside only
/// when it holds a checkpoint of what is to be computed now.
void clean_up(const Case& patient);
/// An empty folder aside, or the kept one.
void begin(const Case& patient, Stage stage);
/// Writes stage.json, flushes everything and replaces the old result.
void commit(const Case& patient, Stage stage, StageRecord record);
/// Remembers that the stage failed; the last good result stays.
void record_failure(const Case& patient, Stage stage, const std::string& reason);

}  // namespace sanatrix::pipeline
