// The patient's surface scans beside her model: where they lie, how they bend onto each other, and
// how far prediction and follow-up are apart.
#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "geometry/textured_surface.hpp"
#include "outcome/alignment.hpp"
#include "outcome/scan_comparison.hpp"
#include "outcome/warp.hpp"
#include "pipeline/result.hpp"

namespace sanatrix::pipeline {

/// A scan in the patient's frame.
struct PlacedScan {
  TexturedSurface surface;  ///< [m], LPS, standing
  outcome::Alignment pose;
  std::string unit;
  std::vector<std::string> notes;
};

/// The model's skin with what its vertices belong to.
struct Skin {
  Surface before;                   ///< upright before surgery; `vertex` maps to the mesh
  TriMesh after;                    ///< the same vertices after healing
  std::vector<signed char> breast;  ///< per vertex: -1 right breast, +1 left, 0 neither
  [[nodiscard]] std::vector<Vec3> displacement() const;
};
Skin skin_of(const CaseResult& result);

struct PreopScan {
  PlacedScan placed;
  outcome::Warp warp;               ///< of the upright skin before surgery
  std::vector<Vec3> displacement;   ///< predicted, per point of the scan
  std::vector<signed char> breast;  ///< per point of the scan
};

struct Table1 {
  outcome::SurfaceDistance whole, breasts, operated;
};
struct FollowupScan {
  PlacedScan placed;             ///< by skin that surgery does not move
  Rigid best_fit;                ///< from there to the least distance to the prediction
  Table1 fitted;                 ///< after the best fit, as in the paper
  Table1 anchored;               ///< without it: the chest stays where it is
  std::vector<double> distance;  ///< after the best fit, per skin vertex, signed [m]
};
/// What has changed between the two scans themselves.
struct ObservedChange {
  std::vector<double> inward;  ///< per point of the scan before surgery [m]
  outcome::Retraction operated, other;
  /// At the deepest place of the operated breast, straight towards the back instead of along the
  /// skin's normal [m]; NaN where the skin faces sideways.
  double operated_straight_back_m = 0.0;
};

struct Scans {
  std::optional<PreopScan> preop;
  std::optional<FollowupScan> followup;
  std::optional<Table1> model_error;  ///< of the upright model before surgery against its scan
  std::optional<ObservedChange> observed;
};

/// Reads, places and compares the case's scans. What does not depend on the plan is taken from
/// `kept` (a file of an earlier run) when it is still right, and written to `keep`.
Scans load_scans(const Case& patient, const CaseResult& result, const Skin& skin,
                 const std::filesystem::path& kept, const std::filesystem::path& keep,
                 const Context& ctx);
nlohmann::json scans_json(const Scans& scans);
/// "region,mean_mm,..." as in the paper's Table 1.
std::string table1_csv(const FollowupScan& followup);

}  // namespace sanatrix::pipeline
