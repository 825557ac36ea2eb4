// Gmsh files in, ParaView files out, and errors that name what is missing.
#include "io/mesh_file.hpp"

#include <filesystem>
#include <numbers>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "own_folder.hpp"
#include "shared_data.hpp"
#include "simple_meshes.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MeshFile : public ::testing::Test {
 protected:
  ~MeshFile() override { fs::remove_all(folder_); }
  std::string error_of_msh(const std::string& text) {
    const fs::path file = folder_ / "a.msh";
    write_text(file, text);
    try {
      read_msh(file, LengthUnit::Metre);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::Input);
      EXPECT_THAT(e.what(), HasSubstr(file.string()));
      return e.one_line();
    }
    return "accepted";
  }
  fs::path folder_ = testing::own_folder();
};

/// Two tetrahedra on one face; node 6 is used by nothing.
std::string msh22(const std::string& names, const std::string& elements) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names +
         "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n6 9 9 "
         "9\n$EndNodes\n$Elements\n" +
         elements + "$EndElements\n";
}

void expect_hemisphere(const TetMesh& mesh, std::size_t vertices, std::size_t cells) {
  EXPECT_EQ(mesh.points.size(), vertices);
  EXPECT_EQ(mesh.cells.size(), cells);
  EXPECT_THAT(mesh.region_names, ElementsAre("breast"));
  const std::vector<double> volumes = cell_volumes(mesh, mesh.points);
  const double radius = 0.065;
  const double exact = 2.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  // Flat faces cut off at most a few per cent of the dome.
  EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), exact, 0.05 * exact);
  const Surface base = extract_surface(mesh, mesh.points, {"base"});
  for (const Vec3& p : base.mesh.points) {
    EXPECT_NEAR(p[2], 0.0, 1e-12);
  }
  for (const Vec3& normal : vertex_normals(base.mesh)) {
    EXPECT_NEAR(normal[2], -1.0, 1e-9);  // outward
  }
  const Vec3 apex = mesh.points[static_cast<std::size_t>(mesh.named_points.at("apex"))];
  EXPECT_NEAR(norm(apex - Vec3{0, 0, radius}), 0.0, 1e-12);
  EXPECT_EQ(mesh.named_points.count("rim_4"), 1u);
  EXPECT_EQ(base.mesh.triangles.size() +
                extract_surface(mesh, mesh.points, {"skin"}).mesh.triangles.size(),
            boundary_of(mesh).size());
}

TEST_F(MeshFile, ReadsGmsh41) {
  SANATRIX_REQUIRE_SHARED("bench/hemi5k.msh");
  expect_hemisphere(read_msh(shared_file, LengthUnit::Metre), 4591, 22035);
}

TEST_F(MeshFile, ReadsGmsh22) {
  SANATRIX_REQUIRE_SHARED("bench/hemi5k_v22.msh");
  expect_hemisphere(read_msh(shared_file, LengthUnit::Metre), 4591, 22035);
}

TEST_F(MeshFile, ReadsTheCoarseHemisphere) {
  SANATRIX_REQUIRE_SHARED("bench/hemiC_v22.msh");
  expect_hemisphere(read_msh(shared_file, LengthUnit::Metre), 726, 2751);
}

TEST_F(MeshFile, UnnamedGroupsGetNamesMillimetresBecomeMetresAndLooseNodesAreDropped) {
  write_text(folder_ / "a.msh",
             msh22("", "3\n1 2 2 8 1 1 2 4\n2 4 2 7 1 1 2 3 4\n3 4 2 9 2 1 2 3 5\n"));
  const TetMesh mesh = read_msh(folder_ / "a.msh", LengthUnit::Millimetre);
  EXPECT_EQ(mesh.points.size(), 5u);
  EXPECT_THAT(mesh.region_names, ElementsAre("region_7", "region_9"));
  EXPECT_THAT(mesh.boundary_names, ElementsAre("boundary_8"));
  for (const double v : cell_volumes(mesh, mesh.points)) {
    EXPECT_NEAR(v, 1e-9 / 6, 1e-20);
  }
}

TEST_F(MeshFile, SaysWhyAMeshCannotBeRead) {
  EXPECT_THAT(error_of_msh("solid\n"), HasSubstr("not a Gmsh mesh"));
  EXPECT_THAT(error_of_msh(msh22("", "1\n1 2 2 8 1 1 2 4\n")), HasSubstr("no tetrahedra"));
  EXPECT_THAT(error_of_msh(msh22("", "1\n1 4 2 7 1 1 2 3 99\n")),
              HasSubstr("node 99 is used but not given"));
  EXPECT_THAT(error_of_msh("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n"),
              HasSubstr("line 5: the file ends here"));
  EXPECT_THAT(error_of_msh(msh22("", "2\n1 4 2 7 1 1 2 3 4\n")),
              HasSubstr("line 16: a number should stand here"));
  EXPECT_THAT(error_of_msh(msh22("", "1\n1 4 2 7 1 1 2 3 4\n2 4 2 7 1 1 2 3 5\n")),
              HasSubstr("line 16: $EndElements should stand here"));
  EXPECT_THAT(error_of_msh(msh22("$PhysicalNames\n1\n3 7 fat\n$EndPhysicalNames\n", "0\n")),
              HasSubstr("line 6: a name in quotes"));
  EXPECT_THAT(error_of_msh(msh22("", "2\n1 4 2 7 1 1 2 3 4\n2 4 2 8 1 1 2 3 5\n")),
              HasSubstr("several physical volumes (7 and 8)"));
  EXPECT_THAT(error_of_msh("$MeshFormat\n4 0 8\n"), HasSubstr("its format is 4 "));
  EXPECT_THAT(error_of_msh(msh22("", "1\n1 5 2 7 1 1 2 3 4 1 2 3 5\n")),
              HasSubstr("only linear tetrahedra"));
  EXPECT_THAT(error_of_msh(msh22("", "1\n1 11 2 7 1 1 2 3 4 5 6 1 2 3 4\n")),
              HasSubstr("mesh it with order 1"));
  try {
    read_msh(folder_ / "absent.msh", LengthUnit::Metre);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("absent.msh does not exist"));
  }
}

TEST_F(MeshFile, ASurfaceComesBackFromVtpInMetres) {
  const TriMesh surface = sanatrix::testing::sphere(10, 0.06);
  Fields fields;
  fields.point.push_back(scalar_field("z", std::vector<double>(surface.points.size(), 1.0)));
  for (const LengthUnit unit : {LengthUnit::Metre, LengthUnit::Millimetre}) {
    write_vtp(surface, fields, folder_ / "s.vtp", unit);
    const TriMesh back = read_surface_vtp(folder_ / "s.vtp");
    ASSERT_EQ(back.points.size(), surface.points.size());
    EXPECT_EQ(back.triangles, surface.triangles);
    for (std::size_t i = 0; i < back.points.size(); ++i) {
      EXPECT_NEAR(norm(back.points[i] - surface.points[i]), 0.0, 1e-16);
    }
  }
  const std::string all = read_text(folder_ / "s.vtp");
  for (const std::size_t length : {std::size_t{25}, all.size() / 2, all.size() - 200}) {
    write_text(folder_ / "s.vtp", all.substr(0, length));
    EXPECT_THROW(read_surface_vtp(folder_ / "s.vtp"), Error) << length;
  }
}

TEST_F(MeshFile, ParaViewFilesSayTheirSpaceAndUnit) {
  TetMesh mesh = sanatrix::testing::cube(2);
  check_and_orient(mesh, "cube");
  Fields fields;
  fields.point.push_back(vector_field("displacement_mm", mesh.points, 1e3));
  fields.cell.push_back(scalar_field("region", std::vector<double>(mesh.cells.size(), 0.0)));
  write_vtu(mesh, mesh.points, fields, folder_ / "m.vtu", LengthUnit::Millimetre);
  const std::string vtu = read_text(folder_ / "m.vtu");
  for (const char* part : {"UnstructuredGrid", "SPACE", "LENGTH_UNIT", "displacement_mm", "region",
                           "vtkZLibDataCompressor", "appended"}) {
    EXPECT_THAT(vtu, HasSubstr(part));
  }
  fields.cell[0].values.pop_back();
  EXPECT_THROW(write_vtu(mesh, mesh.points, fields, folder_ / "m.vtu", LengthUnit::Metre), Error);
  write_pvd({{0.0, "m.vtu"}, {12.5, "n.vtu"}}, folder_ / "m.pvd");
  EXPECT_THAT(read_text(folder_ / "m.pvd"),
              HasSubstr("timestep=\"12.5\" part=\"0\" file=\"n.vtu\""));
}

TEST_F(MeshFile, StlAndPlyAreLpsMillimetres) {
  const TriMesh square = sanatrix::testing::square(1, 0.02, 0.0);
  write_surface(square, folder_ / "s.stl");
  write_surface(square, folder_ / "s.ply");
  const std::string stl = read_text(folder_ / "s.stl");
  EXPECT_EQ(stl.size(), 84u + 50u * 2u);
  EXPECT_THAT(stl.substr(0, 80), HasSubstr("SPACE=LPS"));
  float x = 0;  // second corner of the first triangle
  std::memcpy(&x, stl.data() + 84 + 12 + 12, sizeof x);
  EXPECT_FLOAT_EQ(x, 20.0F);
  EXPECT_THAT(read_text(folder_ / "s.ply"), HasSubstr("comment SPACE=LPS"));
  EXPECT_THROW(write_surface(square, folder_ / "s.obj"), Error);
}

}  // namespace
}  // namespace sanatrix::io
