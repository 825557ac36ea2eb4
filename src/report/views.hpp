// The report's own pictures: five standard views, photographs, distances; and animations.
#pragma once

#include <optional>
#include <vector>

#include "report/findings.hpp"

namespace sanatrix::report {

/// The model's skin in clay with areolae, before and after.
struct ClaySkin {
  TexturedSurface before, after;
};
ClaySkin clay_skin(const Findings& findings);
/// The scan before surgery with its photograph, and with the predicted displacement.
std::optional<ClaySkin> photographed_skin(const Findings& findings);

/// views.png, and with scans views_photo.png and distance.png. Returns why there are none.
std::optional<std::string> draw_views(const Findings& findings, const std::filesystem::path& folder,
                                      const Context& ctx);
/// compare.png: one row per case, all with the same cameras and scales.
std::optional<std::string> draw_comparison(const std::vector<Findings>& cases,
                                           const std::filesystem::path& file, const Context& ctx);
/// displacement.mp4, capillaries.mp4, cells.mp4 (the paper's S1-S3 Videos) through ffmpeg.
std::optional<std::string> draw_animations(const Findings& findings,
                                           const std::filesystem::path& folder, const Context& ctx);

}  // namespace sanatrix::report
