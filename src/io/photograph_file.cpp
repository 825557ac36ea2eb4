// Photographs of scans through VTK's readers, which know JPEG and PNG in all their kinds.
#include <algorithm>
#include <cmath>

#include <vtkImageData.h>
#include <vtkImageFlip.h>
#include <vtkImageReader2.h>
#include <vtkJPEGReader.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPNGReader.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_file.hpp"

namespace sanatrix::io {
namespace {

constexpr int largest_side = 16384;

vtkSmartPointer<vtkImageReader2> reader_of(const std::filesystem::path& file) {
  const std::string start = read_text(file).substr(0, 8);
  if (start.starts_with("\x89PNG")) {
    return vtkSmartPointer<vtkPNGReader>::New();
  }
  if (start.starts_with("\xff\xd8")) {
    return vtkSmartPointer<vtkJPEGReader>::New();
  }
  throw Error(Fault::Input,
              fmt::format("{}: this photograph is neither JPEG nor PNG", file.filename().string()),
              "export the scan with JPEG or PNG photographs");
}

}  // namespace

Photograph read_photograph(const std::filesystem::path& file) {
  // VTK reports problems on stderr on its own; the error code says enough.
  vtkObject::GlobalWarningDisplayOff();
  const auto reader = reader_of(file);
  const std::string name = file.filename().string();
  reader->SetFileName(file.c_str());
  reader->UpdateInformation();
  const int* extent = reader->GetDataExtent();
  const int width = extent[1] + 1, height = extent[3] + 1;
  require(width > 0 && height > 0 && width <= largest_side && height <= largest_side,
          "{}: a photograph of {} x {} pixels; at most {} a side can be used", name, width, height,
          largest_side);
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  const int channels = image.GetNumberOfScalarComponents();
  require(reader->GetErrorCode() == 0 && image.GetPointData()->GetScalars() != nullptr &&
              image.GetNumberOfPoints() == static_cast<vtkIdType>(width) * height,
          "{}: this photograph is damaged", name);
  Photograph photograph{width, height, {}};
  photograph.rgb.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const double scale = image.GetScalarType() == VTK_UNSIGNED_SHORT ? 1.0 / 257 : 1.0;
  vtkDataArray& scalars = *image.GetPointData()->GetScalars();
  for (int row = height - 1; row >= 0; --row) {
    for (int column = 0; column < width; ++column) {
      const vtkIdType pixel = static_cast<vtkIdType>(row) * width + column;
      for (int k = 0; k < 3; ++k) {
        const double value = scalars.GetComponent(pixel, channels >= 3 ? k : 0);
        photograph.rgb.push_back(static_cast<unsigned char>(std::lround(scale * value)));
      }
    }
  }
  return photograph;
}

std::string jpeg_bytes(const Photograph& photograph, int quality) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(photograph.width, photograph.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row = 3 * static_cast<std::size_t>(photograph.width);
  auto* pixels = static_cast<unsigned char*>(image->GetScalarPointer());
  for (std::size_t y = 0; y < static_cast<std::size_t>(photograph.height); ++y) {
    std::copy_n(photograph.rgb.data() + y * row, row,
                pixels + (static_cast<std::size_t>(photograph.height) - 1 - y) * row);
  }
  vtkNew<vtkJPEGWriter> writer;
  writer->SetInputData(image);
  writer->SetQuality(quality);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray& bytes = *writer->GetResult();
  return {reinterpret_cast<const char*>(bytes.GetPointer(0)),
          static_cast<std::size_t>(bytes.GetNumberOfValues())};
}

}  // namespace sanatrix::io
