// What there is to see of a case: the model and every pose that was computed, as material points
// that can be carried from one pose to another.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "meshing/breast_mesh.hpp"
#include "pipeline/case.hpp"
#include "surgery/anatomy.hpp"

namespace sanatrix::pipeline {

class CaseView {
 public:
  /// Reads what is there, fresh or stale. Error{Input} when the case has not been meshed.
  explicit CaseView(const Case& patient);

  [[nodiscard]] const meshing::BreastModel& model() const { return model_; }
  /// "prone", "unloaded", "supine", "healed", "before", "after": vertex positions [m].
  [[nodiscard]] const std::map<std::string, std::vector<Vec3>>& poses() const { return poses_; }
  [[nodiscard]] bool has(const std::string& pose) const { return poses_.contains(pose); }
  /// Error{Input} when this pose has not been computed.
  [[nodiscard]] const std::vector<Vec3>& pose(const std::string& name) const;
  /// Where points of one pose lie in another, moving with the tissue; points outside the model
  /// follow the nearest cell.
  [[nodiscard]] std::vector<Vec3> carry(std::span<const Vec3> points, const std::string& from,
                                        const std::string& to) const;
  /// The same for every pose there is; each point is searched once.
  [[nodiscard]] std::map<std::string, std::vector<Vec3>> carry_to_all(
      std::span<const Vec3> points, const std::string& from) const;
  /// Ready for plans and for carrying points; made when first needed, kept as long as the view.
  [[nodiscard]] std::shared_ptr<const surgery::Anatomy> anatomy(const std::string& pose) const;
  /// Of both breasts as imaged: [0] right, [1] left [cm3].
  [[nodiscard]] const std::array<double, 2>& breast_cm3() const { return breast_cm3_; }

 private:
  meshing::BreastModel model_;
  std::map<std::string, std::vector<Vec3>> poses_;
  std::array<double, 2> breast_cm3_{};
  mutable std::mutex mutex_;  // of the anatomies
  mutable std::map<std::string, std::shared_ptr<const surgery::Anatomy>> anatomies_;
};

std::string pose_of(surgery::Frame frame);  ///< "supine"

/// The same plan with its coordinates in another frame: tumour, axis, outline and incisions move
/// with the tissue.
surgery::Plan in_frame(const surgery::Plan& plan, surgery::Frame frame, const CaseView& view);

}  // namespace sanatrix::pipeline
