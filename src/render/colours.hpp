// Colour maps that keep their meaning in grey and for colour-blind readers.
#pragma once

#include <array>

#include <vtkSmartPointer.h>

class vtkLookupTable;

namespace sanatrix::render {

using Colour = std::array<double, 3>;

enum class Map { Sequential, Diverging };

/// Viridis, or blue-white-red with white in the middle of the range; grey where there is no value.
vtkSmartPointer<vtkLookupTable> lookup_table(Map map, double low, double high);

/// The i-th of seven well separated line colours.
Colour line_colour(std::size_t i);

}  // namespace sanatrix::render
