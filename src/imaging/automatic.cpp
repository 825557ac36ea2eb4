#include "imaging/automatic.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "imaging/body_mask.hpp"
#include "imaging/fat_field.hpp"
#include "imaging/grids.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double working_mm = 1.2;  ///< in-plane voxel size for field and chest wall
constexpr double wide_knots_mm = 70.0, fine_knots_mm = 45.0;
constexpr double skin_mm = 2.0;  ///< thickness; Huang et al., doi:10.1118/1.2841938: 1-2.5 mm
/// Half way between air and skin, relative to fat: skin has about a third of fat's signal.
constexpr float skin_edge = 0.17F;
constexpr double local_mm = 7.0;  ///< over which the rest of the shading is followed
constexpr double surroundings_mm = 1.2;
constexpr double muscle_mm = 12.0;    ///< behind the fascia; pectorals and ribs
constexpr float lung_signal = 0.10F;  ///< relative to fat

Image3<float> in_plane_smoothed(const Image3<float>& image, double sigma_mm) {
  Image3<float> result = image;
  const double slices = result.spacing_mm[2];
  result.spacing_mm[2] = 1e3;  // slices stay apart
  smooth(result, sigma_mm);
  result.spacing_mm[2] = slices;
  return result;
}

Image3<float> divided(const Image3<float>& image, const Image3<float>& by) {
  Image3<float> result = image;
  for (std::size_t v = 0; v < result.voxels.size(); ++v) {
    result.voxels[v] = std::min(result.voxels[v] / std::max(by.voxels[v], 1e-6F), 4.0F);
  }
  return result;
}

/// Where air ends, per voxel: half the local skin's signal, but clear of the noise.
Image3<float> edge_of_skin(const Image3<float>& fat_signal, const AirSignal& air) {
  Image3<float> edge = fat_signal;
  const auto noise = static_cast<float>(air.mean + 4.0 * air.deviation);
  for (float& v : edge.voxels) {
    v = std::max(noise, skin_edge * v + 0.5F * static_cast<float>(air.mean));
  }
  return edge;
}

/// Skin between the breasts: where the front of the body lies deepest between two rises.
struct Cleft {
  double i_mm, j_mm;
};
Cleft find_cleft(const Mask& body) {
  const auto [nx, ny, nz] = body.size;
  // The front of the body per column, as the median over slices around the middle.
  std::vector<double> front(static_cast<std::size_t>(nx));
  std::vector<int> window;
  for (int i = 0; i < nx; ++i) {
    window.clear();
    for (int k = nz / 5; k < nz - nz / 5; ++k) {
      int j = 0;
      while (j < ny && body.at(i, j, k) == 0) {
        ++j;
      }
      window.push_back(j);
    }
    const auto middle = window.begin() + static_cast<long>(window.size() / 2);
    std::nth_element(window.begin(), middle, window.end());
    front[static_cast<std::size_t>(i)] = *middle * body.spacing_mm[1];
  }
  // The point that is deepest below the lower of the highest rises on its two sides.
  double best = -1.0;
  Cleft cleft{};
  std::vector<double> left(front), right(front);
  for (std::size_t i = 1; i < front.size(); ++i) {
    left[i] = std::min(left[i], left[i - 1]);
    right[front.size() - 1 - i] = std::min(right[front.size() - 1 - i], right[front.size() - i]);
  }
  std::size_t from = 0, to = 0;
  for (std::size_t i = 0; i < front.size(); ++i) {
    const double depth = front[i] - std::max(left[i], right[i]);
    if (depth > best + 1e-9) {
      best = depth;
      from = i;
    }
    if (depth > best - 1.0) {
      to = i;
    }
  }
  cleft.i_mm = 0.5 * static_cast<double>(from + std::max(from, to)) * body.spacing_mm[0];
  cleft.j_mm = front[from];
  if (best < 12.0) {
    throw Error(Fault::Input,
                fmt::format("not usable because no two breasts with a cleft between them were "
                            "found: the front of the body dips by only {:.0f} mm",
                            std::max(best, 0.0)),
                "use a prone MRI that shows both breasts hanging towards anterior, and the "
                "sternum; or give labels with --labels");
  }
  return cleft;
}

/// Voxels of the body that may be fat or gland: in front of the wall, below the skin.
Mask soft_interior(const Mask& body, const ChestWall& wall, double below_skin_mm,
                   double before_wall_mm) {
  Mask soft = body;
  const Image3<float> outside = signed_distance(body, {true, true, true}, 8.0);
  std::size_t v = 0;
  for (int k = 0; k < body.size[2]; ++k) {
    for (int j = 0; j < body.size[1]; ++j) {
      for (int i = 0; i < body.size[0]; ++i, ++v) {
        if (soft.voxels[v] != 0 &&
            (outside.voxels[v] > -below_skin_mm ||
             wall.behind_mm(i * body.spacing_mm[0], j * body.spacing_mm[1], k) > -before_wall_mm)) {
          soft.voxels[v] = 0;
        }
      }
    }
  }
  return soft;
}

/// A grid's first voxel, seen from another grid with the same axes [mm].
Vec3 offset_mm(const Image3<float>& grid, const Image3<float>& from) {
  return transpose(from.direction) * (grid.origin_mm - from.origin_mm);
}

/// The layer below the skin: fat nearly everywhere, and clear of heart and liver.
Mask below_skin(const Mask& body, double from_mm, double to_mm) {
  const Image3<float> outside = signed_distance(body, {true, true, true}, to_mm + 1.0);
  Mask layer = body;
  for (std::size_t v = 0; v < layer.voxels.size(); ++v) {
    const double depth = -static_cast<double>(outside.voxels[v]);
    layer.voxels[v] = depth > from_mm && depth < to_mm ? 1 : 0;
  }
  return layer;
}

/// What is left of the shading in the small: the mean signal of surely fat voxels nearby, about 1.
/// Where there is little fat, the wide field is left as it is.
Image3<float> local_fat(const Image3<float>& relative, const Mask& soft,
                        const GlandularModel& model) {
  Image3<float> weight = image_like<float>(relative), sum = weight;
  for (std::size_t v = 0; v < soft.voxels.size(); ++v) {
    if (soft.voxels[v] != 0) {
      const double off =
          (static_cast<double>(relative.voxels[v]) - model.fat_signal) / (1.5 * model.fat_spread);
      weight.voxels[v] = static_cast<float>(std::exp(-0.5 * off * off));
      sum.voxels[v] = weight.voxels[v] * relative.voxels[v];
    }
  }
  smooth(weight, local_mm);
  smooth(sum, local_mm);
  constexpr float prior = 0.05F;
  const auto usual = static_cast<float>(model.fat_signal);
  for (std::size_t v = 0; v < sum.voxels.size(); ++v) {
    sum.voxels[v] = (sum.voxels[v] + prior * usual) / (weight.voxels[v] + prior);
  }
  return sum;
}

struct Coarse {
  FatField field;
  ChestWall wall;
  Image3<float> local;  ///< signal of fat relative to the field, on the working grid
  AirSignal air;
  GlandularModel gland;
};

Coarse find_on_working_grid(const Image3<float>& image, const Context& ctx) {
  const Image3<float> small = in_plane_smoothed(shrink_in_plane(image, working_mm), 0.6);
  const AirSignal air = measure_air(small);
  Image3<float> threshold;
  threshold.voxels = {static_cast<float>(air.mean + 6.0 * air.deviation)};
  const Mask rough = body_mask(small, threshold);
  ctx.at(0.1, "coil shading");
  FatField field = estimate_fat_field(small, below_skin(rough, 3.0, 25.0), wide_knots_mm);
  Image3<float> signal = fat_signal_on(field, small);
  const Mask body = body_mask(small, edge_of_skin(signal, air));
  const Cleft cleft = find_cleft(body);
  ctx.at(0.35, "chest wall");
  ChestWall wall = find_chest_wall(divided(small, signal), body, cleft.i_mm, cleft.j_mm);
  // Once more with the shading of what lies in front of the wall alone.
  ctx.at(0.55, "coil shading of the breasts");
  field = estimate_fat_field(small, soft_interior(body, wall, 3.0, 2.0), fine_knots_mm);
  signal = fat_signal_on(field, small);
  Image3<float> relative = divided(small, signal);
  ctx.at(0.75, "chest wall");
  wall = find_chest_wall(relative, body, cleft.i_mm, cleft.j_mm);
  const Mask soft = soft_interior(body, wall, 4.0, 3.0);
  Image3<float> local = local_fat(relative, soft, fit_glandular_model(relative, soft));
  const GlandularModel gland = fit_glandular_model(divided(relative, local), soft);
  return {std::move(field), std::move(wall), std::move(local), air, gland};
}

Label behind_wall(double depth_mm, float relative) {
  if (depth_mm > 6.0 && relative < lung_signal) {
    return Label::Lung;
  }
  return depth_mm < muscle_mm ? Label::Muscle : Label::Organ;
}

/// Fibroglandular or adipose: by the share of the voxel and of what is around it, since gland comes
/// in strands and lobes and noise in single voxels.
void harden(const GlandularModel& model, TissueGrid& grid) {
  Image3<float> around = grid.fibroglandular;
  smooth(around, surroundings_mm);
  for (std::size_t v = 0; v < around.voxels.size(); ++v) {
    unsigned char& label = grid.labels.voxels[v];
    const double share =
        0.5 * static_cast<double>(grid.fibroglandular.voxels[v] + around.voxels[v]);
    if (label == static_cast<unsigned char>(Label::Adipose) && share > model.hard_share) {
      label = static_cast<unsigned char>(Label::Fibroglandular);
    }
  }
}

}  // namespace

AutomaticLabels label_image(const Image3<float>& image, const Context& ctx) {
  const Image3<float> ordered = in_lps_order(image);
  Coarse coarse = find_on_working_grid(ordered, ctx.part(0.0, 0.7));
  ctx.at(0.7, "fibroglandular tissue");
  const Vec3 first = offset_mm(ordered, coarse.local);
  const Image3<float> signal = fat_signal_on(coarse.field, ordered, first);
  const Image3<float> smoothed = in_plane_smoothed(ordered, 0.5);
  const Mask body = body_mask(smoothed, edge_of_skin(signal, coarse.air));
  const Image3<float> outside = signed_distance(body, {true, true, true}, 6.0);
  AutomaticLabels found;
  found.relative = divided(smoothed, signal);
  found.grid.labels = image_like<unsigned char>(ordered);
  found.grid.fibroglandular = image_like<float>(ordered);
  std::size_t v = 0;
  for (int k = 0; k < ordered.size[2]; ++k) {
    for (int j = 0; j < ordered.size[1]; ++j) {
      for (int i = 0; i < ordered.size[0]; ++i, ++v) {
        if (body.voxels[v] == 0) {
          continue;
        }
        const double behind = coarse.wall.behind_mm(first[0] + i * ordered.spacing_mm[0],
                                                    first[1] + j * ordered.spacing_mm[1], k);
        const float relative = found.relative.voxels[v];
        Label label = Label::Adipose;
        if (behind > 0.0) {
          label = behind_wall(behind, relative);
        } else if (outside.voxels[v] > -skin_mm) {
          label = Label::Skin;
        } else {
          const Neighbourhood n = neighbourhood(
              coarse.local, {(first[0] + i * ordered.spacing_mm[0]) / coarse.local.spacing_mm[0],
                             (first[1] + j * ordered.spacing_mm[1]) / coarse.local.spacing_mm[1],
                             static_cast<double>(k)});
          const float share =
              glandular_share(coarse.gland, relative / coarse.local.voxels[n.voxel[0]]);
          found.grid.fibroglandular.voxels[v] = share;
        }
        found.grid.labels.voxels[v] = static_cast<unsigned char>(label);
      }
    }
  }
  harden(coarse.gland, found.grid);
  found.wall = std::move(coarse.wall);
  found.gland = coarse.gland;
  found.noise = coarse.air.deviation;
  return found;
}

}  // namespace sanatrix::imaging
