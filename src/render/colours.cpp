// Viridis and blue-white-red as VTK tables.
#include "render/colours.hpp"

#include <cmath>
#include <vector>

#include <vtkLookupTable.h>
#include <vtkMath.h>

namespace sanatrix::render {
namespace {

Colour rgb(int hexadecimal) {
  return {(hexadecimal >> 16) / 255.0, ((hexadecimal >> 8) & 255) / 255.0,
          (hexadecimal & 255) / 255.0};
}

/// Equidistant knots. Viridis: S. van der Walt and N. Smith, CC0.
std::vector<Colour> knots(Map map) {
  const std::vector<int> viridis{0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e,
                                 0x1f9e89, 0x35b779, 0x6dcd59, 0xb4de2c, 0xfde725};
  const std::vector<int> blue_white_red{0x2040a0, 0x6f93d6, 0xf4f4f4, 0xe08a76, 0xa01820};
  std::vector<Colour> colours;
  for (const int value : map == Map::Sequential ? viridis : blue_white_red) {
    colours.push_back(rgb(value));
  }
  return colours;
}

/// Between two colours along a straight line in CIE Lab, where equal steps look equal.
Colour between(const Colour& a, const Colour& b, double t) {
  Colour lab_a, lab_b, mixed, result;
  vtkMath::RGBToLab(a.data(), lab_a.data());
  vtkMath::RGBToLab(b.data(), lab_b.data());
  for (std::size_t i = 0; i < 3; ++i) {
    mixed[i] = (1 - t) * lab_a[i] + t * lab_b[i];
  }
  vtkMath::LabToRGB(mixed.data(), result.data());
  return result;
}

}  // namespace

vtkSmartPointer<vtkLookupTable> lookup_table(Map map, double low, double high) {
  constexpr int size = 256;
  const std::vector<Colour> colours = knots(map);
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  table->SetNumberOfTableValues(size);
  table->SetTableRange(low, high > low ? high : low + 1.0);
  for (int i = 0; i < size; ++i) {
    const double at = static_cast<double>(i) / (size - 1) * static_cast<double>(colours.size() - 1);
    const auto knot = std::min(static_cast<std::size_t>(at), colours.size() - 2);
    const Colour c = between(colours[knot], colours[knot + 1], at - static_cast<double>(knot));
    table->SetTableValue(i, c[0], c[1], c[2]);
  }
  table->SetNanColor(0.6, 0.6, 0.6, 1.0);
  return table;
}

Colour line_colour(std::size_t i) {
  // M. Okabe and K. Ito, Color Universal Design (2008), without yellow, which is lost on white.
  constexpr std::array<int, 7> palette{0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7,
                                       0x000000, 0xe69f00, 0x56b4e9};
  return rgb(palette[i % palette.size()]);
}

}  // namespace sanatrix::render
