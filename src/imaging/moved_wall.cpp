#include "imaging/moved_wall.hpp"

#include <cmath>

#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {
namespace {

bool is_wall(unsigned char label) {
  return label >= static_cast<unsigned char>(Label::Muscle) &&
         label <= static_cast<unsigned char>(Label::Organ);
}

bool is_tissue(unsigned char label) {
  return label != static_cast<unsigned char>(Label::Air) && !is_wall(label);
}

}  // namespace

void move_wall(Segmentation& segmentation, double deeper_mm) {
  LabelImage& labels = segmentation.labels;
  const bool deeper = deeper_mm > 0;
  const double reach_mm = std::abs(deeper_mm);
  Mask grows = image_like<unsigned char>(labels);
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    const unsigned char label = labels.voxels[v];
    grows.voxels[v] = (deeper ? is_tissue(label) : is_wall(label)) ? 1 : 0;
  }
  const Image3<float> outside = signed_distance(grows, {true, true, true}, reach_mm + 2.0);
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    unsigned char& label = labels.voxels[v];
    const bool gives_way =
        deeper ? is_wall(label)
               : is_tissue(label) && label != static_cast<unsigned char>(Label::Tumour);
    if (gives_way && outside.voxels[v] < reach_mm) {
      label = static_cast<unsigned char>(deeper ? Label::Adipose : Label::Muscle);
      segmentation.fibroglandular.voxels[v] = 0.0F;
    }
  }
}

}  // namespace sanatrix::imaging
