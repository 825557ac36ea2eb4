// DICOM in: what a folder holds, which stack of slices suits a breast model, and its voxels. All
// parsing happens in a confined child process; nothing that identifies a patient leaves it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/image.hpp"
#include "io/dicom_slice.hpp"

namespace sanatrix::io {

/// Parallel slices that form a volume, sorted along their normal.
struct DicomVolume {
  Acquisition acquisition;
  int index = 0;  ///< position in the list, from 1; what `--series` takes
  std::array<int, 3> size{};
  Vec3 spacing_mm{}, origin_mm{};
  Mat3 direction = identity3;  ///< columns: LPS directions of column index, row index, slice
  double thickness_mm = 0.0;   ///< 0: not said
  std::vector<DicomSlice> slices;
  std::vector<std::string> warnings;
  std::string defect;                    ///< why these slices are no volume; empty: they are
  std::string unfit;                     ///< why the program would not choose it; empty: it could
  [[nodiscard]] Vec3 extent_mm() const;  ///< along LPS
  [[nodiscard]] std::string plane() const;  ///< "axial", "oblique coronal", ...
};

struct DicomFolder {
  std::vector<std::filesystem::path> files;
  std::vector<DicomVolume> volumes;
  int files_without_image = 0;
  long elements_left_behind = 0, private_left_behind = 0;
};

/// Reads all headers under a folder (or of one file). Error{Input} when there is no DICOM image,
/// or a file is damaged.
DicomFolder scan_dicom(const std::filesystem::path& path);

/// The volume for a breast model: MRI, not fat-suppressed, both breasts in the field; T1 before T2,
/// axial before others, finer before coarser. `series`: 0, or the number of a volume in the list.
/// Error{Input} saying what is wrong with each when none fits.
const DicomVolume& choose_volume(const DicomFolder& folder, int series);

/// Error{Input} naming the file when pixels are missing, damaged or compressed in an unknown way.
Image3<float> read_dicom(const DicomFolder& folder, const DicomVolume& volume);

/// Sorts slices into volumes and checks them; pure, for scan_dicom and for tests.
std::vector<DicomVolume> assemble_volumes(const std::vector<DicomSlice>& slices);

}  // namespace sanatrix::io
