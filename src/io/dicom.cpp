// Starts the confined children that read DICOM, and turns their answers into volumes.
#include "io/dicom.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <type_traits>

#include <sys/mman.h>

#include "core/confined_child.hpp"
#include "core/error.hpp"
#include "io/image_checks.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_files = 20000;
constexpr std::uint64_t most_memory = std::uint64_t{3} << 30;

/// An int that parent and child share: which file is being read.
class SharedIndex {
 public:
  SharedIndex()
      : at_(static_cast<volatile int*>(::mmap(nullptr, sizeof(int), PROT_READ | PROT_WRITE,
                                              MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    ensure(at_ != MAP_FAILED, "no shared memory");
    *at_ = 0;
  }
  ~SharedIndex() { ::munmap(const_cast<int*>(at_), sizeof(int)); }
  SharedIndex(const SharedIndex&) = delete;
  SharedIndex& operator=(const SharedIndex&) = delete;
  [[nodiscard]] volatile int* pointer() const { return at_; }

 private:
  volatile int* at_;
};

/// Files below a folder in a fixed order, or the one file.
std::vector<fs::path> files_under(const fs::path& path) {
  std::vector<fs::path> files;
  if (fs::is_regular_file(path)) {
    return {path};
  }
  require(fs::is_directory(path), "{} is neither a file nor a folder", path.string());
  for (const auto& entry :
       fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied)) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path());
      require(files.size() <= most_files,
              "{} holds more than {} files; give the folder of one examination", path.string(),
              most_files);
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Runs `work` confined; a crash names the file that was open.
std::string confined(const std::vector<fs::path>& files,
                     const std::function<std::string(volatile int*)>& work) {
  const SharedIndex at;
  try {
    return in_confined_child("DICOM", {.memory_bytes = most_memory},
                             [&] { return work(at.pointer()); });
  } catch (const Error& e) {
    const auto index = static_cast<std::size_t>(*at.pointer());
    const std::string name =
        index < files.size() ? files[index].filename().string() : std::string{};
    if (std::string_view(e.what()).find(name) != std::string_view::npos) {
      throw;
    }
    throw Error(e.fault(), fmt::format("{}: {}", name, e.what()), e.hint());
  }
}

static_assert(std::is_trivially_copyable_v<DicomSlice>);

struct Counts {
  int files_without_image;
  long elements, private_elements;
  std::size_t slices;
};

std::string pack(const DicomHeaders& headers) {
  const Counts counts{headers.files_without_image, headers.elements_left_behind,
                      headers.private_left_behind, headers.slices.size()};
  std::string bytes(reinterpret_cast<const char*>(&counts), sizeof counts);
  bytes.append(reinterpret_cast<const char*>(headers.slices.data()),
               headers.slices.size() * sizeof(DicomSlice));
  return bytes;
}

DicomHeaders unpack(const std::string& bytes) {
  Counts counts{};
  ensure(bytes.size() >= sizeof counts, "the DICOM reader answered {} bytes", bytes.size());
  std::memcpy(&counts, bytes.data(), sizeof counts);
  ensure(bytes.size() == sizeof counts + counts.slices * sizeof(DicomSlice),
         "the DICOM reader answered {} bytes for {} slices", bytes.size(), counts.slices);
  DicomHeaders headers{.slices = std::vector<DicomSlice>(counts.slices),
                       .files_without_image = counts.files_without_image,
                       .elements_left_behind = counts.elements,
                       .private_left_behind = counts.private_elements};
  std::memcpy(headers.slices.data(), bytes.data() + sizeof counts,
              counts.slices * sizeof(DicomSlice));
  return headers;
}

}  // namespace

DicomFolder scan_dicom(const fs::path& path) {
  require(fs::exists(path), "{} does not exist", path.string());
  DicomFolder folder;
  folder.files = files_under(path);
  const DicomHeaders headers = unpack(confined(
      folder.files, [&](volatile int* at) { return pack(read_dicom_headers(folder.files, at)); }));
  folder.files_without_image = headers.files_without_image;
  folder.elements_left_behind = headers.elements_left_behind;
  folder.private_left_behind = headers.private_left_behind;
  folder.volumes = assemble_volumes(headers.slices);
  if (folder.volumes.empty()) {
    throw Error(Fault::Input,
                fmt::format("{}: none of {} files is a DICOM image", path.filename().string(),
                            folder.files.size()),
                "give a DICOM folder, or a .nii.gz, .nii, .nrrd or .mha file");
  }
  return folder;
}

Image3<float> read_dicom(const DicomFolder& folder, const DicomVolume& volume) {
  Image3<float> image{.size = volume.size,
                      .spacing_mm = volume.spacing_mm,
                      .origin_mm = volume.origin_mm,
                      .direction = volume.direction,
                      .voxels = {}};
  require_sound_place(image.spacing_mm, image.origin_mm, image.direction);
  const std::size_t count = image.index(0, 0, volume.size[2]);
  require(count <= most_memory / 16, "{} x {} x {} voxels are too many for a breast MRI",
          volume.size[0], volume.size[1], volume.size[2]);
  const std::string bytes = confined(folder.files, [&](volatile int* at) {
    const std::vector<float> voxels = read_dicom_pixels(folder.files, volume.slices, at);
    return std::string(reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(float));
  });
  ensure(bytes.size() == count * sizeof(float), "the DICOM reader answered {} bytes for {} voxels",
         bytes.size(), count);
  image.voxels.resize(count);
  std::memcpy(image.voxels.data(), bytes.data(), bytes.size());
  return image;
}

}  // namespace sanatrix::io
