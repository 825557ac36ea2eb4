// Anatomies for synthetic MRI: what a label map of real breasts does not hold (muscle, ribs, lungs,
// the back of the body), and bodies that differ from it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"
#include "imaging/grids.hpp"
#include "imaging/segmentation.hpp"
#include "io/image_file.hpp"

namespace sanatrix::testing {

/// Tissues and the share of gland of every voxel of about 1 mm, in LPS order.
struct Anatomy {
  LabelImage labels;
  Image3<float> water;
};

inline unsigned char code(Label label) {
  return static_cast<unsigned char>(label);
}

/// A random field with the given length of correlation, mean 0 and deviation 1.
inline Image3<float> smooth_random(const LabelImage& grid, double length_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  // On a grid of half the length, and linear between.
  Image3<float> coarse = image_like<float>(grid);
  coarse.voxels.clear();
  for (std::size_t a = 0; a < 3; ++a) {
    coarse.spacing_mm[a] = 0.5 * length_mm;
    coarse.size[a] = static_cast<int>(grid.size[a] * grid.spacing_mm[a] / coarse.spacing_mm[a]) + 2;
  }
  for (int v = 0; v < coarse.size[0] * coarse.size[1] * coarse.size[2]; ++v) {
    coarse.voxels.push_back(normal(random));
  }
  smooth(coarse, 0.5 * length_mm);
  double squares = 0.0;
  for (const float v : coarse.voxels) {
    squares += static_cast<double>(v) * static_cast<double>(v);
  }
  const double scale = 1.0 / std::sqrt(squares / static_cast<double>(coarse.voxels.size()));
  Image3<float> field = image_like<float>(grid);
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        field.voxels[v] = static_cast<float>(scale * sample(coarse, grid.position_mm(i, j, k)));
      }
    }
  }
  return field;
}

/// The flat cut at the back goes on by `more_mm`.
template <class T>
Image3<T> with_back(const Image3<T>& image, double more_mm) {
  Image3<T> longer = image;
  const int rows = static_cast<int>(more_mm / image.spacing_mm[1]);
  longer.size[1] += rows;
  longer.voxels.clear();
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < longer.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        longer.voxels.push_back(image.at(i, std::min(j, image.size[1] - 1), k));
      }
    }
  }
  return longer;
}

inline Label behind_fascia(double depth_mm, double muscle_mm, double z_mm, double middle_mm,
                           double liver_mm) {
  const double deep = depth_mm - muscle_mm;
  if (deep < 0.0) {
    return Label::Muscle;
  }
  if (deep < 2.0) {
    return Label::Adipose;  // between muscles
  }
  if (deep < 12.0) {
    return std::fmod(z_mm + 1000.0, 25.0) < 11.0 || middle_mm < 14.0 ? Label::Bone : Label::Muscle;
  }
  return deep < 14.0                           ? Label::Muscle
         : z_mm < liver_mm || middle_mm < 50.0 ? Label::Organ
                                               : Label::Lung;
}

/// Fills what a wall encloses: muscle of 4 to 13 mm, a stripe of fat, ribs every 25 mm and the
/// sternum, lungs, heart and the dome of the liver; the body goes on at the back.
inline Anatomy with_thorax(const Anatomy& front) {
  Anatomy body{with_back(front.labels, 46.0), with_back(front.water, 46.0)};
  LabelImage& labels = body.labels;
  Mask inside = image_like<unsigned char>(labels);
  const auto [nx, ny, nz] = labels.size;
  for (int k = 0; k < nz; ++k) {
    // Columns beside the thorax end in fat: the labels' air behind the flanks is none.
    for (int i = 0; i < nx; ++i) {
      bool seen = false;
      for (int j = 0; j < ny; ++j) {
        unsigned char& label = labels.at(i, j, k);
        seen = seen || label == code(Label::Adipose);
        label = seen && label == 0 ? code(Label::Adipose) : label;
        inside.at(i, j, k) = is_wall(label) ? 1 : 0;
      }
    }
  }
  const Image3<float> depth = signed_distance(inside, {true, true, true}, 40.0);
  const Image3<float> thickness = smooth_random(labels, 60.0, 3);
  const double middle = 0.5 * nx * labels.spacing_mm[0], half = 0.5 * nz * labels.spacing_mm[2];
  std::size_t v = 0;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i, ++v) {
        if (inside.voxels[v] != 0) {
          const double muscle =
              std::clamp(8.0 + 3.0 * static_cast<double>(thickness.voxels[v]), 4.0, 13.0);
          labels.voxels[v] = code(behind_fascia(
              -static_cast<double>(depth.voxels[v]), muscle, k * labels.spacing_mm[2] - half,
              std::abs(i * labels.spacing_mm[0] - middle), -50.0));
          body.water.voxels[v] = 0.0F;
        }
      }
    }
  }
  return body;
}

/// Breasts of a label map of the Pelicano repository (imaging/presets.cpp), and a thorax.
inline Anatomy real_anatomy(const std::filesystem::path& file) {
  Silent silent;
  const auto given = imaging::segment_given_labels(file, imaging::LabelPreset::Pelicano, 1.0,
                                                   Context("labels", silent));
  const Image3<float> levels = imaging::in_lps_order(io::read_image(file));
  constexpr std::array water{1.0F,  1.0F,  0.0F,  0.0F,  0.0F,  1.0F,
                             0.86F, 0.68F, 0.50F, 0.30F, 0.14F, 0.04F};
  Anatomy body{given.labels, image_like<float>(given.labels)};
  const auto fills_breast = [&](std::size_t v) {
    return body.labels.voxels[v] == code(Label::Adipose) ||
           body.labels.voxels[v] == code(Label::Fibroglandular);
  };
  std::size_t v = 0;
  for (int k = 0; k < body.labels.size[2]; ++k) {
    for (int j = 0; j < body.labels.size[1]; ++j) {
      for (int i = 0; i < body.labels.size[0]; ++i, ++v) {
        if (fills_breast(v)) {
          const Vec3 c = levels.continuous_index(body.labels.position_mm(i, j, k));
          std::array<int, 3> at{};
          for (std::size_t a = 0; a < 3; ++a) {
            at[a] = std::clamp(static_cast<int>(std::lround(c[a])), 0, levels.size[a] - 1);
          }
          body.water.voxels[v] = water[static_cast<std::size_t>(levels.at(at[0], at[1], at[2]))];
        }
      }
    }
  }
  smooth(body.water, 0.55);  // levels are no tissues: what lies between them is
  for (v = 0; v < body.labels.voxels.size(); ++v) {
    if (fills_breast(v)) {
      body.labels.voxels[v] =
          code(body.water.voxels[v] > 0.5F ? Label::Fibroglandular : Label::Adipose);
    }
  }
  return with_thorax(body);
}

/// How the trunk goes on behind the field of a breast coil.
enum class Back { Round, AsWideAsTheField };

/// The whole trunk: behind its cut the body goes on for 110 mm and ends in the back, with spine,
/// muscle, fat and skin; air in front and behind.
inline Anatomy with_back_of_trunk(const Anatomy& cut, Back shape) {
  constexpr double deep_mm = 110.0, front_air_mm = 40.0, back_air_mm = 30.0;
  const double h = cut.labels.spacing_mm[1];
  const auto [nx, ny, nz] = cut.labels.size;
  const int room = static_cast<int>(front_air_mm / h);
  Anatomy whole;
  whole.labels = image_like<unsigned char>(cut.labels);
  whole.labels.size[1] = ny + room + static_cast<int>((deep_mm + back_air_mm) / h);
  whole.labels.origin_mm = cut.labels.position_mm(0, -room, 0);
  whole.labels.voxels.clear();
  whole.water = image_like<float>(whole.labels);  // no voxels yet
  for (int k = 0; k < nz; ++k) {
    int first = nx, last = -1;  // of the cut's row
    for (int i = 0; i < nx; ++i) {
      if (cut.labels.at(i, ny - 1, k) != 0) {
        first = std::min(first, i);
        last = i;
      }
    }
    const double middle = 0.5 * (first + last), half = 0.5 * (last - first) + 1.0;
    for (int j = 0; j < whole.labels.size[1]; ++j) {
      const int row = std::clamp(j - room, 0, ny - 1);
      const double behind = (j - room - (ny - 1)) * h;
      for (int i = 0; i < nx; ++i) {
        const bool round = shape == Back::Round;
        const double aside = std::min(std::abs(i - middle) / half, 1.0);
        const double to_back =
            (round ? deep_mm * std::sqrt(1.0 - aside * aside) : deep_mm) - behind;
        const double narrowed =
            round && behind > 0.0 ? std::sqrt(1.0 - std::pow(std::min(behind / deep_mm, 0.999), 2))
                                  : 1.0;
        const int from = std::clamp(static_cast<int>(std::lround(middle + (i - middle) / narrowed)),
                                    first, last);
        Label label = Label::Air;
        float water = 0.0F;
        if (j >= room && (behind <= 0.0 || to_back > 0.0)) {
          const int column = behind <= 0.0 ? i : from;
          label = static_cast<Label>(cut.labels.at(column, row, k));
          water = cut.water.at(column, row, k);
          if (behind > 0.0) {
            // Beside the cut's skin a body as wide as the field goes on with fat.
            label = !round && (i <= first + 2 || i >= last - 2) ? Label::Adipose : label;
            label = to_back < 2.0                                       ? Label::Skin
                    : to_back < 12.0                                    ? Label::Adipose
                    : to_back < 40.0                                    ? Label::Muscle
                    : to_back < 80.0 && std::abs(i - middle) * h < 20.0 ? Label::Bone
                                                                        : label;
            water = label == Label::Adipose ? water : 0.0F;
          }
        }
        whole.labels.voxels.push_back(code(label));
        whole.water.voxels.push_back(water);
      }
    }
  }
  return whole;
}

/// Only gland that is thick is left.
inline void make_fatty(Anatomy& body) {
  Image3<float> thick = image_like<float>(body.labels);
  for (std::size_t v = 0; v < thick.voxels.size(); ++v) {
    thick.voxels[v] = body.labels.voxels[v] == code(Label::Fibroglandular) ? 1.0F : 0.0F;
  }
  smooth(thick, 3.0);
  for (std::size_t v = 0; v < thick.voxels.size(); ++v) {
    unsigned char& label = body.labels.voxels[v];
    if (thick.voxels[v] < 0.55F &&
        (label == code(Label::Fibroglandular) || label == code(Label::Adipose))) {
      body.water.voxels[v] = 0.0F;
      label = code(Label::Adipose);
    }
  }
}

/// Gland fills what lies around it, but for a layer below the skin and before the wall.
inline void make_dense(Anatomy& body) {
  Image3<float> around = body.water;
  smooth(around, 5.0);
  for (std::size_t v = 0; v < around.voxels.size(); ++v) {
    unsigned char& label = body.labels.voxels[v];
    if (label == code(Label::Fibroglandular) || label == code(Label::Adipose)) {
      float& water = body.water.voxels[v];
      water = std::max(water, std::clamp(6.0F * (around.voxels[v] - 0.12F), 0.0F, 1.0F));
      label = code(water > 0.5F ? Label::Fibroglandular : Label::Adipose);
    }
  }
}

/// The body moved along y: `source(i, y)` is the old y [mm from the first row] of a new one;
/// `room_mm` more at the front.
template <class T, class Source>
Image3<T> moved(const Image3<T>& image, double room_mm, const Source& source) {
  Image3<T> result = image;
  const int room = static_cast<int>(room_mm / image.spacing_mm[1]);
  result.size[1] += room;
  result.origin_mm = image.position_mm(0, -room, 0);
  result.voxels.assign(static_cast<std::size_t>(result.size[0]) *
                           static_cast<std::size_t>(result.size[1]) *
                           static_cast<std::size_t>(result.size[2]),
                       T{});
  for (int k = 0; k < result.size[2]; ++k) {
    for (int j = 0; j < result.size[1]; ++j) {
      for (int i = 0; i < result.size[0]; ++i) {
        const long from =
            std::lround(source(i, (j - room) * image.spacing_mm[1]) / image.spacing_mm[1]);
        if (from >= 0 && from < image.size[1]) {
          result.at(i, j, k) = image.at(i, static_cast<int>(from), k);
        }
      }
    }
  }
  return result;
}

/// Breasts stretched towards anterior about a plane behind them, right and left.
template <class T>
Image3<T> stretched(const Image3<T>& image, double right, double left) {
  const double back = (image.size[1] - 1) * image.spacing_mm[1];
  return moved(image, std::max({0.0, right - 1.0, left - 1.0}) * back, [&](int i, double y) {
    const double side = std::clamp((i - 0.44 * image.size[0]) / (0.12 * image.size[0]), 0.0, 1.0);
    return back - (back - y) / (right + (left - right) * side);
  });
}

/// Skin that rests on the coil: the front `flat_mm` of the breasts are pressed flat.
inline Anatomy pressed(const Anatomy& body, double flat_mm) {
  int front = body.labels.size[1];
  for (int k = 0; k < body.labels.size[2]; ++k) {
    for (int j = 0; j < front; ++j) {
      for (int i = 0; i < body.labels.size[0]; ++i) {
        front = body.labels.at(i, j, k) != 0 ? std::min(front, j) : front;
      }
    }
  }
  const double plate = front * body.labels.spacing_mm[1] + flat_mm;
  Anatomy result = body;
  for (int k = 0; k < body.labels.size[2]; ++k) {
    for (int j = 0; j < body.labels.size[1]; ++j) {
      for (int i = 0; i < body.labels.size[0]; ++i) {
        const double before = plate - j * body.labels.spacing_mm[1];
        unsigned char& label = result.labels.at(i, j, k);
        if (before > 0.0) {
          label = 0;
          result.water.at(i, j, k) = 0.0F;
        } else if (before > -2.0 && label != 0) {
          label = code(Label::Skin);
          result.water.at(i, j, k) = 0.0F;
        }
      }
    }
  }
  return result;
}

}  // namespace sanatrix::testing
