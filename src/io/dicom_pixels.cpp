// Reads DICOM pixels with DCMTK: any transfer syntax that it can decode, 8 or 16 bits, rescaled.
#include <cmath>
#include <memory>

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <dcmtk/oflog/oflog.h>

#include "core/error.hpp"
#include "io/dicom_slice.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr double most_rescaling = 1e15;  ///< far from what a float cannot hold

/// How stored bits become a number.
struct BitLayout {
  int allocated = 16, stored = 12, high = 11;
  bool is_signed = false;
  bool inverted = false;  ///< MONOCHROME1: the least value is white

  [[nodiscard]] float value(unsigned raw) const {
    const unsigned bits = (raw >> static_cast<unsigned>(high + 1 - stored)) &
                          ((1U << static_cast<unsigned>(stored)) - 1U);
    const bool negative = is_signed && ((bits >> static_cast<unsigned>(stored - 1)) & 1U) != 0;
    const int number = static_cast<int>(bits) - (negative ? 1 << stored : 0);
    const int ends = is_signed ? -1 : (1 << stored) - 1;  // least and greatest value added
    return static_cast<float>(inverted ? ends - number : number);
  }
};

class PixelFile {
 public:
  explicit PixelFile(const fs::path& file) : name_(file.filename().string()) {
    check(format_.loadFile(file.c_str()));
    check(format_.loadAllDataIntoMemory());
    DcmDataset& data = *format_.getDataset();
    const auto syntax = data.getCurrentXfer();
    if (data.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).bad() ||
        !data.canWriteXfer(EXS_LittleEndianExplicit)) {
      throw Error(Fault::Input,
                  fmt::format("{} is compressed as {}, which cannot be decoded here", name_,
                              DcmXfer(syntax).getXferName()),
                  "export it uncompressed or as JPEG, JPEG-LS or RLE");
    }
    Uint16 samples = 1;
    data.findAndGetUint16(DCM_SamplesPerPixel, samples);
    require(samples == 1, "{} is a colour image; a grey-scale MRI is needed", name_);
    read_layout(data);
    const auto get = [&](auto& pixels) {
      return layout_.allocated == 8 ? data.findAndGetUint8Array(DCM_PixelData, bytes_, &count_)
                                    : data.findAndGetUint16Array(DCM_PixelData, pixels, &count_);
    };
    check(get(words_));
  }

  void append(const DicomSlice& slice, std::vector<float>& voxels) const {
    const std::size_t size =
        static_cast<std::size_t>(slice.size[0]) * static_cast<std::size_t>(slice.size[1]);
    const std::size_t first = size * static_cast<std::size_t>(slice.frame);
    if (first + size > count_) {
      throw Error(Fault::Input,
                  fmt::format("{} has fewer voxels than it says; it is cut off", name_),
                  "copy it again from its source");
    }
    require(std::abs(slice.slope) > 0.0 && std::abs(slice.slope) < most_rescaling &&
                std::abs(slice.intercept) < most_rescaling,
            "{} has rescale slope {} and intercept {}", name_, slice.slope, slice.intercept);
    for (std::size_t i = first; i < first + size; ++i) {
      const unsigned raw = layout_.allocated == 8 ? bytes_[i] : words_[i];
      voxels.push_back(static_cast<float>(slice.slope * static_cast<double>(layout_.value(raw)) +
                                          slice.intercept));
    }
  }

 private:
  void check(const OFCondition& condition) const {
    if (condition.bad()) {
      throw Error(Fault::Input, fmt::format("{} is damaged: {}", name_, condition.text()),
                  "copy it again from its source");
    }
  }
  void read_layout(DcmDataset& data) {
    Uint16 allocated = 16, stored = 16, high = 15, representation = 0;
    data.findAndGetUint16(DCM_BitsAllocated, allocated);
    stored = allocated;
    data.findAndGetUint16(DCM_BitsStored, stored);
    high = static_cast<Uint16>(stored - 1);
    data.findAndGetUint16(DCM_HighBit, high);
    data.findAndGetUint16(DCM_PixelRepresentation, representation);
    require((allocated == 8 || allocated == 16) && stored >= 1 && stored <= allocated &&
                high < allocated && high + 1 >= stored,
            "{} stores {} of {} bits with high bit {}; 8 or 16 bits can be read", name_, stored,
            allocated, high);
    OFString meaning;
    data.findAndGetOFString(DCM_PhotometricInterpretation, meaning);
    layout_ = {allocated, stored, high, representation == 1, meaning == "MONOCHROME1"};
  }

  std::string name_;
  DcmFileFormat format_;
  BitLayout layout_;
  const Uint8* bytes_ = nullptr;
  const Uint16* words_ = nullptr;
  unsigned long count_ = 0;
};

}  // namespace

std::vector<float> read_dicom_pixels(const std::vector<fs::path>& files,
                                     const std::vector<DicomSlice>& slices, volatile int* at) {
  OFLog::configure(OFLogger::OFF_LOG_LEVEL);
  DJDecoderRegistration::registerCodecs();
  DJLSDecoderRegistration::registerCodecs();
  DcmRLEDecoderRegistration::registerCodecs();
  std::vector<float> voxels;
  std::unique_ptr<PixelFile> open;
  int opened = -1;
  for (const DicomSlice& slice : slices) {
    if (slice.file != opened) {
      *at = slice.file;
      open.reset();  // one file in memory at a time
      open = std::make_unique<PixelFile>(files[static_cast<std::size_t>(slice.file)]);
      opened = slice.file;
    }
    open->append(slice, voxels);
  }
  return voxels;
}

}  // namespace sanatrix::io
