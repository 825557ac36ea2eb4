// Segmentations as 3D Slicer saves them: any label values, any order, layers that overlap, cropped
// to the segments. Only the names of the segments say what they are.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <itkImageFileReader.h>
#include <itkNrrdImageIO.h>
#include <itkVectorImage.h>

#include "core/error.hpp"
#include "io/image_checks.hpp"
#include "io/image_file.hpp"
#include "io/slicer_segmentation.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

struct Segment {
  std::string name;
  int value = 1, layer = 0;
  unsigned char label = 0;
};

/// The header's lines "key:=value"; empty when the file is no NRRD.
std::map<std::string, std::string> header_keys(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  std::map<std::string, std::string> keys;
  if (!std::getline(in, line) || !line.starts_with("NRRD")) {
    return keys;
  }
  while (std::getline(in, line) && !line.empty() && line != "\r") {
    if (line.back() == '\r') {
      line.pop_back();
    }
    if (const std::size_t at = line.find(":="); at != std::string::npos) {
      keys[line.substr(0, at)] = line.substr(at + 2);
    }
  }
  return keys;
}

/// Label of a tissue's name in the words of our own files and in those that readers use.
std::optional<unsigned char> label_of(const std::string& name) {
  std::string word;
  for (const char c : name) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  struct Word {
    std::string_view part;
    Label label;
  };
  // The first that the name contains: "tumour in fat" is a tumour, "fibroglandular" no fat.
  constexpr std::array words{Word{"tumour", Label::Tumour},
                             Word{"tumor", Label::Tumour},
                             Word{"lesion", Label::Tumour},
                             Word{"carcinoma", Label::Tumour},
                             Word{"nipple", Label::Nipple},
                             Word{"vessel", Label::Vessel},
                             Word{"gland", Label::Fibroglandular},
                             Word{"fgt", Label::Fibroglandular},
                             Word{"skin", Label::Skin},
                             Word{"adipose", Label::Adipose},
                             Word{"fat", Label::Adipose},
                             Word{"muscle", Label::Muscle},
                             Word{"pectoral", Label::Muscle},
                             Word{"chestwall", Label::Muscle},
                             Word{"bone", Label::Bone},
                             Word{"rib", Label::Bone},
                             Word{"sternum", Label::Bone},
                             Word{"lung", Label::Lung},
                             Word{"organ", Label::Organ},
                             Word{"heart", Label::Organ},
                             Word{"liver", Label::Organ},
                             Word{"air", Label::Air},
                             Word{"background", Label::Air}};
  for (const Word& w : words) {
    if (word.find(w.part) != std::string::npos) {
      return static_cast<unsigned char>(w.label);
    }
  }
  return std::nullopt;
}

std::vector<Segment> segments_of(const std::map<std::string, std::string>& keys) {
  std::vector<Segment> segments;
  const auto number = [&](const std::string& key, int otherwise) {
    const auto at = keys.find(key);
    int value = otherwise;
    require(at == keys.end() || std::sscanf(at->second.c_str(), "%d", &value) == 1,
            "{} is '{}', not a number", key, at == keys.end() ? "" : at->second);
    return value;
  };
  for (int n = 0;; ++n) {
    const std::string key = fmt::format("Segment{}_", n);
    const auto name = keys.find(key + "Name");
    if (name == keys.end()) {
      return segments;
    }
    const std::optional<unsigned char> label = label_of(name->second);
    if (!label) {
      throw Error(Fault::Input,
                  fmt::format("segment {} has a name that is no tissue: '{}'", n + 1, name->second),
                  "name it adipose, fibroglandular, skin, muscle, bone, lung, organ, tumour, "
                  "nipple or vessel; or delete it");
    }
    segments.push_back(
        {name->second, number(key + "LabelValue", 1), number(key + "Layer", 0), *label});
  }
}

/// Where segments overlap, the more special tissue holds.
int precedence(unsigned char label) {
  using enum Label;
  constexpr std::array order{Air,  Adipose, Organ,  Lung,  Muscle, Bone, Fibroglandular,
                             Skin, Vessel,  Nipple, Tumour};
  return static_cast<int>(std::ranges::find(order, static_cast<Label>(label)) - order.begin());
}

/// Slicer crops to the segments; room for air in front and beside keeps the skin a surface.
LabelImage with_border(const LabelImage& inner, int border) {
  LabelImage outer = inner;
  std::array<int, 3> before{};
  for (std::size_t a = 0; a < 3; ++a) {
    // Only towards anterior (-y): at its other sides the body may end at the field of view.
    const double towards_back = inner.direction[1][a];
    before[a] = towards_back > 0.7 ? border : 0;
    outer.size[a] += std::abs(towards_back) > 0.7 ? border : 0;
  }
  outer.origin_mm = inner.position_mm(-before[0], -before[1], -before[2]);
  outer.voxels.assign(outer.index(0, 0, outer.size[2]), 0);
  for (int k = 0; k < inner.size[2]; ++k) {
    for (int j = 0; j < inner.size[1]; ++j) {
      for (int i = 0; i < inner.size[0]; ++i) {
        outer.at(i + before[0], j + before[1], k + before[2]) = inner.at(i, j, k);
      }
    }
  }
  return outer;
}

LabelImage map_names(const fs::path& file, const std::vector<Segment>& segments) {
  using Layers = itk::VectorImage<short, 3>;
  require_sound_header(file);
  const auto io = itk::NrrdImageIO::New();
  auto reader = itk::ImageFileReader<Layers>::New();
  reader->SetImageIO(io);
  reader->SetFileName(file.string());
  try {
    reader->Update();
  } catch (const itk::ExceptionObject& e) {
    throw Error(Fault::Input, fmt::format("cannot be read: {}", e.GetDescription()));
  }
  const Layers& layers = *reader->GetOutput();
  const auto depth = static_cast<int>(layers.GetNumberOfComponentsPerPixel());
  LabelImage labels;
  for (unsigned i = 0; i < 3; ++i) {
    labels.size[i] = static_cast<int>(layers.GetLargestPossibleRegion().GetSize()[i]);
    labels.spacing_mm[i] = layers.GetSpacing()[i];
    labels.origin_mm[i] = layers.GetOrigin()[i];
    for (unsigned j = 0; j < 3; ++j) {
      labels.direction[i][j] = layers.GetDirection()[i][j];
    }
  }
  require_sound_place(labels.spacing_mm, labels.origin_mm, labels.direction);
  std::map<std::pair<int, int>, unsigned char> meaning;  // layer and value
  for (const Segment& s : segments) {
    require(s.layer >= 0 && s.layer < depth, "segment '{}' lies in layer {}, but the file has {}",
            s.name, s.layer, depth);
    meaning[{s.layer, s.value}] = s.label;
  }
  const std::size_t count = layers.GetLargestPossibleRegion().GetNumberOfPixels();
  labels.voxels.assign(count, 0);
  const short* value = layers.GetBufferPointer();
  for (std::size_t v = 0; v < count; ++v) {
    for (int layer = 0; layer < depth; ++layer, ++value) {
      if (*value == 0) {
        continue;
      }
      const auto found = meaning.find({layer, *value});
      require(found != meaning.end(), "value {} in layer {} belongs to no segment", *value, layer);
      if (precedence(found->second) > precedence(labels.voxels[v])) {
        labels.voxels[v] = found->second;
      }
    }
  }
  return with_border(labels, 10);
}

}  // namespace

std::optional<LabelImage> read_slicer_segmentation(const fs::path& file) {
  const std::map<std::string, std::string> keys = header_keys(file);
  if (!keys.contains("Segment0_Name")) {
    return std::nullopt;
  }
  return during(file.filename().string(), [&] { return map_names(file, segments_of(keys)); });
}

}  // namespace sanatrix::io
