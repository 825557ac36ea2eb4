// A 3-D image with its place in the patient. Millimetres and LPS, as in files.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix {

template <class T>
struct Image3 {
  std::array<int, 3> size{};  ///< voxels along i, j, k
  Vec3 spacing_mm{1, 1, 1};
  Vec3 origin_mm{0, 0, 0};     ///< LPS position of the centre of voxel (0,0,0)
  Mat3 direction = identity3;  ///< columns are the LPS directions of i, j, k
  std::vector<T> voxels;       ///< i fastest

  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] const T& at(int i, int j, int k) const { return voxels[index(i, j, k)]; }
  [[nodiscard]] T& at(int i, int j, int k) { return voxels[index(i, j, k)]; }
  [[nodiscard]] Vec3 position_mm(double i, double j, double k) const {
    return origin_mm + direction * Vec3{i * spacing_mm[0], j * spacing_mm[1], k * spacing_mm[2]};
  }
  /// Continuous voxel coordinates of an LPS position.
  [[nodiscard]] Vec3 continuous_index(const Vec3& p_mm) const {
    const Vec3 r = transpose(direction) * (p_mm - origin_mm);
    return {r[0] / spacing_mm[0], r[1] / spacing_mm[1], r[2] / spacing_mm[2]};
  }
  [[nodiscard]] double voxel_volume_mm3() const {
    return spacing_mm[0] * spacing_mm[1] * spacing_mm[2];
  }
};

/// Tissue labels of a prone MRI; numbers are the file format (docs/user/labels.md).
enum class Label : unsigned char {
  Air = 0,
  Adipose = 1,
  Fibroglandular = 2,
  Skin = 3,
  Muscle = 4,
  Bone = 5,
  Lung = 6,
  Organ = 7,
  Tumour = 8,
  Nipple = 9,
  Vessel = 10,
};
using LabelImage = Image3<unsigned char>;

/// Soft tissue of the breast model: what is meshed when it lies in front of the chest wall.
constexpr bool is_soft(unsigned char label) {
  return label == 1 || label == 2 || label == 3 || label == 8 || label == 9 || label == 10;
}
/// Chest wall and everything behind it.
constexpr bool is_wall(unsigned char label) {
  return label >= 4 && label <= 7;
}

}  // namespace sanatrix
