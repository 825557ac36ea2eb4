// The mesh of a peer model: Gmsh 2.2 with physical names, and VTU as readable text.
#include <fmt/format.h>

#include "io/peer_nodes.hpp"

namespace sanatrix::io {
namespace {

/// Gmsh and VTK number the mid-edges of a tetrahedron differently.
std::vector<int> gmsh_order(std::vector<int> cell) {
  if (cell.size() == 10) {
    std::swap(cell[8], cell[9]);
  }
  return cell;
}

std::string msh_element(std::size_t number, int type, int physical, const std::vector<int>& nodes) {
  std::string text = fmt::format("{} {} 2 {} {}", number, type, physical, physical);
  for (const int n : nodes) {
    text += fmt::format(" {}", n + 1);
  }
  return text + "\n";
}

std::string data_array(const char* type, const char* name, int components,
                       const std::string& values) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n{}\n"
      "</DataArray>\n",
      type, name, components, values);
}

}  // namespace

std::string msh_text(const PeerModel& model) {
  const PeerNodes nodes = make_peer_nodes(model);
  const TetMesh& mesh = model.mesh;
  const int regions = static_cast<int>(mesh.region_names.size());
  const int boundaries = static_cast<int>(mesh.boundary_names.size());
  std::string names;
  for (int r = 0; r < regions; ++r) {
    names += fmt::format("3 {} \"{}\"\n", r + 1, mesh.region_names[static_cast<std::size_t>(r)]);
  }
  for (int b = 0; b < boundaries; ++b) {
    names += fmt::format("2 {} \"{}\"\n", regions + b + 1,
                         mesh.boundary_names[static_cast<std::size_t>(b)]);
  }
  int point = regions + boundaries;
  std::string elements;
  std::size_t number = 0;
  for (const auto& [name, vertex] : mesh.named_points) {
    names += fmt::format("0 {} \"{}\"\n", ++point, name);
    elements += msh_element(++number, 15, point, {vertex});
  }
  for (const BoundaryFace& face : mesh.faces) {
    elements += msh_element(++number, model.order == 2 ? 9 : 2, regions + face.name + 1,
                            nodes.face(face.vertex));
  }
  for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
    elements += msh_element(++number, model.order == 2 ? 11 : 4, mesh.region[c] + 1,
                            gmsh_order(nodes.cells[c]));
  }
  std::string text = fmt::format(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n{}$EndPhysicalNames\n$Nodes\n{}\n",
      point, names, nodes.points.size());
  for (std::size_t n = 0; n < nodes.points.size(); ++n) {
    const Vec3& p = nodes.points[n];
    text += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", n + 1, p[0], p[1], p[2]);
  }
  return text + fmt::format("$EndNodes\n$Elements\n{}\n{}$EndElements\n", number, elements);
}

std::string peer_vtu_text(const PeerModel& model) {
  const PeerNodes nodes = make_peer_nodes(model);
  std::string points, connectivity, offsets, types, fixed;
  std::string material, c1, c2, kappa, density;
  for (std::size_t n = 0; n < nodes.points.size(); ++n) {
    const Vec3& p = nodes.points[n];
    points += fmt::format("{:.12g} {:.12g} {:.12g}\n", p[0], p[1], p[2]);
    fixed += fmt::format("{} ", nodes.fixed[n]);
  }
  std::size_t offset = 0;
  for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
    for (const int n : nodes.cells[c]) {
      connectivity += fmt::format("{} ", n);
    }
    connectivity += '\n';
    offset += nodes.cells[c].size();
    offsets += fmt::format("{} ", offset);
    types += model.order == 2 ? "24 " : "10 ";
    const PeerMaterial& m = model.materials[static_cast<std::size_t>(model.mesh.region[c])];
    material += fmt::format("{} ", model.mesh.region[c]);
    c1 += fmt::format("{:.9g} ", m.c1);
    c2 += fmt::format("{:.9g} ", m.c2);
    kappa += fmt::format("{:.9g} ", m.kappa);
    density += fmt::format("{:.9g} ", m.density);
  }
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- {} -->\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      model.title, nodes.points.size(), nodes.cells.size());
  text += "<PointData>\n" + data_array("UInt8", "fixed_xyz_bits", 1, fixed) + "</PointData>\n";
  text += "<CellData>\n" + data_array("Int32", "material", 1, material) +
          data_array("Float64", "c1_Pa", 1, c1) + data_array("Float64", "c2_Pa", 1, c2) +
          data_array("Float64", "kappa_Pa", 1, kappa) +
          data_array("Float64", "density_kg_m3", 1, density) + "</CellData>\n";
  text += "<Points>\n" + data_array("Float64", "points", 3, points) + "</Points>\n";
  text += "<Cells>\n" + data_array("Int32", "connectivity", 1, connectivity) +
          data_array("Int32", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) +
          "</Cells>\n";
  return text + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace sanatrix::io
