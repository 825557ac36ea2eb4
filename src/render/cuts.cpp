// A tetrahedral mesh cut open: the cut face in colours, the half behind it translucent.
#include <algorithm>

#include <vtkActor.h>
#include <vtkBox.h>
#include <vtkCellArray.h>
#include <vtkClipPolyData.h>
#include <vtkCutter.h>
#include <vtkDoubleArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "core/error.hpp"
#include "render/colours.hpp"
#include "render/render.hpp"
#include "render/sheet.hpp"

namespace sanatrix::render {
namespace {

vtkNew<vtkUnstructuredGrid> grid_of(const CutPanel& panel) {
  ensure(panel.mesh != nullptr && panel.points.size() == panel.mesh->points.size() &&
             panel.scalar.size() == panel.points.size(),
         "a cut needs a position and a value for every vertex");
  vtkNew<vtkPoints> points;
  vtkNew<vtkDoubleArray> scalars;
  for (std::size_t i = 0; i < panel.points.size(); ++i) {
    points->InsertNextPoint(panel.points[i].data());
    scalars->InsertNextValue(panel.scalar[i]);
  }
  vtkNew<vtkCellArray> cells;
  for (const auto& [a, b, c, d] : panel.mesh->cells) {
    cells->InsertNextCell({a, b, c, d});
  }
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->SetScalars(scalars);
  return grid;
}

/// What lies within the panel's window.
vtkSmartPointer<vtkPolyData> within(vtkPolyData* data, const CutPanel& panel) {
  if (panel.window_m <= 0) {
    return data;
  }
  const Vec3 reach{panel.window_m, panel.window_m, panel.window_m};
  const Vec3 low = panel.plane_point - reach, high = panel.plane_point + reach;
  vtkNew<vtkBox> box;
  box->SetXMin(low[0], low[1], low[2]);
  box->SetXMax(high[0], high[1], high[2]);
  vtkNew<vtkClipPolyData> inside;
  inside->SetInputData(data);
  inside->SetClipFunction(box);
  inside->InsideOutOn();
  inside->Update();
  return inside->GetOutput();
}

void add_cut_face(vtkRenderer& scene, const CutPanel& panel, vtkPlane& plane,
                  vtkLookupTable& colours) {
  const auto grid = grid_of(panel);
  vtkNew<vtkCutter> cutter;
  cutter->SetInputData(grid);
  cutter->SetCutFunction(&plane);
  cutter->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(within(cutter->GetOutput(), panel));
  mapper->SetLookupTable(&colours);
  mapper->UseLookupTableScalarRangeOn();
  mapper->InterpolateScalarsBeforeMappingOn();
  vtkNew<vtkActor> prop;
  prop->SetMapper(mapper);
  prop->GetProperty()->LightingOff();  // the colours are numbers
  scene.AddActor(prop);
}

/// The boundary of the mesh behind the cut. Panels of the same moment share it.
class Rest {
 public:
  explicit Rest(const CutPanel& panel, vtkPlane& plane)
      : panel_(&panel), surface_{panel.points, boundary_of(*panel.mesh)} {
    vtkNew<vtkPoints> points;
    vtkNew<vtkDoubleArray> normals;
    normals->SetNumberOfComponents(3);
    for (const Vec3& p : surface_.points) {
      points->InsertNextPoint(p.data());
    }
    for (const Vec3& n : vertex_normals(surface_)) {
      normals->InsertNextTuple(n.data());
    }
    vtkNew<vtkCellArray> triangles;
    for (const auto& [a, b, c] : surface_.triangles) {
      triangles->InsertNextCell({a, b, c});
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(triangles);
    data->GetPointData()->SetNormals(normals);
    vtkNew<vtkClipPolyData> behind;
    behind->SetInputData(data);
    behind->SetClipFunction(&plane);
    behind->InsideOutOn();  // the plane's normal points to the viewer
    behind->Update();
    clipped_ = within(behind->GetOutput(), panel);
  }
  [[nodiscard]] bool serves(const CutPanel& panel) const {
    return panel.mesh == panel_->mesh && panel.plane_point == panel_->plane_point &&
           panel.plane_normal == panel_->plane_normal && panel.window_m == panel_->window_m &&
           panel.points == panel_->points;
  }
  void add_to(vtkRenderer& scene) const {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(clipped_);
    vtkNew<vtkActor> prop;
    prop->SetMapper(mapper);
    prop->GetProperty()->SetColor(0.83, 0.66, 0.56);
    prop->GetProperty()->SetOpacity(0.3);
    prop->GetProperty()->FrontfaceCullingOn();  // what is behind the cut is seen from inside
    scene.AddActor(prop);
  }

 private:
  const CutPanel* panel_;
  TriMesh surface_;
  vtkSmartPointer<vtkPolyData> clipped_;
};

}  // namespace

void write_cuts(const std::vector<CutPanel>& panels, int columns, const std::filesystem::path& file,
                int panel_width, int panel_height) {
  const bool with_bars = std::any_of(panels.begin(), panels.end(),
                                     [](const CutPanel& p) { return !p.bar_title.empty(); });
  Sheet sheet(panels.size(), columns, panel_width, panel_height, with_bars, Overlap::AsTheyCome);
  std::vector<Rest> rests;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const CutPanel& panel = panels[i];
    const Viewpoint viewpoint = viewpoint_of_cut(panel.plane_normal);
    vtkNew<vtkPlane> plane;
    plane->SetOrigin(panel.plane_point.data());
    plane->SetNormal(viewpoint.towards_viewer.data());
    const auto colours = lookup_table(Map::Sequential, panel.bar_min, panel.bar_max);
    add_cut_face(sheet.scene(i), panel, *plane, *colours);
    const auto known =
        std::find_if(rests.begin(), rests.end(), [&](const Rest& r) { return r.serves(panel); });
    const Rest& rest = known != rests.end() ? *known : rests.emplace_back(panel, *plane);
    rest.add_to(sheet.scene(i));
    sheet.describe(i, viewpoint, {panel.title, panel.bar_title}, *colours);
  }
  sheet.save(file);
}

}  // namespace sanatrix::render
