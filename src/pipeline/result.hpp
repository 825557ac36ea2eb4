// Everything a finished case knows, read back for the outcome's numbers and pictures.
#pragma once

#include "pipeline/artefacts.hpp"
#include "pipeline/healing_store.hpp"
#include "pipeline/runner.hpp"

namespace sanatrix::pipeline {

struct CaseResult {
  meshing::BreastModel model;
  surgery::Plan plan;
  surgery::Wound wound;
  SolvedShape unloaded, supine, healed, before, after;
  std::vector<recovery::HistoryRow> history;
  std::vector<healing::Species> species;
  std::vector<Frame> frames;              ///< in time
  std::map<std::string, Vec3> landmarks;  ///< upright before surgery, where known: sternal_notch
  bool standing = false;                  ///< captured standing, by a scan alone

  [[nodiscard]] std::span<const Vec3> points(const SolvedShape& solved) const {
    return vertices(model.mesh, solved.shape);
  }
  [[nodiscard]] int side() const { return plan.side == surgery::Side::Left ? 1 : -1; }
};
CaseResult load_result(const Case& patient);

/// Pictures of the paper's figures into a folder. Returns the reason when none could be made.
/// Throws Cancelled.
std::optional<std::string> write_pictures(const CaseResult& result,
                                          const std::filesystem::path& folder, const Context& ctx);

}  // namespace sanatrix::pipeline
