// PLY and STL through VTK, after a look at whether the file can hold what its header promises.
#include <cmath>
#include <sstream>

#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_parts.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

/// VTK's PLY reader trusts the counts of the header; we do not.
void check_ply(const fs::path& file, const std::string& name) {
  const std::string text = read_text(file);
  require(text.starts_with("ply") && text.find("end_header") != std::string::npos,
          "{}: this is not a PLY file", name);
  std::istringstream header(text.substr(0, text.find("end_header")));
  double vertices = 0, faces = 0;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string key, what;
    double count = -1;
    if (words >> key >> what && key == "element" && words >> count) {
      require(count >= 0, "{}: its header promises {} {}", name, count, what);
      (what == "vertex" ? vertices : faces) += count;
    }
  }
  require(faces > 0, "{}: there are no faces in it; export the surface, not points", name);
  // The least a vertex takes is "0 0 0\n", a face a count and three bytes.
  require(6 * vertices + 4 * faces <= static_cast<double>(text.size()),
          "{}: it is cut short: {} vertices and {} faces do not fit into {} bytes", name, vertices,
          faces, text.size());
}

void check_stl(const fs::path& file, const std::string& name) {
  const std::string text = read_text(file);
  const bool ascii = text.starts_with("solid") && text.find("facet") < 1000;
  if (!ascii) {
    require(text.size() > 84, "{}: this is not an STL file", name);
    std::uint32_t count = 0;
    text.copy(reinterpret_cast<char*>(&count), sizeof count, 80);
    require(84 + 50 * static_cast<std::size_t>(count) <= text.size(),
            "{}: it is cut short: {} triangles do not fit into {} bytes", name, count, text.size());
  }
}

template <class Reader>
vtkSmartPointer<vtkPolyData> read_with(const fs::path& file) {
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  return reader->GetOutput();
}

/// Colours of a PLY's vertices (red, green, blue), if it has them.
std::vector<Colour> colours_of(vtkPolyData& data) {
  vtkDataArray* rgb = data.GetPointData()->GetScalars();
  std::vector<Colour> colours;
  if (rgb == nullptr || rgb->GetNumberOfComponents() < 3) {
    return colours;
  }
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) {
    Colour& colour = colours.emplace_back();
    for (int k = 0; k < 3; ++k) {
      colour[static_cast<std::size_t>(k)] = static_cast<float>(rgb->GetComponent(i, k));
    }
  }
  return colours;
}

}  // namespace

RawScan read_ply_or_stl(const fs::path& file) {
  vtkObject::GlobalWarningDisplayOff();  // it would write to stderr on its own
  const std::string name = file.filename().string();
  const std::string extension = file.extension().string();
  const bool is_ply = extension == ".ply" || extension == ".PLY";
  (is_ply ? check_ply : check_stl)(file, name);
  const auto data = is_ply ? read_with<vtkPLYReader>(file) : read_with<vtkSTLReader>(file);
  RawScan raw;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    Vec3 p;
    data->GetPoint(i, p.data());
    raw.points.push_back(p);
  }
  raw.point_colour = colours_of(*data);
  vtkNew<vtkIdList> face;
  vtkCellArray& faces = *data->GetPolys();
  for (faces.InitTraversal(); faces.GetNextCell(face) != 0;) {
    for (vtkIdType k = 2; k < face->GetNumberOfIds(); ++k) {
      std::array<int, 3> triangle{};
      for (std::size_t c = 0; c < 3; ++c) {
        const vtkIdType corner = face->GetId(c == 0 ? 0 : k - 2 + static_cast<vtkIdType>(c));
        require(corner >= 0 && corner < data->GetNumberOfPoints(),
                "{}: a face has the vertex {}; there are {}", name, corner,
                data->GetNumberOfPoints());
        triangle[c] = static_cast<int>(corner);
      }
      raw.triangles.push_back(triangle);
    }
    require(raw.triangles.size() <= most_scan_faces, "{}: more than {} triangles", name,
            most_scan_faces);
  }
  require(!raw.triangles.empty(), "{}: there are no faces in it; export the surface, not points",
          name);
  raw.material.assign(raw.triangles.size(), -1);
  return raw;
}

}  // namespace sanatrix::io
