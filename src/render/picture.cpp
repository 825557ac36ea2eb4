// Surfaces seen from a named side, coloured by a scalar, with arrows.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkGlyph3D.h>
#include <vtkImageData.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>

#include "core/error.hpp"
#include "render/colours.hpp"
#include "render/render.hpp"
#include "render/sheet.hpp"

namespace sanatrix::render {
namespace {

constexpr double shortest_share = 0.1;  // of the longest arrow

vtkNew<vtkDoubleArray> vtk_vectors(const std::vector<Vec3>& values) {
  vtkNew<vtkDoubleArray> array;
  array->SetNumberOfComponents(3);
  for (const Vec3& value : values) {
    array->InsertNextTuple(value.data());
  }
  return array;
}

vtkNew<vtkPoints> vtk_points(const std::vector<Vec3>& values) {
  vtkNew<vtkPoints> points;
  points->SetData(vtk_vectors(values));
  return points;
}

vtkNew<vtkImageData> image_of(const Photograph& photograph) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(photograph.width, photograph.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* pixels = static_cast<unsigned char*>(image->GetScalarPointer());
  const auto row = static_cast<std::ptrdiff_t>(3 * photograph.width);
  for (std::ptrdiff_t y = 0; y < photograph.height; ++y) {  // VTK begins with the lowest row
    std::copy_n(photograph.rgb.begin() + (photograph.height - 1 - y) * row, row, pixels + y * row);
  }
  return image;
}

void add_texture(vtkActor& prop, vtkPolyData& data, const Actor& actor) {
  vtkNew<vtkFloatArray> corners;
  corners->SetNumberOfComponents(2);
  for (const TextureCorner& at : actor.corner) {
    corners->InsertNextTuple(at.data());
  }
  data.GetPointData()->SetTCoords(corners);
  vtkNew<vtkTexture> texture;
  texture->SetInputData(image_of(*actor.photograph));
  texture->InterpolateOn();
  texture->MipmapOff();
  prop.SetTexture(texture);
  // A photograph brings its own light.
  prop.GetProperty()->SetColor(1, 1, 1);
  prop.GetProperty()->SetAmbient(0.4);
  prop.GetProperty()->SetDiffuse(0.65);
}

void add_surface(vtkRenderer& scene, const Actor& actor, vtkLookupTable& colours) {
  vtkNew<vtkCellArray> triangles;
  for (const auto& [a, b, c] : actor.surface.triangles) {
    triangles->InsertNextCell({a, b, c});
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(vtk_points(actor.surface.points));
  data->SetPolys(triangles);
  data->GetPointData()->SetNormals(
      vtk_vectors(actor.normals.empty() ? vertex_normals(actor.surface) : actor.normals));
  vtkNew<vtkPolyDataMapper> mapper;
  if (!actor.scalar.empty()) {
    ensure(actor.scalar.size() == actor.surface.points.size(), "{} colours for {} vertices",
           actor.scalar.size(), actor.surface.points.size());
    vtkNew<vtkDoubleArray> scalars;
    for (const double value : actor.scalar) {
      scalars->InsertNextValue(value);
    }
    data->GetPointData()->SetScalars(scalars);
    mapper->SetLookupTable(&colours);
    mapper->UseLookupTableScalarRangeOn();
    mapper->InterpolateScalarsBeforeMappingOn();
  }
  mapper->SetInputData(data);
  vtkNew<vtkActor> prop;
  prop->SetMapper(mapper);
  vtkProperty& look = *prop->GetProperty();
  look.SetColor(actor.colour[0], actor.colour[1], actor.colour[2]);
  look.SetOpacity(actor.opacity);
  if (actor.opacity < 1.0) {
    look.BackfaceCullingOn();  // the far side would only darken what is seen through the near one
  }
  look.SetAmbient(actor.scalar.empty() ? 0.15 : 0.45);  // colours that carry numbers stay readable
  look.SetDiffuse(actor.scalar.empty() ? 0.85 : 0.55);
  if (actor.photograph) {
    add_texture(*prop, *data, actor);
  }
  if (actor.wireframe) {
    look.SetRepresentationToWireframe();
    look.LightingOff();
  }
  scene.AddActor(prop);
}

double diagonal(const std::vector<Vec3>& points) {
  Vec3 low = points.front(), high = points.front();
  for (const Vec3& p : points) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  return norm(high - low);
}

/// The longest arrow of every cube of a coarse grid: more would hide each other.
std::vector<std::size_t> chosen_arrows(const Actor& actor) {
  double longest_m = 0;
  for (const Vec3& arrow : actor.arrows) {
    longest_m = std::max(longest_m, norm(arrow));
  }
  const double spacing =
      std::max(diagonal(actor.surface.points) / 28, 0.5 * actor.arrow_scale * longest_m);
  std::map<std::array<long, 3>, std::size_t> longest;
  for (std::size_t i = 0; i < actor.arrows.size(); ++i) {
    if (norm(actor.arrows[i]) < shortest_share * longest_m) {
      continue;
    }
    std::array<long, 3> cube;
    for (std::size_t k = 0; k < 3; ++k) {
      cube[k] = std::lround(actor.surface.points[i][k] / spacing);
    }
    const auto [found, is_new] = longest.try_emplace(cube, i);
    if (!is_new && norm(actor.arrows[i]) > norm(actor.arrows[found->second])) {
      found->second = i;
    }
  }
  std::vector<std::size_t> chosen;
  for (const auto& [cube, i] : longest) {
    chosen.push_back(i);
  }
  return chosen;
}

/// Dark on every colour of the surface, and never inside it.
void add_arrows(vtkRenderer& scene, const Actor& actor) {
  const std::vector<Vec3> normals = vertex_normals(actor.surface);
  std::vector<Vec3> feet, vectors;
  for (const std::size_t i : chosen_arrows(actor)) {
    const Vec3 vector = actor.arrow_scale * actor.arrows[i];
    const bool inward = dot(vector, normals[i]) < 0;
    feet.push_back(actor.surface.points[i] - (inward ? 1.0 : 0.0) * vector);
    vectors.push_back(vector);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(vtk_points(feet));
  data->GetPointData()->SetVectors(vtk_vectors(vectors));
  vtkNew<vtkArrowSource> shape;
  shape->SetTipResolution(16);
  shape->SetShaftResolution(12);
  shape->SetTipRadius(0.16);
  shape->SetShaftRadius(0.055);
  vtkNew<vtkGlyph3D> glyphs;
  glyphs->SetInputData(data);
  glyphs->SetSourceConnection(shape->GetOutputPort());
  glyphs->SetVectorModeToUseVector();
  glyphs->SetScaleModeToScaleByVector();
  glyphs->SetScaleFactor(1.0);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(glyphs->GetOutputPort());
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> prop;
  prop->SetMapper(mapper);
  prop->GetProperty()->SetColor(0.12, 0.12, 0.12);
  scene.AddActor(prop);
}

}  // namespace

std::vector<Actor> textured(const TexturedSurface& surface) {
  if (!surface.has_photograph()) {
    Actor plain;
    plain.surface = surface.mesh;
    return {plain};
  }
  const SeamlessSurface seamless = split_at_seams(surface);
  const std::vector<Vec3> normals = vertex_normals(surface.mesh);
  Actor photographed;
  photographed.surface = seamless.mesh;
  photographed.corner = seamless.corner;
  photographed.photograph = std::make_shared<Photograph>(surface.photograph);
  for (const int origin : seamless.origin) {
    photographed.normals.push_back(normals[static_cast<std::size_t>(origin)]);
  }
  Actor plain = photographed;
  plain.photograph = nullptr;
  const auto has_none = [&](const std::array<int, 3>& t) {
    return std::isnan(seamless.corner[static_cast<std::size_t>(t[0])][0]);
  };
  std::erase_if(photographed.surface.triangles, has_none);
  std::erase_if(plain.surface.triangles, std::not_fn(has_none));
  return {photographed, plain};
}

double nice_top(double high) {
  if (!(high > 0)) {
    return 1.0;
  }
  const double power = std::pow(10.0, std::floor(std::log10(high)));
  for (const double digits : {1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (high <= digits * power * (1 + 1e-9)) {
      return digits * power;
    }
  }
  return 10 * power;
}

void write_picture(const std::vector<Panel>& panels, int columns, const std::filesystem::path& file,
                   int panel_width, int panel_height) {
  const bool with_bars = std::any_of(panels.begin(), panels.end(),
                                     [](const Panel& p) { return !p.bar_title.empty(); });
  const bool translucent = std::any_of(panels.begin(), panels.end(), [](const Panel& p) {
    return std::any_of(p.actors.begin(), p.actors.end(),
                       [](const Actor& a) { return a.opacity < 1.0; });
  });
  Sheet sheet(panels.size(), columns, panel_width, panel_height, with_bars,
              translucent ? Overlap::Sorted : Overlap::AsTheyCome);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Panel& panel = panels[i];
    const auto colours = lookup_table(panel.diverging ? Map::Diverging : Map::Sequential,
                                      panel.bar_min, panel.bar_max);
    for (const Actor& actor : panel.actors) {
      if (actor.surface.triangles.empty()) {
        continue;
      }
      add_surface(sheet.scene(i), actor, *colours);
      if (!actor.arrows.empty()) {
        ensure(actor.arrows.size() == actor.surface.points.size(), "{} arrows for {} vertices",
               actor.arrows.size(), actor.surface.points.size());
        add_arrows(sheet.scene(i), actor);
      }
    }
    sheet.describe(i, viewpoint_of(panel.view), {panel.title, panel.bar_title}, *colours);
  }
  sheet.save(file);
}

}  // namespace sanatrix::render
