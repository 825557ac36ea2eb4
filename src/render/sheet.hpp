// A picture in the making: panels in a grid with titles, orientation letters, the patient's side in
// words, a length scale and a colour bar. All panels show the same region at the same scale.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <vtkSmartPointer.h>

#include "render/viewpoint.hpp"

class vtkLookupTable;
class vtkRenderer;
class vtkRenderWindow;

namespace sanatrix::render {

struct PanelText {
  std::string title;
  std::string bar_title;  ///< empty: no colour bar
};

/// Translucent surfaces behind each other: sorted by depth, which draws the scene several times, or
/// drawn as they come, which is right when at most one of them lies in front of everything else.
enum class Overlap { Sorted, AsTheyCome };

class Sheet {
 public:
  /// Width and height of one panel in pixels.
  Sheet(std::size_t panels, int columns, int width, int height, bool with_bars, Overlap overlap);
  ~Sheet();
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  /// Add props to this, in metres.
  [[nodiscard]] vtkRenderer& scene(std::size_t panel) { return *panels_[panel].scene; }
  void describe(std::size_t panel, const Viewpoint& viewpoint, const PanelText& text,
                vtkLookupTable& colours);
  /// Points the cameras, draws and writes a PNG; aside and renamed.
  void save(const std::filesystem::path& file);

 private:
  struct PanelView {
    vtkSmartPointer<vtkRenderer> scene;
    vtkSmartPointer<vtkRenderer> legend;  ///< null: no colour bars on this sheet
    Viewpoint viewpoint{{0, -1, 0}, {0, 0, 1}};
  };
  void point_cameras();
  void add_scale(vtkRenderer& scene, double half_height) const;

  int scene_width_, scene_height_, font_size_;
  vtkSmartPointer<vtkRenderWindow> window_;
  std::vector<PanelView> panels_;
};

}  // namespace sanatrix::render
