// Reads DICOM headers with DCMTK. Only what DicomSlice has is taken over (an allow-list, so that
// nothing that identifies a patient passes, known or private: PS3.15 Annex E, Basic Profile).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/oflog/oflog.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/dicom_slice.hpp"
#include "io/series_words.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

/// Elements that are longer stay on disk: pixels are not read here.
constexpr Uint32 longest_loaded_element = 4096;
constexpr long most_frames = 20000;
/// Elements that are kept in some form; all others are counted as left behind.
constexpr int kept_elements = 24;

std::optional<double> number(DcmItem& item, const DcmTagKey& tag, unsigned long at = 0) {
  Float64 value = 0.0;
  if (item.findAndGetFloat64(tag, value, at).good() && std::isfinite(value)) {
    return value;
  }
  // Explicit VR files may hold decimal strings that the call above refuses (stray blanks).
  OFString text;
  if (item.findAndGetOFString(tag, text, at).bad() || text.empty()) {
    return std::nullopt;
  }
  char* end = nullptr;
  const double parsed = std::strtod(text.c_str(), &end);
  return end != text.c_str() && std::isfinite(parsed) ? std::optional(parsed) : std::nullopt;
}

int integer(DcmItem& item, const DcmTagKey& tag, int otherwise) {
  const auto value = number(item, tag);
  return value && std::abs(*value) < 1e9 ? static_cast<int>(*value) : otherwise;
}

/// A code string (CS): capitals, digits, blank and underscore, as the standard says; nothing else
/// passes.
std::string code(DcmItem& item, const DcmTagKey& tag, unsigned long at = 0) {
  OFString text;
  if (item.findAndGetOFString(tag, text, at).bad()) {
    return {};
  }
  std::string clean;
  for (const char c : text) {
    if ((c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_') {
      clean += c;
    }
  }
  return clean.substr(0, 16);
}

Code short_code(DcmItem& item, const DcmTagKey& tag) {
  const std::string text = code(item, tag);
  Code result;
  std::ranges::copy(text, result.letters.begin());  // at most 16 of 17
  return result;
}

/// Free text in lower case; for looking at within this file only.
std::string words(DcmItem& item, const DcmTagKey& tag) {
  OFString text;
  std::string lower;
  if (item.findAndGetOFStringArray(tag, text).good()) {
    for (const char c : text) {
      lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return lower;
}

bool has_any(std::string_view text, std::initializer_list<std::string_view> parts) {
  for (const std::string_view part : parts) {
    if (text.find(part) != std::string_view::npos) {
      return true;
    }
  }
  return false;
}

/// Where the attributes of one frame are: in its functional groups, in the shared ones, or (single
/// frame) in the data set itself.
struct Frame {
  DcmDataset& data;
  DcmItem* shared = nullptr;
  DcmItem* own = nullptr;

  /// The item of a functional group's macro that holds this frame's values.
  [[nodiscard]] DcmItem& macro(const DcmTagKey& sequence) const {
    for (DcmItem* groups : {own, shared}) {
      DcmItem* item = nullptr;
      if (groups != nullptr && groups->findAndGetSequenceItem(sequence, item, 0).good() &&
          item != nullptr) {
        return *item;
      }
    }
    return data;
  }
};

Weighting weighting_of(double tr_ms, double te_ms, const std::string& description) {
  if (te_ms >= 60.0 && (tr_ms == 0.0 || tr_ms >= 1500.0)) {
    return Weighting::T2;
  }
  if (te_ms > 0.0 && te_ms < 30.0 && tr_ms > 0.0 && tr_ms < 1500.0) {
    return Weighting::T1;
  }
  if (te_ms > 0.0 && tr_ms > 0.0) {
    return Weighting::Other;
  }
  return description.find("t1") != std::string::npos   ? Weighting::T1
         : description.find("t2") != std::string::npos ? Weighting::T2
                                                       : Weighting::Unknown;
}

std::string image_type(const Frame& frame) {
  std::string type;
  for (const auto& [item, tag] : {std::pair<DcmItem*, DcmTagKey>{&frame.data, DCM_ImageType},
                                  {&frame.macro(DCM_MRImageFrameTypeSequence), DCM_FrameType}}) {
    for (unsigned long i = 0; i < 8; ++i) {
      type += '\\' + code(*item, tag, i) + '\\';
    }
  }
  return type;
}

/// Inversion recovery with the time at which fat passes through zero (150 ms at 1.5 T, 230 ms at 3
/// T).
bool nulls_fat(DcmItem& data) {
  const double time_ms = number(data, DCM_InversionTime).value_or(0.0);
  return time_ms >= 100.0 && time_ms <= 280.0;
}

/// Echo-planar images of the breast are taken for diffusion.
bool is_diffusion(const Frame& frame) {
  const double b = number(frame.macro(DCM_MRDiffusionSequence), DCM_DiffusionBValue).value_or(0.0);
  return b > 0.0 || ('\\' + words(frame.data, DCM_ScanningSequence) + '\\').find("\\ep\\") !=
                        std::string::npos;
}

Acquisition acquisition_of(const Frame& frame, const std::string& type) {
  DcmDataset& data = frame.data;
  Acquisition a;
  a.series_number = integer(data, DCM_SeriesNumber, 0);
  a.modality = short_code(data, DCM_Modality);
  a.patient_position = short_code(data, DCM_PatientPosition);
  a.field_strength_t = number(data, DCM_MagneticFieldStrength).value_or(0.0);
  DcmItem& timing = frame.macro(DCM_MRTimingAndRelatedParametersSequence);
  a.repetition_time_ms = number(timing, DCM_RepetitionTime).value_or(0.0);
  DcmItem& echo = frame.macro(DCM_MREchoSequence);
  a.echo_time_ms =
      number(echo, DCM_EffectiveEchoTime).value_or(number(data, DCM_EchoTime).value_or(0.0));
  const std::string description =
      words(data, DCM_SeriesDescription) + ' ' + words(data, DCM_ProtocolName);
  a.weighting = weighting_of(a.repetition_time_ms, a.echo_time_ms, description);
  // Scan options code FS is fat saturation (C.8.3.1.1.3), SPIR and STIR are other ways to it.
  const std::string options = words(data, DCM_ScanOptions);
  const std::string suppression =
      words(frame.macro(DCM_MRModifierSequence), DCM_SpectrallySelectedSuppression);
  a.fat_suppressed = options == "fs" || options.starts_with("fs\\") ||
                     options.find("\\fs") != std::string::npos || suppression == "fat" ||
                     nulls_fat(data) || names_fat_suppression(description);
  a.localizer = has_any(type, {"LOCALIZER", "SCOUT"}) || names_localizer(description);
  a.derived_kind = has_any(type, {"SUBTRACT", "PROJECTION", "MIP", "MPR", "ADC", "PHASEMAP",
                                  "\\PHASE\\", "OUT_PHASE", "OPP_PHASE", "\\OP\\", "\\P\\", "\\W\\",
                                  "\\F\\", "WATER", "FAT\\", "DIFFUSION"}) ||
                   is_diffusion(frame) || names_computed_image(description);
  a.contrast_agent = !words(data, DCM_ContrastBolusAgent).empty();
  return a;
}

/// Everything that separates two stacks of one series: time point, echo, kind, diffusion, matrix.
std::string stack_key(const Frame& frame, const DicomSlice& slice, const std::string& type) {
  OFString series, temporal, acquired_b;
  frame.data.findAndGetOFString(DCM_SeriesInstanceUID, series);
  DcmItem& content = frame.macro(DCM_FrameContentSequence);
  content.findAndGetOFString(
      &content == &frame.data ? DCM_TemporalPositionIdentifier : DCM_TemporalPositionIndex,
      temporal);
  frame.macro(DCM_MRDiffusionSequence).findAndGetOFString(DCM_DiffusionBValue, acquired_b);
  return fmt::format("{}|{}|{}|{}|{}|{}|{}x{}", slice.patient, series.c_str(), temporal.c_str(),
                     acquired_b.c_str(), type, slice.acquisition.echo_time_ms, slice.size[0],
                     slice.size[1]);
}

void read_geometry(const Frame& frame, DicomSlice& slice) {
  DcmItem& position = frame.macro(DCM_PlanePositionSequence);
  DcmItem& orientation = frame.macro(DCM_PlaneOrientationSequence);
  DcmItem& measures = frame.macro(DCM_PixelMeasuresSequence);
  bool complete = true;
  const auto take = [&](DcmItem& item, const DcmTagKey& tag, unsigned long at, double& value) {
    const auto found = number(item, tag, at);
    complete = complete && found.has_value();
    value = found.value_or(0.0);
  };
  for (unsigned long a = 0; a < 3; ++a) {
    take(position, DCM_ImagePositionPatient, a, slice.position_mm[a]);
    take(orientation, DCM_ImageOrientationPatient, a, slice.row[a]);
    take(orientation, DCM_ImageOrientationPatient, a + 3, slice.column[a]);
  }
  take(measures, DCM_PixelSpacing, 0, slice.pixel_mm[1]);  // between rows comes first
  take(measures, DCM_PixelSpacing, 1, slice.pixel_mm[0]);
  slice.has_geometry = complete;
  slice.thickness_mm = number(measures, DCM_SliceThickness).value_or(0.0);
  DcmItem& scaling = frame.macro(DCM_PixelValueTransformationSequence);
  slice.slope = number(scaling, DCM_RescaleSlope).value_or(1.0);
  slice.intercept = number(scaling, DCM_RescaleIntercept).value_or(0.0);
}

/// A file of PS3.10, or a bare data set, as old archives and network dumps have it: it begins with
/// an element of group 8.
bool is_dicom(const fs::path& file) {
  constexpr std::size_t preamble = 128;
  char start[preamble + 4] = {};
  const auto close = [](std::FILE* f) {
    std::fclose(f);
  };
  const std::unique_ptr<std::FILE, decltype(close)> in(std::fopen(file.c_str(), "rb"), close);
  return in && std::fread(start, 1, sizeof start, in.get()) == sizeof start &&
         (std::string_view(start + preamble, 4) == "DICM" ||
          (start[0] == 8 && start[1] == 0 && start[3] == 0));
}

void count_elements(DcmItem& data, DicomHeaders& headers) {
  DcmStack stack;
  long elements = 0;
  while (data.nextObject(stack, OFTrue).good()) {
    DcmObject* object = stack.top();
    if (object->isLeaf() && object->getLength() > 0) {
      ++elements;
      headers.private_left_behind += object->getGTag() % 2;
    }
  }
  headers.elements_left_behind += std::max(0L, elements - kept_elements);
}

/// Numbers for keys, in the order of their first appearance.
class Numbering {
 public:
  int of(const std::string& key) {
    return numbers_.try_emplace(key, static_cast<int>(numbers_.size())).first->second;
  }

 private:
  std::map<std::string, int> numbers_;
};

class HeaderReader {
 public:
  DicomHeaders headers;

  void read(const fs::path& file, int index) {
    DcmFileFormat format;
    const OFCondition loaded = format.loadFile(file.c_str(), EXS_Unknown, EGL_noChange,
                                               longest_loaded_element, ERM_autoDetect);
    if (loaded.bad()) {
      throw Error(Fault::Input,
                  fmt::format("{} is damaged: {}", file.filename().string(), loaded.text()),
                  "copy it again from its source, or remove it from the folder");
    }
    DcmDataset& data = *format.getDataset();
    count_elements(data, headers);
    DicomSlice slice;
    slice.file = index;
    slice.size = {integer(data, DCM_Columns, 0), integer(data, DCM_Rows, 0)};
    if (slice.size[0] < 1 || slice.size[1] < 1 || !data.tagExists(DCM_PixelData)) {
      ++headers.files_without_image;
      return;
    }
    OFString series_uid, examination_uid, patient;
    data.findAndGetOFString(DCM_SeriesInstanceUID, series_uid);
    data.findAndGetOFString(DCM_StudyInstanceUID, examination_uid);
    if (data.findAndGetOFString(DCM_PatientID, patient).bad() || patient.empty()) {
      data.findAndGetOFString(DCM_PatientName, patient);
    }
    slice.patient = patients_.of(patient.c_str());
    slice.examination = examinations_.of(examination_uid.c_str());
    slice.series = series_.of(series_uid.c_str());
    const long frames = integer(data, DCM_NumberOfFrames, 1);
    require(frames >= 1 && frames <= most_frames, "{} says that it has {} frames",
            file.filename().string(), frames);
    Frame frame{data};
    data.findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, frame.shared, 0);
    for (long f = 0; f < frames; ++f) {
      slice.frame = static_cast<int>(f);
      frame.own = nullptr;
      data.findAndGetSequenceItem(DCM_PerFrameFunctionalGroupsSequence, frame.own, f);
      read_geometry(frame, slice);
      const std::string type = image_type(frame);
      slice.acquisition = acquisition_of(frame, type);
      slice.instance_number = integer(data, DCM_InstanceNumber, 0) + static_cast<int>(f);
      slice.stack = stacks_.of(stack_key(frame, slice, type));
      headers.slices.push_back(slice);
    }
  }

 private:
  Numbering series_, stacks_, patients_, examinations_;
};

}  // namespace

DicomHeaders read_dicom_headers(const std::vector<fs::path>& files, volatile int* at) {
  OFLog::configure(OFLogger::OFF_LOG_LEVEL);  // it would print values of elements
  HeaderReader reader;
  for (std::size_t i = 0; i < files.size(); ++i) {
    *at = static_cast<int>(i);
    if (is_dicom(files[i])) {
      reader.read(files[i], static_cast<int>(i));
    } else {
      ++reader.headers.files_without_image;
    }
  }
  return reader.headers;
}

}  // namespace sanatrix::io
