// VTU, VTP and PVD for ParaView. VTK fills a string and our own writer puts it on the disk, so that
// a full disk is noticed and named.
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/mesh_file.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* space_key = "SPACE";
constexpr const char* unit_key = "LENGTH_UNIT";

double per_metre(LengthUnit unit) {
  return unit == LengthUnit::Millimetre ? 1e3 : 1.0;
}

void add_text(vtkDataObject& data, const char* name, const char* value) {
  vtkNew<vtkStringArray> text;
  text->SetName(name);
  text->InsertNextValue(value);
  data.GetFieldData()->AddArray(text);
}

void add_fields(vtkDataSetAttributes& attributes, const std::vector<Field>& fields,
                std::size_t count, const fs::path& file) {
  for (const Field& field : fields) {
    ensure(field.values.size() == count * static_cast<std::size_t>(field.components),
           "{}: field '{}' has {} values, not {} x {}", file.string(), field.name,
           field.values.size(), count, field.components);
    vtkNew<vtkDoubleArray> array;
    array->SetName(field.name.c_str());
    array->SetNumberOfComponents(field.components);
    array->SetNumberOfTuples(static_cast<vtkIdType>(count));
    std::copy(field.values.begin(), field.values.end(), array->GetPointer(0));
    attributes.AddArray(array);
  }
}

vtkNew<vtkPoints> vtk_points(std::span<const Vec3> points, double scale) {
  vtkNew<vtkPoints> result;
  result->SetDataTypeToDouble();
  result->SetNumberOfPoints(static_cast<vtkIdType>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    result->SetPoint(static_cast<vtkIdType>(i), (scale * points[i]).data());
  }
  return result;
}

template <std::size_t N>
vtkNew<vtkCellArray> vtk_cells(const std::vector<std::array<int, N>>& cells) {
  vtkNew<vtkCellArray> result;
  result->AllocateExact(static_cast<vtkIdType>(cells.size()),
                        static_cast<vtkIdType>(N * cells.size()));
  for (const auto& cell : cells) {
    result->InsertNextCell(static_cast<int>(N));
    for (const int v : cell) {
      result->InsertCellPoint(v);
    }
  }
  return result;
}

template <class Writer>
void write(vtkDataSet& data, const Fields& fields, const fs::path& file, LengthUnit unit) {
  add_fields(*data.GetPointData(), fields.point, static_cast<std::size_t>(data.GetNumberOfPoints()),
             file);
  add_fields(*data.GetCellData(), fields.cell, static_cast<std::size_t>(data.GetNumberOfCells()),
             file);
  add_text(data, space_key, "LPS");
  add_text(data, unit_key, unit == LengthUnit::Millimetre ? "mm" : "m");
  vtkNew<Writer> writer;
  writer->SetInputData(&data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->SetCompressionLevel(1);  // a healing run writes many frames
  writer->WriteToOutputStringOn();
  ensure(writer->Write() == 1, "VTK could not make the contents of {}", file.string());
  write_text(file, writer->GetOutputString());
}

std::string text_of(vtkDataObject& data, const char* name) {
  auto* array = vtkStringArray::SafeDownCast(data.GetFieldData()->GetAbstractArray(name));
  return array != nullptr && array->GetNumberOfValues() > 0 ? array->GetValue(0) : std::string();
}

/// Keeps VTK's complaints out of the terminal; we have our own message.
class QuietVtk {
 public:
  QuietVtk() { vtkObject::GlobalWarningDisplayOff(); }
  ~QuietVtk() { vtkObject::SetGlobalWarningDisplay(before_); }
  QuietVtk(const QuietVtk&) = delete;
  QuietVtk& operator=(const QuietVtk&) = delete;

 private:
  int before_ = vtkObject::GetGlobalWarningDisplay();
};

}  // namespace

Field scalar_field(std::string name, std::vector<double> values) {
  return {std::move(name), 1, std::move(values)};
}

Field vector_field(std::string name, const std::vector<Vec3>& values, double scale) {
  Field field{std::move(name), 3, {}};
  field.values.reserve(3 * values.size());
  for (const Vec3& value : values) {
    for (const double component : value) {
      field.values.push_back(scale * component);
    }
  }
  return field;
}

void write_vtu(const TetMesh& mesh, std::span<const Vec3> points, const Fields& fields,
               const fs::path& file, LengthUnit unit) {
  ensure(points.size() == mesh.points.size(), "{}: {} positions for {} vertices", file.string(),
         points.size(), mesh.points.size());
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(vtk_points(points, per_metre(unit)));
  grid->SetCells(VTK_TETRA, vtk_cells(mesh.cells));
  write<vtkXMLUnstructuredGridWriter>(*grid, fields, file, unit);
}

void write_pvtu(const std::vector<std::string>& pieces, const Fields& fields,
                const fs::path& file) {
  const auto arrays = [](const char* section, const std::vector<Field>& listed) {
    std::string text = fmt::format("    <{}>\n", section);
    for (const Field& field : listed) {
      text += fmt::format(
          "      <PDataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n",
          field.name, field.components);
    }
    return text + fmt::format("    </{}>\n", section);
  };
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <PUnstructuredGrid GhostLevel=\"0\">\n";
  text += arrays("PPointData", fields.point) + arrays("PCellData", fields.cell);
  text +=
      "    <PPoints>\n      <PDataArray type=\"Float64\" NumberOfComponents=\"3\"/>\n"
      "    </PPoints>\n";
  for (const std::string& piece : pieces) {
    text += fmt::format("    <Piece Source=\"{}\"/>\n", piece);
  }
  write_text(file, text + "  </PUnstructuredGrid>\n</VTKFile>\n");
}

void write_vtp(const TriMesh& surface, const Fields& fields, const fs::path& file,
               LengthUnit unit) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(vtk_points(surface.points, per_metre(unit)));
  data->SetPolys(vtk_cells(surface.triangles));
  write<vtkXMLPolyDataWriter>(*data, fields, file, unit);
}

void write_pvd(const std::vector<std::pair<double, std::string>>& steps, const fs::path& file) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n";
  for (const auto& [time, name] : steps) {
    text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, name);
  }
  write_text(file, text + "  </Collection>\n</VTKFile>\n");
}

TriMesh read_surface_vtp(const fs::path& file) {
  require(fs::is_regular_file(file), "surface {} does not exist", file.string());
  const QuietVtk quiet;
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkPolyData& data = *reader->GetOutput();
  require(reader->GetErrorCode() == 0 && data.GetNumberOfPolys() > 0,
          "{} is not a VTP surface with triangles", file.string());
  const std::string space = text_of(data, space_key);
  require(space.empty() || space == "LPS", "{} is in {} coordinates; LPS is needed", file.string(),
          space);
  const double scale =
      text_of(data, unit_key) == "m" ? 1.0 : 1e-3;  // surfaces are in mm by default
  TriMesh surface;
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) {
    Vec3 p;
    data.GetPoint(i, p.data());
    surface.points.push_back(scale * p);
  }
  vtkNew<vtkIdList> ids;
  for (vtkIdType i = 0; i < data.GetPolys()->GetNumberOfCells(); ++i) {
    data.GetPolys()->GetCellAtId(i, ids);
    require(ids->GetNumberOfIds() == 3, "{} has faces of {} corners; triangulate it", file.string(),
            ids->GetNumberOfIds());
    surface.triangles.push_back({static_cast<int>(ids->GetId(0)), static_cast<int>(ids->GetId(1)),
                                 static_cast<int>(ids->GetId(2))});
  }
  return surface;
}

}  // namespace sanatrix::io
