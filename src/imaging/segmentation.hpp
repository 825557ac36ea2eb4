// Step B for given labels: reads a label volume in one of the known tables, checks that it can be a
// prone breast MRI, and resamples it to an isotropic grid that is aligned with LPS.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "imaging/quality.hpp"

namespace sanatrix::imaging {

enum class LabelPreset {
  Sanatrix,  ///< the table of sanatrix::Label
  Pelicano,  ///< Pelicano et al.'s `*_detailed` maps: tissue levels 0..11, see imaging/presets.cpp
};
/// "sanatrix" or "pelicano"; Error{Usage} otherwise.
LabelPreset parse_label_preset(const std::string& name);

struct Segmentation {
  LabelImage labels;                ///< isotropic, direction = identity (LPS)
  Image3<float> fibroglandular;     ///< volume fraction per voxel of the same grid, 0..1
  double midline_x_mm = 0.0;        ///< LPS x of the mid-sagittal plane
  std::array<Vec3, 2> nipple_mm{};  ///< [0] right, [1] left: nipple label, else most anterior skin
  bool nipples_from_label = false;
  std::vector<std::string> warnings;
};

/// Reads NIfTI, NRRD or MetaImage labels. Throws Error{Input} naming file and cause: unreadable,
/// not 3-D, not integer, labels outside the table, spacing outside 0.2..6 mm, no chest wall, no
/// breast, anterior/posterior or superior/inferior flipped, left or right breast missing.
Segmentation segment_given_labels(const std::filesystem::path& file, LabelPreset preset,
                                  double spacing_mm, const Context& ctx);

/// A tumour as a sphere, in the frame of the image.
struct TumourSphere {
  Vec3 centre_mm{};
  double radius_mm = 0.0;
};

/// The same from a greyscale image: prone, both breasts, T1 or T2 without fat suppression.
/// Error{Input} "not usable because ..." when the result is not plausible, or the tumour does not
/// lie in a breast.
struct ImageSegmentation {
  Segmentation segmentation;
  Quality quality;
};
ImageSegmentation segment_image(const Image3<float>& image, double spacing_mm,
                                const std::optional<TumourSphere>& tumour, const Context& ctx);

}  // namespace sanatrix::imaging
