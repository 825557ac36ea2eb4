// Line charts: how wound volume or density goes with time.
#include <algorithm>
#include <array>

#include <vtkAxis.h>
#include <vtkBoundingBox.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include "core/error.hpp"
#include "render/colours.hpp"
#include "render/png.hpp"
#include "render/render.hpp"

namespace sanatrix::render {
namespace {

constexpr int width = 900, height = 600, text_size = 18;

void label(vtkChartXY& chart, int which, const std::string& text) {
  vtkAxis& axis = *chart.GetAxis(which);
  axis.SetTitle(text);
  axis.GetTitleProperties()->SetFontSize(text_size);
  axis.GetTitleProperties()->SetBold(0);
  axis.GetLabelProperties()->SetFontSize(text_size - 2);
  axis.GetGridPen()->SetColor(225, 225, 225);
}

void add_curve(vtkChartXY& chart, const Curve& curve, std::size_t number) {
  ensure(curve.x.size() == curve.y.size() && !curve.x.empty(), "curve '{}' has {} x and {} y",
         curve.name, curve.x.size(), curve.y.size());
  vtkNew<vtkDoubleArray> x, y;
  x->SetName("x");
  y->SetName(curve.name.c_str());
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    x->InsertNextValue(curve.x[i]);
    y->InsertNextValue(curve.y[i]);
  }
  vtkNew<vtkTable> table;
  table->AddColumn(x);
  table->AddColumn(y);
  vtkPlot& line = *chart.AddPlot(vtkChart::LINE);
  line.SetInputData(table, 0, 1);
  const Colour colour = line_colour(number);
  line.SetColor(colour[0], colour[1], colour[2]);
  line.SetWidth(2.5F);
}

/// Puts the legend into the corner that the fewest points of the curves reach.
void place_legend(vtkChartXY& chart, const std::vector<Curve>& curves) {
  vtkBoundingBox box;
  for (const Curve& curve : curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      box.AddPoint(curve.x[i], curve.y[i], 0.0);
    }
  }
  std::array<int, 4> crowd{};  // right top, left top, right bottom, left bottom
  for (const Curve& curve : curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      const double across = (curve.x[i] - box.GetBound(0)) / std::max(box.GetLength(0), 1e-300);
      const double along = (curve.y[i] - box.GetBound(2)) / std::max(box.GetLength(1), 1e-300);
      ++crowd[(across < 0.5 ? 1 : 0) + (along < 0.5 ? 2U : 0U)];
    }
  }
  const auto corner = std::min_element(crowd.begin(), crowd.end()) - crowd.begin();
  chart.GetLegend()->SetHorizontalAlignment(corner % 2 == 0 ? vtkChartLegend::RIGHT
                                                            : vtkChartLegend::LEFT);
  chart.GetLegend()->SetVerticalAlignment(corner < 2 ? vtkChartLegend::TOP
                                                     : vtkChartLegend::BOTTOM);
}

}  // namespace

void write_plot(const std::vector<Curve>& curves, const std::string& title,
                const std::string& x_label, const std::string& y_label,
                const std::filesystem::path& file) {
  vtkNew<vtkChartXY> chart;
  chart->SetTitle(title);
  chart->GetTitleProperties()->SetFontSize(text_size + 4);
  chart->GetTitleProperties()->SetBold(1);
  chart->SetShowLegend(curves.size() > 1);
  chart->GetLegend()->SetLabelSize(text_size - 2);
  chart->GetLegend()->SetPadding(8);
  label(*chart, vtkAxis::BOTTOM, x_label);
  label(*chart, vtkAxis::LEFT, y_label);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    add_curve(*chart, curves[i], i);
  }
  place_legend(*chart, curves);
  vtkNew<vtkContextView> view;
  view->GetRenderer()->SetBackground(1, 1, 1);
  view->GetRenderWindow()->SetOffScreenRendering(1);
  view->GetRenderWindow()->SetMultiSamples(0);
  view->GetRenderWindow()->SetSize(width, height);
  view->GetScene()->AddItem(chart);
  view->GetRenderWindow()->Render();  // a chart finds its margins while it is drawn
  write_png(*view->GetRenderWindow(), file);
}

}  // namespace sanatrix::render
