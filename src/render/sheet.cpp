// How a sheet is laid out, annotated and drawn.
#include "render/sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <vtkActor2D.h>
#include <vtkBoundingBox.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCoordinate.h>
#include <vtkLight.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include "core/error.hpp"
#include "render/png.hpp"

namespace sanatrix::render {
namespace {

constexpr double legend_share = 0.16;  // of a panel's height, for the colour bar
// Part of a panel that the scene may fill, and how far its middle is below the panel's; the rest is
// for the title, letters and words.
constexpr double usable_width = 0.88, usable_height = 0.74, lowered = 0.045;

enum class Align { Low, Middle, High };

struct Place {
  double x, y;  ///< 0..1 of the panel
  Align across, along;
};

void add_text(vtkRenderer& renderer, const std::string& text, const Place& place, int size,
              bool bold = false) {
  vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  vtkTextProperty& style = *actor->GetTextProperty();
  style.SetFontFamilyToArial();
  style.SetFontSize(size);
  style.SetBold(bold);
  style.SetColor(0.1, 0.1, 0.1);
  // VTK numbers both left, centred, right and bottom, centred, top from 0 to 2.
  style.SetJustification(static_cast<int>(place.across));
  style.SetVerticalJustification(static_cast<int>(place.along));
  actor->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  actor->SetPosition(place.x, place.y);
  renderer.AddViewProp(actor);
}

void add_orientation(vtkRenderer& scene, const Viewpoint& view, int size) {
  const Vec3 right = to_the_right(view);
  const Vec3 left = -1.0 * right, down = -1.0 * view.up;
  const int large = size * 5 / 4;
  const auto letter = [&](const Vec3& direction, const Place& place) {
    add_text(scene, orientation_letters(direction), place, large, true);
  };
  letter(left, {0.015, 0.5 - lowered, Align::Low, Align::Middle});
  letter(right, {0.985, 0.5 - lowered, Align::High, Align::Middle});
  letter(view.up, {0.5, 0.90, Align::Middle, Align::High});
  letter(down, {0.5, 0.015, Align::Middle, Align::Low});
  // With the patient's left-right axis in the picture both sides have words; seen from the side one
  // sentence says which.
  constexpr double in_the_picture = 0.6;
  if (std::abs(right[0]) > in_the_picture) {
    add_text(scene, side_in_words(left), {0.015, 0.90, Align::Low, Align::High}, size, true);
    add_text(scene, side_in_words(right), {0.985, 0.90, Align::High, Align::High}, size, true);
  } else {
    add_text(scene, "seen from the " + side_in_words(view.towards_viewer),
             {0.985, 0.02, Align::High, Align::Low}, size, true);
  }
}

void add_bar(vtkRenderer& legend, const std::string& title, vtkLookupTable& colours, int size) {
  vtkNew<vtkScalarBarActor> bar;
  bar->SetLookupTable(&colours);
  bar->SetOrientationToHorizontal();
  bar->SetNumberOfLabels(5);
  // vtkScalarBarActor takes printf formats only.
  bar->SetLabelFormat("%.3g");
  bar->UnconstrainedFontSizeOn();
  bar->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  bar->SetPosition(0.15, 0.10);
  bar->SetWidth(0.7);
  bar->SetHeight(0.58);
  bar->SetBarRatio(0.45);
  bar->GetLabelTextProperty()->SetFontFamilyToArial();
  bar->GetLabelTextProperty()->SetFontSize(size);
  bar->GetLabelTextProperty()->SetColor(0.1, 0.1, 0.1);
  bar->GetLabelTextProperty()->SetShadow(0);
  bar->GetLabelTextProperty()->SetItalic(0);
  bar->GetLabelTextProperty()->SetBold(0);
  legend.AddViewProp(bar);
  add_text(legend, title, {0.5, 0.97, Align::Middle, Align::High}, size);
}

/// A light above the viewer's left shoulder, so that the shape of the breast shows.
void add_light(vtkRenderer& scene) {
  vtkNew<vtkLight> key;
  key->SetLightTypeToCameraLight();
  key->SetPosition(-0.6, 0.9, 1.0);
  key->SetIntensity(0.75);
  scene.AddLight(key);
  vtkNew<vtkLight> fill;
  fill->SetLightTypeToHeadlight();
  fill->SetIntensity(0.35);
  scene.AddLight(fill);
}

vtkSmartPointer<vtkRenderer> add_renderer(vtkRenderWindow& window, double x0, double y0, double x1,
                                          double y1) {
  auto renderer = vtkSmartPointer<vtkRenderer>::New();
  renderer->SetViewport(x0, y0, x1, y1);
  renderer->SetBackground(1, 1, 1);
  window.AddRenderer(renderer);
  return renderer;
}

}  // namespace

Sheet::Sheet(std::size_t panels, int columns, int width, int height, bool with_bars,
             Overlap overlap)
    : scene_width_(width),
      scene_height_(static_cast<int>(height * (with_bars ? 1 - legend_share : 1.0))),
      font_size_(std::max(13, height / 34)),
      window_(vtkSmartPointer<vtkRenderWindow>::New()) {
  ensure(panels > 0 && columns > 0, "a picture of {} panels in {} columns", panels, columns);
  const int rows = (static_cast<int>(panels) + columns - 1) / columns;
  window_->SetOffScreenRendering(1);
  window_->SetMultiSamples(0);  // depth peeling of translucent surfaces needs it
  window_->SetAlphaBitPlanes(1);
  window_->SetSize(columns * width, rows * height);
  for (int i = 0; i < static_cast<int>(panels); ++i) {
    const int column = i % columns, row = i / columns;
    const double x0 = static_cast<double>(column) / columns;
    const double x1 = static_cast<double>(column + 1) / columns;
    const double y1 = 1.0 - static_cast<double>(row) / rows;
    const double y0 = y1 - 1.0 / rows;
    const double split = with_bars ? y0 + legend_share / rows : y0;
    PanelView panel;
    panel.scene = add_renderer(*window_, x0, split, x1, y1);
    panel.scene->SetUseDepthPeeling(overlap == Overlap::Sorted);
    panel.scene->SetMaximumNumberOfPeels(4);  // front and back of a skin around something
    panel.scene->SetUseFXAA(true);
    add_light(*panel.scene);
    if (with_bars) {
      panel.legend = add_renderer(*window_, x0, y0, x1, split);
    }
    panels_.push_back(std::move(panel));
  }
}

Sheet::~Sheet() = default;

void Sheet::describe(std::size_t panel, const Viewpoint& viewpoint, const PanelText& text,
                     vtkLookupTable& colours) {
  PanelView& view = panels_[panel];
  view.viewpoint = viewpoint;
  add_orientation(*view.scene, viewpoint, font_size_);
  add_text(*view.scene, text.title, {0.5, 0.985, Align::Middle, Align::High}, font_size_ * 5 / 4,
           true);
  if (view.legend && !text.bar_title.empty()) {
    add_bar(*view.legend, text.bar_title, colours, font_size_);
  }
}

void Sheet::point_cameras() {
  vtkBoundingBox box;
  for (const PanelView& panel : panels_) {
    std::array<double, 6> bounds;
    panel.scene->ComputeVisiblePropBounds(bounds.data());
    box.AddBounds(bounds.data());
  }
  require(box.IsValid(), "a picture without anything to show");
  Vec3 centre, lengths;
  box.GetCenter(centre.data());
  box.GetLengths(lengths.data());
  double half_height = 0;
  const auto half_extent = [&](const Vec3& direction) {
    return 0.5 * (std::abs(direction[0]) * lengths[0] + std::abs(direction[1]) * lengths[1] +
                  std::abs(direction[2]) * lengths[2]);
  };
  const double aspect = static_cast<double>(scene_width_) / scene_height_;
  for (const PanelView& panel : panels_) {
    half_height = std::max({half_height, half_extent(panel.viewpoint.up) / usable_height,
                            half_extent(to_the_right(panel.viewpoint)) / (usable_width * aspect)});
  }
  for (const PanelView& panel : panels_) {
    vtkCamera& camera = *panel.scene->GetActiveCamera();
    const Vec3 middle = centre + (2 * lowered * half_height) * panel.viewpoint.up;
    const Vec3 eye = middle + box.GetDiagonalLength() * panel.viewpoint.towards_viewer;
    camera.ParallelProjectionOn();
    camera.SetFocalPoint(middle.data());
    camera.SetPosition(eye.data());
    camera.SetViewUp(panel.viewpoint.up.data());
    camera.SetParallelScale(half_height);
    panel.scene->ResetCameraClippingRange();
    add_scale(*panel.scene, half_height);
  }
}

void Sheet::add_scale(vtkRenderer& scene, double half_height) const {
  const double width = 2 * half_height * scene_width_ / scene_height_;  // of the panel [m]
  double length = 0.001;
  for (const double candidate : {0.002, 0.005, 0.01, 0.02, 0.05, 0.1}) {
    length = candidate < 0.25 * width ? candidate : length;
  }
  const double x0 = 0.02, x1 = x0 + length / width, y = 0.025;
  vtkNew<vtkPoints> points;
  for (const auto& [x, height] : {std::pair{x0, y + 0.012}, {x0, y}, {x1, y}, {x1, y + 0.012}}) {
    points->InsertNextPoint(x, height, 0);
  }
  vtkNew<vtkCellArray> lines;
  lines->InsertNextCell({0, 1, 2, 3});
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(lines);
  vtkNew<vtkCoordinate> coordinate;
  coordinate->SetCoordinateSystemToNormalizedViewport();
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(data);
  mapper->SetTransformCoordinate(coordinate);
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.1, 0.1, 0.1);
  actor->GetProperty()->SetLineWidth(2);
  scene.AddViewProp(actor);
  add_text(scene, fmt::format("{:g} mm", 1e3 * length),
           {0.5 * (x0 + x1), y + 0.02, Align::Middle, Align::Low}, font_size_);
}

void Sheet::save(const std::filesystem::path& file) {
  point_cameras();
  write_png(*window_, file);
}

}  // namespace sanatrix::render
