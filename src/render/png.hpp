// Draws a window and writes its pixels.
#pragma once

#include <filesystem>

class vtkRenderWindow;

namespace sanatrix::render {

/// Written aside and renamed.
void write_png(vtkRenderWindow& window, const std::filesystem::path& file);

}  // namespace sanatrix::render
