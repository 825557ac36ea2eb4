#include "io/nifti_header.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include <zlib.h>

#include "core/error.hpp"
#include "geometry/vec3.hpp"
#include "io/image_checks.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

/// The fields of nifti1.h by their offsets, in the byte order of the file.
class Header {
 public:
  static constexpr std::size_t bytes = 348;

  static std::optional<Header> of(const fs::path& file) {
    Header header;
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
    if (!in || gzread(in.get(), header.data_.data(), bytes) != static_cast<int>(bytes)) {
      return std::nullopt;
    }
    header.swapped_ = header.get<std::int32_t>(0) != static_cast<std::int32_t>(bytes);
    return header.get<std::int32_t>(0) == static_cast<std::int32_t>(bytes) ? std::optional(header)
                                                                           : std::nullopt;
  }

  template <class T>
  [[nodiscard]] T get(std::size_t at) const {
    std::array<char, sizeof(T)> field{};
    std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(at), field.size(), field.begin());
    if (swapped_) {
      std::ranges::reverse(field);
    }
    T value{};
    std::memcpy(&value, field.data(), sizeof value);
    return value;
  }
  [[nodiscard]] double number(std::size_t at) const { return get<float>(at); }
  [[nodiscard]] double size(std::size_t axis) const { return get<std::int16_t>(42 + 2 * axis); }
  [[nodiscard]] double spacing(std::size_t axis) const { return std::abs(number(80 + 4 * axis)); }

 private:
  std::array<char, bytes> data_{};
  bool swapped_ = false;
};

/// Index to RAS [mm].
struct Affine {
  Mat3 axes{};  ///< columns: steps along i, j, k
  Vec3 origin{};
};

/// Method 2 of nifti1.h: a quaternion, spacing and the handedness of the grid.
Affine qform(const Header& h) {
  const double b = h.number(256), c = h.number(260), d = h.number(264);
  const double a = std::sqrt(std::max(0.0, 1.0 - b * b - c * c - d * d));
  const Mat3 turn{{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                   {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
                   {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c}}};
  Affine affine{.axes = turn, .origin = {h.number(268), h.number(272), h.number(276)}};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      affine.axes[r][axis] *= h.spacing(axis);
    }
    affine.axes[r][2] *= h.number(76) < 0.0 ? -1.0 : 1.0;
  }
  return affine;
}

/// Method 3: the rows of the matrix.
Affine sform(const Header& h) {
  Affine affine;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      affine.axes[r][axis] = h.number(280 + 16 * r + 4 * axis);
    }
    affine.origin[r] = h.number(292 + 16 * r);
  }
  return affine;
}

/// Greatest distance between two places of a voxel; affine, so it is at a corner.
double greatest_distance(const Affine& a, const Affine& b, const Header& h) {
  double most = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3 apart = a.origin - b.origin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double index = (corner >> axis) % 2 == 1 ? h.size(axis) - 1.0 : 0.0;
      for (std::size_t r = 0; r < 3; ++r) {
        apart[r] += index * (a.axes[r][axis] - b.axes[r][axis]);
      }
    }
    most = std::max(most, norm(apart));
  }
  return most;
}

void require_sound(const Affine& affine) {
  Vec3 spacing{};
  Mat3 direction = affine.axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    spacing[axis] = norm(Vec3{affine.axes[0][axis], affine.axes[1][axis], affine.axes[2][axis]});
    for (std::size_t r = 0; r < 3; ++r) {
      direction[r][axis] /= spacing[axis];
    }
  }
  require_sound_place(spacing, affine.origin, direction);
}

}  // namespace

void require_sound_nifti_header(const fs::path& file) {
  const std::optional<Header> h = Header::of(file);
  if (!h) {
    return;
  }
  // pixdim[1..3]; quatern_b to qoffset_z and the rows of the affine.
  for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>{80, 92}, {256, 328}}) {
    for (std::size_t at = from; at < to; at += sizeof(float)) {
      require(std::isfinite(h->number(at)), "its spacing or position is not a finite number");
    }
  }
  const bool has_qform = h->get<std::int16_t>(252) > 0, has_sform = h->get<std::int16_t>(254) > 0;
  if (!has_qform && !has_sform) {
    throw Error(Fault::Input,
                "it does not say which side is the patient's left (no qform, no sform)",
                "export it again from its source with orientation");
  }
  const int unit = h->get<std::int8_t>(123) & 7;
  if (unit == 1 || unit == 3) {
    throw Error(Fault::Input, fmt::format("its lengths are in {}metres", unit == 1 ? "" : "micro"),
                "export the image again in millimetres");
  }
  if (has_qform) {
    require_sound(qform(*h));
  }
  if (has_sform) {
    require_sound(sform(*h));
  }
  constexpr double rounding_mm = 1.0;
  const double apart_mm =
      has_qform && has_sform ? greatest_distance(qform(*h), sform(*h), *h) : 0.0;
  if (apart_mm > rounding_mm) {
    throw Error(Fault::Input,
                fmt::format("its two descriptions of place (qform and sform) differ by {:.0f} mm",
                            apart_mm),
                "keep the one in which the plan is given, and set the other alike");
  }
}

std::optional<std::uint64_t> nifti_bytes(const fs::path& file) {
  const std::optional<Header> h = Header::of(file);
  if (!h) {
    return std::nullopt;
  }
  std::uint64_t bytes = static_cast<std::uint64_t>(std::max<int>(h->get<std::int16_t>(72), 8)) / 8;
  const int axes = std::clamp<int>(h->get<std::int16_t>(40), 1, 7);
  for (int axis = 0; axis < axes; ++axis) {
    bytes *= static_cast<std::uint64_t>(std::max(1.0, h->size(static_cast<std::size_t>(axis))));
  }
  return bytes + Header::bytes;
}

}  // namespace sanatrix::io
