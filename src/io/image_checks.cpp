#include "io/image_checks.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/nifti_header.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

bool named(const fs::path& file, std::initializer_list<std::string_view> endings) {
  std::string name = file.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::any_of(endings, [&](std::string_view end) { return name.ends_with(end); });
}

bool is_nifti(const fs::path& file) {
  return named(file, {".nii", ".nii.gz"});
}

/// Without "space: ..." ITK takes the axes for left, posterior, superior.
void require_nrrd_says_its_place(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  bool has_space = false, has_directions = false;
  for (int n = 0; n < 1000 && std::getline(in, line) && !line.empty() && line != "\r"; ++n) {
    std::ranges::transform(line, line.begin(), [](unsigned char c) { return std::tolower(c); });
    if (line.starts_with("space:")) {
      has_space = line.find("left-") != std::string::npos ||
                  line.find("right-") != std::string::npos ||
                  line.find("las") != std::string::npos || line.find("lps") != std::string::npos ||
                  line.find("ras") != std::string::npos;
    }
    has_directions = has_directions || line.starts_with("space directions:");
    if (line.starts_with("space units:") && line.find("\"mm\"") == std::string::npos) {
      throw Error(Fault::Input, "its lengths are not in millimetres (" + line.substr(0, 40) + ")",
                  "export the image again in millimetres");
    }
  }
  if (!line.empty() && line != "\r" && !in.eof()) {
    return;  // no header that ITK would read
  }
  if (!has_space || !has_directions) {
    throw Error(Fault::Input,
                "it does not say which side is the patient's left (space, space directions)",
                "export it again from its source with orientation");
  }
}

/// zlib checks the CRC on the way; it reads plain files through as they are.
bool nifti_is_complete(const fs::path& file, std::uint64_t bytes) {
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
  return gzclose(in) == Z_OK && count == 0 && total >= bytes;
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
  return !is_nifti(file) || nifti_is_complete(file, nifti_bytes(file).value_or(voxel_bytes));
}

void require_sound_header(const fs::path& file) {
  if (is_nifti(file)) {
    require_sound_nifti_header(file);
  } else if (named(file, {".nrrd"})) {
    require_nrrd_says_its_place(file);
  }
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
