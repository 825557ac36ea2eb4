// Cosmetic indices before and after surgery, with what is usual and what is noise.
// Formulas and sources: docs/theory/outcome.md, section 3
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "outcome/torso.hpp"

namespace sanatrix::outcome {

/// Values of one pose by key ("bra_mm"); `treated` 0 right, 1 left.
std::map<std::string, double> shape_indices(const Torso& torso, const BodyFrame& frame,
                                            std::size_t treated);

/// Those of them that follow from landmarks and outlines alone, which is quick.
std::map<std::string, double> landmark_indices(const Torso& torso, const BodyFrame& frame,
                                               std::size_t treated);

struct Range {
  double sd = 0.0, p05 = 0.0, p95 = 0.0;
};
struct Metric {
  std::string key, name, unit, group;
  std::optional<double> before, after, change;
  std::optional<Range> before_range, after_range;  ///< from landmarks placed 2.5 mm (sd) off
  double noise_floor = 0.0;                        ///< changes below it must not be read as real
  std::string noise_source;
  bool is_noise = false;  ///< |change| (or the value, for changes) is below the floor
  std::string reference;  ///< what is usual, in words; empty: nothing known
  std::string source;     ///< of the definition and the reference
};

struct Question {
  Torso before, after;      ///< the same vertices
  std::size_t treated = 1;  ///< 0 right, 1 left
  double excised_percent = 0.0;
  bool notch_known = true;  ///< else the reference point of lengths from the notch is a stand-in
  bool folds_known = true;
};
/// In the order in which patients care: size and shape, then the nipple, then detail.
std::vector<Metric> cosmetic_metrics(const Question& question, const BodyFrame& frame);

/// Share of landmark draws in which BRA after surgery exceeds a length.
double chance_of_bra_above(const Question& question, const BodyFrame& frame, double mm);

/// Share of landmark draws with each grade of ptosis of the treated breast.
std::map<std::string, double> chances_of_ptosis(const Torso& torso, const BodyFrame& frame,
                                                std::size_t treated);

/// Regnault's grade (Plast Reconstr Surg 1976;58:1) from heights above the fold and above the
/// lowest point: "none", "I", "II", "III", "pseudoptosis".
std::string ptosis_grade(double nipple_above_fold_mm, double nipple_above_lowest_mm);

}  // namespace sanatrix::outcome
