// What comes into a case, made anonymous on the way: images without headers, plans without words.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/image.hpp"

namespace sanatrix::pipeline {

/// An image as it is taken in, and what is known about it. No member can hold an identity.
struct GivenImage {
  Image3<float> image;
  std::string facts;  ///< JSON: modality, geometry, what was left behind, warnings
};

/// A DICOM folder or file (`series`: 0 chooses, else a number of `sanatrix inspect`), NIfTI, NRRD
/// or MetaImage. Error{Input} when it cannot be read or no series fits.
GivenImage read_given_image(const std::filesystem::path& path, int series);

/// What `sanatrix inspect` prints, for any of these and for label volumes; as JSON text.
std::string inspect_image(const std::filesystem::path& path, int series);

/// A plan (JSON) without anything that may identify: keys that name a person, a place, a date or a
/// note are dropped, and so are texts that are more than one coded word. Numbers stay.
std::string anonymous_plan(const std::string& json_text);

}  // namespace sanatrix::pipeline
