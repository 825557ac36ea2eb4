// One frame of a DICOM file as Sanatrix needs it: geometry, scaling and physics. There is no
// member that could hold a name, a number, a date or free text of a patient.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix::io {

/// A coded word of at most 16 characters (DICOM value representation CS).
struct Code {
  std::array<char, 17> letters{};
  [[nodiscard]] std::string text() const { return letters.data(); }
};

/// How an acquisition weights tissues, as far as its parameters tell.
enum class Weighting { Unknown, T1, T2, Other };

/// What all frames of a stack have in common.
struct Acquisition {
  int series_number = 0;
  Code modality;          ///< "MR"
  Code patient_position;  ///< "HFP"; empty: not said
  Weighting weighting = Weighting::Unknown;
  bool fat_suppressed = false;
  bool localizer = false;
  /// Subtraction, projection, phase, parameter map, Dixon fat or water, diffusion.
  bool derived_kind = false;
  bool contrast_agent = false;  ///< an agent is named
  double field_strength_t = 0.0, repetition_time_ms = 0.0, echo_time_ms = 0.0;
};

/// Trivially copyable: it passes from the confined child to us as bytes.
struct DicomSlice {
  int file = 0;                                  ///< index into the list of files
  int frame = 0;                                 ///< within the file
  int patient = 0, examination = 0, series = 0;  ///< same number: same patient and so on
  int stack = 0;  ///< same number: same series, time point, echo, kind and matrix
  int instance_number = 0;
  std::array<int, 2> size{};  ///< columns, rows
  Vec3 position_mm{};         ///< of the centre of the first voxel, LPS
  Vec3 row{}, column{};       ///< LPS directions of growing column index and growing row index
  std::array<double, 2> pixel_mm{};  ///< between columns, between rows
  double thickness_mm = 0.0;         ///< 0: not said
  double slope = 1.0, intercept = 0.0;
  bool has_geometry = false;  ///< position, orientation and spacing are there and finite
  Acquisition acquisition;
};

/// What one pass over the files found. Lives only in memory.
struct DicomHeaders {
  std::vector<DicomSlice> slices;
  int files_without_image = 0;    ///< not DICOM, or DICOM without pixels
  long elements_left_behind = 0;  ///< data elements that are not taken over
  long private_left_behind = 0;   ///< of these, private ones
};

/// With DCMTK; call it in a confined child only. Error{Input} names the damaged file.
/// `at` is set to the index of the file being read, so that a crash can be attributed.
DicomHeaders read_dicom_headers(const std::vector<std::filesystem::path>& files, volatile int* at);

/// Voxels of the given slices, rescaled, one slice after the other. In a confined child only.
std::vector<float> read_dicom_pixels(const std::vector<std::filesystem::path>& files,
                                     const std::vector<DicomSlice>& slices, volatile int* at);

}  // namespace sanatrix::io
