#include "io/image_checks.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <zlib.h>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t nifti_header = 348;

bool is_nifti(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}

/// The first bytes, unpacked; fewer when the file is shorter.
std::vector<char> first_bytes(const fs::path& file, std::size_t count) {
  std::vector<char> bytes(count);
  const gzFile in = gzopen(file.c_str(), "rb");
  const int read = in == nullptr ? 0 : gzread(in, bytes.data(), static_cast<unsigned>(count));
  if (in != nullptr) {
    gzclose(in);
  }
  bytes.resize(static_cast<std::size_t>(std::max(read, 0)));
  return bytes;
}

/// zlib checks the CRC on the way; it reads plain files through as they are.
bool nifti_is_complete(const fs::path& file, std::uint64_t voxel_bytes) {
  const gzFile in = gzopen(file.c_str(), "rb");
  if (in == nullptr) {
    return false;
  }
  std::vector<char> block(std::size_t{1} << 20);
  std::uint64_t total = 0;
  int count = 0;
  while ((count = gzread(in, block.data(), static_cast<unsigned>(block.size()))) > 0) {
    total += static_cast<std::uint64_t>(count);
  }
  return gzclose(in) == Z_OK && count == 0 && total >= nifti_header + voxel_bytes;
}

bool meta_is_complete(const fs::path& file, std::uint64_t voxel_bytes) {
  const std::string text = read_text(file);
  constexpr std::string_view last_key = "ElementDataFile", size_key = "CompressedDataSize = ";
  const std::size_t header = text.find('\n', text.find(last_key));
  if (header == std::string::npos) {
    return false;
  }
  std::uint64_t wanted = voxel_bytes;
  if (const std::size_t key = text.find(size_key); key < header) {
    std::from_chars(text.data() + key + size_key.size(), text.data() + header, wanted);
  }
  return text.size() - header - 1 >= wanted;
}

}  // namespace

bool is_complete(const fs::path& file, std::uint64_t voxel_bytes) {
  if (file.extension() == ".mha") {
    return meta_is_complete(file, voxel_bytes);
  }
  return !is_nifti(file) || nifti_is_complete(file, voxel_bytes);
}

bool has_finite_header(const fs::path& file) {
  const std::vector<char> header =
      is_nifti(file) ? first_bytes(file, nifti_header) : std::vector<char>{};
  if (header.size() < nifti_header) {
    return true;  // not ours to judge
  }
  std::int32_t size = 0;
  std::memcpy(&size, header.data(), sizeof size);
  const bool swapped = size != static_cast<std::int32_t>(nifti_header);
  const auto finite = [&](std::size_t at) {
    std::array<char, sizeof(float)> bytes{};
    std::copy_n(header.begin() + static_cast<std::ptrdiff_t>(at), bytes.size(), bytes.begin());
    if (swapped) {
      std::ranges::reverse(bytes);
    }
    float value = 0.0F;
    std::memcpy(&value, bytes.data(), sizeof value);
    return std::isfinite(value);
  };
  // nifti1.h: pixdim[1..3] at 80; quatern_b to qoffset_z and the rows of the affine from 256 on.
  bool good = true;
  for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>{80, 92}, {256, 328}}) {
    for (std::size_t at = from; at < to; at += sizeof(float)) {
      good = good && finite(at);
    }
  }
  return good;
}

void require_sound_place(const Vec3& spacing_mm, const Vec3& origin_mm, const Mat3& direction) {
  constexpr double least_mm = 0.02, most_mm = 50.0, skew = 1e-3;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(spacing_mm[a] >= least_mm && spacing_mm[a] <= most_mm)) {
      throw Error(Fault::Input,
                  fmt::format("its voxels are {:.3g} x {:.3g} x {:.3g} mm", spacing_mm[0],
                              spacing_mm[1], spacing_mm[2]),
                  "lengths must be millimetres; export the image again");
    }
    require(std::isfinite(origin_mm[a]), "its position is not a finite number");
  }
  const Mat3 product = transpose(direction) * direction;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (!(std::abs(product[i][j] - (i == j ? 1.0 : 0.0)) < skew)) {
        throw Error(
            Fault::Input, "the axes of its voxels are not perpendicular",
            "resample it to a rectangular grid (a tilted gantry, or an affine registration)");
      }
    }
  }
}

}  // namespace sanatrix::io
