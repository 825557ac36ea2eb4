// What healing keeps on disk: checkpoints while it runs, frames and the healed tissue for later.
#pragma once

#include <filesystem>

#include "recovery/recovery.hpp"

namespace sanatrix::pipeline {

void save_checkpoint(const recovery::Checkpoint& checkpoint, const std::filesystem::path& file);
recovery::Checkpoint load_checkpoint(const std::filesystem::path& file);

/// One moment of healing.
struct Frame {
  double t_day = 0.0;
  std::vector<double> species;  ///< vertices x species
  std::vector<Vec3> points;     ///< vertex positions [m]
};
void save_frame(const Frame& frame, const std::filesystem::path& file);
Frame load_frame(const std::filesystem::path& file);
/// "day_006.000"; sorts by time.
std::string frame_name(double t_day);

// History as rows of numbers, and its file; `species`: how many the model has.
std::vector<double> flatten(const std::vector<recovery::HistoryRow>& history);
std::vector<recovery::HistoryRow> history_from(std::span<const double> numbers,
                                               std::size_t species);
void save_history(const std::vector<recovery::HistoryRow>& history,
                  const std::filesystem::path& file);
std::vector<recovery::HistoryRow> load_history(const std::filesystem::path& file);

// Tissue as rows of numbers, and their file.
inline constexpr int numbers_per_tissue = 8;
std::vector<double> flatten(const std::vector<mechanics::Tissue>& tissue);
std::vector<mechanics::Tissue> tissue_from(std::span<const double> numbers);
void save_tissue(std::vector<double> numbers, const std::filesystem::path& file);
std::vector<double> load_tissue(const std::filesystem::path& file);

}  // namespace sanatrix::pipeline
