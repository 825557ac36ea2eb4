// Resampling of labels: distances for the outer shapes, votes for the tissues inside.
#include "imaging/resample.hpp"

#include <array>

#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {
namespace {

constexpr std::size_t label_count = 11;

std::size_t label_of(const LabelTable& table, unsigned char number) {
  return static_cast<std::size_t>(table.tissue[number].label);
}

/// Merges blocks of voxels that are finer than the wanted grid: majority label, mean fraction.
TissueGrid merge_fine_voxels(const LabelImage& source, const LabelTable& table, double spacing_mm) {
  std::array<int, 3> block{};
  TissueGrid merged;
  LabelImage& labels = merged.labels;
  labels.direction = source.direction;
  for (std::size_t a = 0; a < 3; ++a) {
    block[a] = std::clamp(static_cast<int>(spacing_mm / source.spacing_mm[a]), 1, source.size[a]);
    labels.size[a] = source.size[a] / block[a];
    labels.spacing_mm[a] = source.spacing_mm[a] * block[a];
  }
  labels.origin_mm =
      source.position_mm(0.5 * (block[0] - 1), 0.5 * (block[1] - 1), 0.5 * (block[2] - 1));
  labels.voxels.resize(static_cast<std::size_t>(labels.size[0]) *
                       static_cast<std::size_t>(labels.size[1]) *
                       static_cast<std::size_t>(labels.size[2]));
  merged.fibroglandular = image_like<float>(labels);
  const double per_voxel = 1.0 / (block[0] * block[1] * block[2]);
  std::size_t out = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++out) {
        std::array<int, label_count> votes{};
        double fraction = 0.0;
        for (int c = 0; c < block[2]; ++c) {
          for (int b = 0; b < block[1]; ++b) {
            for (int a = 0; a < block[0]; ++a) {
              const unsigned char number =
                  source.at(i * block[0] + a, j * block[1] + b, k * block[2] + c);
              ++votes[label_of(table, number)];
              fraction += table.tissue[number].fibroglandular;
            }
          }
        }
        labels.voxels[out] = static_cast<unsigned char>(
            std::max_element(votes.begin(), votes.end()) - votes.begin());
        merged.fibroglandular.voxels[out] = static_cast<float>(fraction * per_voxel);
      }
    }
  }
  return merged;
}

/// The grid of voxels aligned with LPS that covers the source.
LabelImage lps_grid(const LabelImage& source, double spacing_mm) {
  Vec3 low = source.origin_mm;
  Vec3 high = source.origin_mm;
  for (unsigned corner = 1; corner < 8; ++corner) {
    const Vec3 p = source.position_mm((corner & 1U) != 0 ? source.size[0] - 1 : 0,
                                      (corner & 2U) != 0 ? source.size[1] - 1 : 0,
                                      (corner & 4U) != 0 ? source.size[2] - 1 : 0);
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], p[a]);
      high[a] = std::max(high[a], p[a]);
    }
  }
  LabelImage grid;
  grid.spacing_mm = {spacing_mm, spacing_mm, spacing_mm};
  std::size_t voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const double steps = std::floor((high[a] - low[a]) / spacing_mm);
    grid.size[a] = static_cast<int>(steps) + 1;
    grid.origin_mm[a] = 0.5 * (low[a] + high[a] - steps * spacing_mm);
    voxels *= static_cast<std::size_t>(grid.size[a]);
  }
  grid.voxels.assign(voxels, 0);
  return grid;
}

Mask mask_of(const LabelImage& labels, bool (*belongs)(unsigned char)) {
  Mask mask = image_like<unsigned char>(labels);
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) {
    mask.voxels[i] = belongs(labels.voxels[i]) ? 1 : 0;
  }
  return mask;
}

/// Thick slices are interpolated by in-plane distances only.
std::array<bool, 3> thin_axes(const LabelImage& labels) {
  const Vec3& h = labels.spacing_mm;
  const double finest = std::min({h[0], h[1], h[2]});
  return {h[0] < 1.5 * finest, h[1] < 1.5 * finest, h[2] < 1.5 * finest};
}

/// The label among those that `belongs` with the greatest weight, or `otherwise`.
unsigned char vote(const LabelImage& labels, const Neighbourhood& n, bool (*belongs)(unsigned char),
                   Label otherwise) {
  std::array<double, label_count> votes{};
  for (std::size_t c = 0; c < 8; ++c) {
    const unsigned char label = labels.voxels[n.voxel[c]];
    if (belongs(label)) {
      votes[label] += n.weight[c];
    }
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  return *most > 0.0 ? static_cast<unsigned char>(most - votes.begin())
                     : static_cast<unsigned char>(otherwise);
}

float soft_fraction(const TissueGrid& source, const Neighbourhood& n) {
  double sum = 0.0;
  double weight = 0.0;
  for (std::size_t c = 0; c < 8; ++c) {
    if (is_soft(source.labels.voxels[n.voxel[c]])) {
      sum += n.weight[c] * source.fibroglandular.voxels[n.voxel[c]];
      weight += n.weight[c];
    }
  }
  return weight > 0.0 ? static_cast<float>(sum / weight) : 0.0F;
}

}  // namespace

TissueGrid resample_to_lps(const LabelImage& image, const LabelTable& table, double spacing_mm,
                           const Context& ctx) {
  return resample_to_lps(merge_fine_voxels(image, table, spacing_mm), table.skin_limit_mm,
                         spacing_mm, ctx);
}

TissueGrid resample_to_lps(const TissueGrid& source, double skin_limit_mm, double spacing_mm,
                           const Context& ctx) {
  ctx.at(0.2, "distances to skin and chest wall");
  // Wide enough for a skin that recedes 10 mm from one thick slice to the next.
  constexpr double limit_mm = 10.0;
  const auto axes = thin_axes(source.labels);
  const Image3<float> outside = signed_distance(
      mask_of(source.labels, [](unsigned char l) { return l != 0; }), axes, limit_mm);
  ctx.at(0.4);
  const Image3<float> off_wall = signed_distance(mask_of(source.labels, is_wall), axes, limit_mm);

  ctx.at(0.6, "resampling to LPS");
  TissueGrid result{.labels = lps_grid(source.labels, spacing_mm), .fibroglandular = {}};
  result.fibroglandular = image_like<float>(result.labels);
  std::size_t out = 0;
  for (int k = 0; k < result.labels.size[2]; ++k) {
    for (int j = 0; j < result.labels.size[1]; ++j) {
      for (int i = 0; i < result.labels.size[0]; ++i, ++out) {
        const Vec3 at = source.labels.continuous_index(result.labels.position_mm(i, j, k));
        // Beyond an oblique border the border goes on: cut tissue must not look like skin.
        const Neighbourhood n = neighbourhood(source.labels, at);
        double skin = 0.0;
        double wall = 0.0;
        for (std::size_t c = 0; c < 8; ++c) {
          skin += n.weight[c] * static_cast<double>(outside.voxels[n.voxel[c]]);
          wall += n.weight[c] * static_cast<double>(off_wall.voxels[n.voxel[c]]);
        }
        if (skin >= 0.0) {
          continue;
        }
        unsigned char& label = result.labels.voxels[out];
        if (wall < 0.0) {
          label = vote(source.labels, n, is_wall, Label::Muscle);
          continue;
        }
        label = vote(source.labels, n, is_soft, Label::Adipose);
        if (label == static_cast<unsigned char>(Label::Skin) && skin_limit_mm > 0.0 &&
            skin < -skin_limit_mm) {
          label = static_cast<unsigned char>(Label::Adipose);
        }
        result.fibroglandular.voxels[out] = soft_fraction(source, n);
      }
    }
  }
  return result;
}

}  // namespace sanatrix::imaging
