// Counts the bytes that a complete image file must have.
#include "io/image_completeness.hpp"

#include <charconv>
#include <string>
#include <vector>

#include <zlib.h>

#include "core/files.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

/// zlib checks the CRC on the way; it reads plain files through as they are.
bool nifti_is_complete(const fs::path& file, std::uint64_t voxel_bytes) {
  constexpr std::uint64_t header = 348;
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
  return gzclose(in) == Z_OK && count == 0 && total >= header + voxel_bytes;
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
  const std::string name = file.filename().string();
  if (name.ends_with(".mha")) {
    return meta_is_complete(file, voxel_bytes);
  }
  return name.ends_with(".nrrd") || nifti_is_complete(file, voxel_bytes);
}

}  // namespace sanatrix::io
