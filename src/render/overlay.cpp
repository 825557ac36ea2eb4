#include "render/overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <vtkFreeTypeTools.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>

#include "core/files.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::render {
namespace {

using Colour = std::array<unsigned char, 3>;

constexpr int columns = 3, rows = 3, gap = 4;
constexpr Colour skin_colour{90, 220, 120}, gland_colour{255, 170, 40}, wall_colour{255, 70, 70},
    tumour_colour{255, 60, 255}, landmark_colour{90, 200, 255};

/// A picture with its origin at the top left.
class Canvas {
 public:
  Canvas(int width, int height) : width_(width), height_(height) {
    data_->SetDimensions(width, height, 1);
    data_->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    std::fill_n(static_cast<unsigned char*>(data_->GetScalarPointer()), 3L * width * height,
                static_cast<unsigned char>(16));
  }
  void set(int x, int y, const Colour& colour) {
    if (x >= 0 && y >= 0 && x < width_ && y < height_) {
      std::ranges::copy(
          colour, static_cast<unsigned char*>(data_->GetScalarPointer(x, height_ - 1 - y, 0)));
    }
  }
  void cross(int x, int y, const Colour& colour) {
    for (int d = -4; d <= 4; ++d) {
      set(x + d, y, colour);
      set(x, y + d, colour);
    }
  }
  void write_text(int x, int y, const std::string& text) {
    vtkNew<vtkTextProperty> style;
    style->SetFontSize(14);
    style->SetColor(1, 1, 1);
    vtkNew<vtkImageData> drawn;
    std::array<int, 2> size{};
    if (!vtkFreeTypeTools::GetInstance()->RenderString(style.Get(), vtkStdString(text), 72,
                                                       drawn.Get(), size.data())) {
      return;
    }
    std::array<int, 6> e{};
    drawn->GetExtent(e.data());
    for (int b = e[2]; b <= e[3]; ++b) {
      for (int a = e[0]; a <= e[1]; ++a) {
        const auto* p = static_cast<unsigned char*>(drawn->GetScalarPointer(a, b, 0));
        if (p[3] > 100) {
          set(x + a - e[0], y + e[3] - b, {p[0], p[1], p[2]});
        }
      }
    }
  }
  void save(const std::filesystem::path& file) {
    write_aside(file, [&](const std::filesystem::path& aside) {
      vtkNew<vtkPNGWriter> writer;
      writer->SetFileName(aside.c_str());
      writer->SetInputData(data_);
      writer->Write();
    });
  }

 private:
  int width_, height_;
  vtkNew<vtkImageData> data_;
};

/// Groups of labels between which a line is drawn.
int group(unsigned char label) {
  return label == 0                                                   ? 0
         : is_wall(label)                                             ? 3
         : label == static_cast<unsigned char>(Label::Tumour)         ? 4
         : label == static_cast<unsigned char>(Label::Fibroglandular) ? 2
                                                                      : 1;
}

const Colour* outline(int a, int b) {
  if (a == b) {
    return nullptr;
  }
  const auto either = [&](int g) {
    return a == g || b == g;
  };
  return either(4)   ? &tumour_colour
         : either(0) ? &skin_colour
         : either(3) ? &wall_colour
                     : &gland_colour;
}

/// One axial slice with its top left at x, y.
void draw_slice(const Image3<float>& image, double white, const LabelImage& labels, int k, int x,
                int y, Canvas& canvas) {
  const auto [nx, ny, nz] = labels.size;
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const double value = sample(image, labels.position_mm(i, j, k));
      const auto grey =
          static_cast<unsigned char>(255.0 * std::pow(std::clamp(value / white, 0.0, 1.0), 0.7));
      const int here = group(labels.at(i, j, k));
      const Colour* line = nullptr;
      if (i + 1 < nx) {
        line = outline(here, group(labels.at(i + 1, j, k)));
      }
      if (line == nullptr && j + 1 < ny) {
        line = outline(here, group(labels.at(i, j + 1, k)));
      }
      canvas.set(x + i, y + j, line != nullptr ? *line : Colour{grey, grey, grey});
    }
  }
  canvas.write_text(x + 4, y + ny / 2, "R");
  canvas.write_text(x + nx - 16, y + ny / 2, "L");
  canvas.write_text(x + nx / 2, y + 4, "A");
  canvas.write_text(x + nx / 2, y + ny - 20, "P");
  canvas.write_text(x + 4, y + 4, fmt::format("z {:.0f} mm", labels.position_mm(0, 0, k)[2]));
}

}  // namespace

void write_overlay(const Image3<float>& image, const LabelImage& labels,
                   std::span<const Vec3> landmarks_mm, const std::filesystem::path& file) {
  std::vector<float> sorted = image.voxels;
  const auto bright = sorted.begin() + static_cast<long>(0.99 * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), bright, sorted.end());
  const double white = std::max(1.0, static_cast<double>(*bright));
  const auto [nx, ny, nz] = labels.size;
  Canvas canvas(columns * (nx + gap), rows * (ny + gap));
  constexpr int panels = columns * rows;
  const auto x_of = [nx](int panel) {
    return panel % columns * (nx + gap);
  };
  const auto y_of = [ny](int panel) {
    return panel / columns * (ny + gap);
  };
  for (int panel = 0; panel < panels; ++panel) {
    draw_slice(image, white, labels, (panel + 1) * nz / (panels + 1), x_of(panel), y_of(panel),
               canvas);
  }
  for (const Vec3& mark : landmarks_mm) {
    const Vec3 at = labels.continuous_index(mark);
    const auto nearest = static_cast<int>(std::lround(at[2] * (panels + 1) / nz)) - 1;
    const int panel = std::clamp(nearest, 0, panels - 1);
    canvas.cross(x_of(panel) + static_cast<int>(std::lround(at[0])),
                 y_of(panel) + static_cast<int>(std::lround(at[1])), landmark_colour);
  }
  canvas.save(file);
}

}  // namespace sanatrix::render
