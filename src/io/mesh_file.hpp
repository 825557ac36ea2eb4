// Meshes in and out: Gmsh msh in, VTU/PVD/VTP/STL/PLY out.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::io {

enum class LengthUnit { Metre, Millimetre };

/// Gmsh 2.2 or 4.1 (ASCII or binary): linear tetrahedra with physical volume names as regions,
/// physical surfaces as boundaries, physical points as named points. Error{Input} names the file
/// and what is missing.
TetMesh read_msh(const std::filesystem::path& file, LengthUnit unit);

/// Arrays that ParaView shows without settings. Values are per point or per cell, 1 or 3
/// components.
struct Field {
  std::string name;
  int components = 1;
  std::vector<double> values;
};
Field scalar_field(std::string name, std::vector<double> values);
Field vector_field(std::string name, const std::vector<Vec3>& values, double scale = 1.0);

struct Fields {
  std::vector<Field> point, cell;
};

/// Appended, compressed VTU; geometry in `unit`. Field data SPACE=LPS and the unit's name are
/// written with it. Written aside, flushed and renamed; Error{Resource} when the disk is full.
void write_vtu(const TetMesh& mesh, std::span<const Vec3> points, const Fields& fields,
               const std::filesystem::path& file, LengthUnit unit);
/// PVTU over pieces in the same folder, which have these point and cell fields (names and
/// components are read, values are not).
void write_pvtu(const std::vector<std::string>& pieces, const Fields& fields,
                const std::filesystem::path& file);
void write_vtp(const TriMesh& surface, const Fields& fields, const std::filesystem::path& file,
               LengthUnit unit);
/// PVD collection of time (days) and file names relative to the PVD.
void write_pvd(const std::vector<std::pair<double, std::string>>& steps,
               const std::filesystem::path& file);
/// STL or PLY by extension, LPS millimetres, `SPACE=LPS` in the header.
void write_surface(const TriMesh& surface, const std::filesystem::path& file);
TriMesh read_surface_vtp(const std::filesystem::path& file);

}  // namespace sanatrix::io
