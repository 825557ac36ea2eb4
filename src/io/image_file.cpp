// Images through ITK's NIfTI, NRRD and MetaImage readers, named explicitly so that no other format
// is ever tried.
#include "io/image_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkImportImageFilter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/image_checks.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

/// What ITK says, without the object that says it: "Reason" of "ITK ERROR: Image(0x5641): Reason".
std::string reason_of(const itk::ExceptionObject& e) {
  std::string text = e.GetDescription();
  for (const std::string_view mark : {"ERROR: ", "): "}) {
    if (const std::size_t at = text.find(mark); at != std::string::npos) {
      text.erase(0, at + mark.size());
    }
  }
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// ITK's exceptions as ours, on one line that names the file.
template <class F>
auto with_itk(Fault fault, const fs::path& file, const char* activity, F&& work) {
  try {
    return work();
  } catch (const itk::ExceptionObject& e) {
    throw Error(fault, fmt::format("cannot {} {}: {}", activity, file.string(), reason_of(e)),
                fault == Fault::Input ? "check its header, or export the image again" : "");
  }
}

itk::ImageIOBase::Pointer io_for(const fs::path& file, Fault fault) {
  std::string name = file.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name.ends_with(".nii.gz") || name.ends_with(".nii")) {
    return itk::NiftiImageIO::New().GetPointer();
  }
  if (name.ends_with(".nrrd")) {
    return itk::NrrdImageIO::New().GetPointer();
  }
  if (name.ends_with(".mha")) {
    return itk::MetaImageIO::New().GetPointer();
  }
  throw Error(fault, fmt::format("{} is not named as an image", file.string()),
              "images are NIfTI (.nii.gz, .nii), NRRD (.nrrd) or MetaImage (.mha)");
}

void require_scalar_volume(const itk::ImageIOBase& io, const fs::path& file) {
  const unsigned dimensions = io.GetNumberOfDimensions();
  bool volume = dimensions >= 3;
  for (unsigned d = 3; d < dimensions; ++d) {
    volume = volume && io.GetDimensions(d) == 1;
  }
  require(volume, "{} is not a 3-D image: it has {} dimensions", file.string(), dimensions);
  require(io.GetNumberOfComponents() == 1, "{} has {} values per voxel; one is needed",
          file.string(), io.GetNumberOfComponents());
}

template <class T>
Image3<T> from_itk(const itk::Image<T, 3>& image) {
  Image3<T> result;
  for (unsigned i = 0; i < 3; ++i) {
    result.size[i] = static_cast<int>(image.GetLargestPossibleRegion().GetSize()[i]);
    result.spacing_mm[i] = image.GetSpacing()[i];
    result.origin_mm[i] = image.GetOrigin()[i];
    for (unsigned j = 0; j < 3; ++j) {
      result.direction[i][j] = image.GetDirection()[i][j];
    }
  }
  const std::size_t count = image.GetLargestPossibleRegion().GetNumberOfPixels();
  result.voxels.assign(image.GetBufferPointer(), image.GetBufferPointer() + count);
  return result;
}

/// A view of our voxels as an ITK image; the voxels stay ours.
template <class T>
typename itk::ImportImageFilter<T, 3>::Pointer as_itk(const Image3<T>& image) {
  auto filter = itk::ImportImageFilter<T, 3>::New();
  itk::Size<3> size;
  itk::Matrix<double, 3, 3> direction;
  for (unsigned i = 0; i < 3; ++i) {
    size[i] = static_cast<itk::SizeValueType>(image.size[i]);
    for (unsigned j = 0; j < 3; ++j) {
      direction[i][j] = image.direction[i][j];
    }
  }
  filter->SetRegion(itk::ImageRegion<3>(size));
  filter->SetSpacing(image.spacing_mm.data());
  filter->SetOrigin(image.origin_mm.data());
  filter->SetDirection(direction);
  filter->SetImportPointer(const_cast<T*>(image.voxels.data()), image.voxels.size(), false);
  return filter;
}

template <class T>
void write(const Image3<T>& image, const fs::path& file) {
  ensure(image.voxels.size() == image.index(0, 0, image.size[2]),
         "image for {} has {} voxels, not {}", file.string(), image.voxels.size(),
         image.index(0, 0, image.size[2]));
  const auto io = io_for(file, Fault::Usage);
  write_aside(file, [&](const fs::path& aside) {
    with_itk(Fault::Resource, file, "write", [&] {
      const auto source = as_itk(image);
      auto writer = itk::ImageFileWriter<itk::Image<T, 3>>::New();
      writer->SetImageIO(io);
      writer->SetFileName(aside.string());
      writer->SetInput(source->GetOutput());
      writer->SetUseCompression(true);
      writer->Update();
    });
    if (!is_complete(aside, image.voxels.size() * sizeof(T))) {
      throw Error(Fault::Resource, fmt::format("cannot write {} completely", file.string()),
                  "free some disk space and run again");
    }
  });
}

}  // namespace

Image3<float> read_image(const fs::path& file) {
  require(fs::is_regular_file(file), "image {} does not exist", file.string());
  return with_itk(Fault::Input, file, "read", [&] {
    const auto io = io_for(file, Fault::Input);
    require(io->CanReadFile(file.c_str()), "{} is not what its extension says", file.string());
    during(file.filename().string(), [&] { require_sound_header(file); });
    io->SetFileName(file.string());
    io->ReadImageInformation();
    require_scalar_volume(*io, file);
    require(is_complete(file, static_cast<std::uint64_t>(io->GetImageSizeInBytes())),
            "{} is cut off or damaged; copy it again", file.string());
    auto reader = itk::ImageFileReader<itk::Image<float, 3>>::New();
    reader->SetImageIO(io);
    reader->SetFileName(file.string());
    reader->Update();
    Image3<float> image = from_itk(*reader->GetOutput());
    during(file.filename().string(),
           [&] { require_sound_place(image.spacing_mm, image.origin_mm, image.direction); });
    for (const float value : image.voxels) {
      require(std::isfinite(value), "{} holds voxels that are not finite numbers", file.string());
    }
    return image;
  });
}

LabelImage read_labels(const fs::path& file) {
  const Image3<float> image = read_image(file);
  LabelImage labels{image.size, image.spacing_mm, image.origin_mm, image.direction, {}};
  labels.voxels.reserve(image.voxels.size());
  for (const float value : image.voxels) {
    require(value >= 0 && value <= 255 && value == std::floor(value),
            "{} is not a label image: it holds the value {}, labels are whole numbers 0..255",
            file.string(), value);
    labels.voxels.push_back(static_cast<unsigned char>(value));
  }
  return labels;
}

void write_labels(const LabelImage& image, const fs::path& file) {
  write(image, file);
}

void write_image(const Image3<float>& image, const fs::path& file) {
  // What scanners store are whole numbers: half the size, and several times faster to compress.
  const bool whole = std::ranges::all_of(
      image.voxels, [](float v) { return v >= -32768.0F && v <= 32767.0F && v == std::floor(v); });
  if (!whole) {
    write(image, file);
    return;
  }
  write(Image3<short>{image.size,
                      image.spacing_mm,
                      image.origin_mm,
                      image.direction,
                      {image.voxels.begin(), image.voxels.end()}},
        file);
}

}  // namespace sanatrix::io
