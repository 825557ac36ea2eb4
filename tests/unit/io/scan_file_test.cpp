// Scans as they come from cameras, and as they should not: everything has a clear answer.
#include "io/scan_file.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "own_folder.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Scans : public ::testing::Test {
 protected:
  ~Scans() override { fs::remove_all(folder_); }
  fs::path file(const std::string& name, const std::string& text) const {
    write_text(folder_ / name, text);
    return folder_ / name;
  }
  /// 2 x 2 pixels: red and green above blue and white.
  fs::path photograph(const std::string& name) const {
    const Photograph p{2, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}};
    return file(name, jpeg_bytes(p, 100));
  }
  static std::string refusal(const fs::path& scan, ScanUnit unit = ScanUnit::Guess) {
    try {
      read_scan(scan, unit);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::Input);
      return e.one_line();
    }
    return "not refused";
  }
  fs::path folder_ = testing::own_folder();
};

/// A square of 400 units that bulges a little, so that its outside is known.
const std::string square =
    "v 0 0 0\nv 400 0 0\nv 400 400 0\nv 0 400 0\nv 200 200 60\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt .5 .5\n";

TEST_F(Scans, QuadsNegativeIndicesAndSeamsAreUnderstood) {
  photograph("skin.jpg");
  file("skin.mtl", "newmtl skin\nmap_Kd -s 1 1 1 skin.jpg\n");
  const Scan scan = read_scan(
      file("a.obj",
           "mtllib skin.mtl\n" + square +
               "usemtl skin\nf 1/1 2/2 5/5\nf -4/-4 -3/-3 -1/-1\nf 3/3 4/4 5/5\nf 4/4/ 1/1 5/5\n"));
  EXPECT_EQ(scan.unit, "mm");
  EXPECT_EQ(scan.surface.mesh.triangles.size(), 4U);
  EXPECT_NEAR(norm(scan.surface.mesh.points[1] - scan.surface.mesh.points[0]), 0.4, 1e-12);
  ASSERT_TRUE(scan.surface.has_photograph());
  EXPECT_TRUE(scan.notes.empty());
  const Scan quad = read_scan(file("b.obj", square + "f 1 2 3 4\nf 1//1 2//1 5\n"));
  EXPECT_EQ(quad.surface.mesh.triangles.size(), 3U);
  EXPECT_FALSE(quad.surface.has_photograph());
}

TEST_F(Scans, SeveralPhotographsBecomeOne) {
  photograph("one.jpg");
  photograph("two.jpg");
  file("skin.mtl", "newmtl a\nmap_Kd one.jpg\nnewmtl b\nmap_Kd two.jpg\n");
  const Scan scan = read_scan(file(
      "a.obj", "mtllib skin.mtl\n" + square +
                   "usemtl a\nf 1/1 2/2 5/5\nusemtl b\nf 2/2 3/3 5/5\nusemtl c\nf 3/3 4/4 5/5\n"));
  EXPECT_EQ(scan.surface.photograph.height, 4);
  EXPECT_LT(scan.surface.corners[1][0][1], 0.5F);  // the second one lies below the first
  EXPECT_GE(scan.surface.corners[0][0][1], 0.5F);
  EXPECT_TRUE(std::isnan(scan.surface.corners[2][0][0]));
  EXPECT_EQ(scan.notes.size(), 2U);  // c is not described; one face has no photograph
}

TEST_F(Scans, TheUnitFollowsFromTheSizeOrIsRefused) {
  EXPECT_EQ(read_scan(file("m.obj", "v 0 0 0\nv .4 0 0\nv .4 .4 0\nf 1 2 3\n")).unit, "m");
  EXPECT_EQ(read_scan(file("cm.obj", "v 0 0 0\nv 40 0 0\nv 40 40 0\nf 1 2 3\n")).unit, "cm");
  EXPECT_THAT(refusal(file("km.obj", "v 0 0 0\nv 4e5 0 0\nv 4e5 4e5 0\nf 1 2 3\n")),
              HasSubstr("no trunk"));
  EXPECT_THAT(refusal(folder_ / "cm.obj", ScanUnit::Metre), HasSubstr("--scan-unit"));
}

TEST_F(Scans, BrokenFacesAreLeftOutAndSaid) {
  const Scan scan = read_scan(
      file("a.obj", square + "v nan 0 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 2 3 5\nf 1 1 2\nf 1 2 6\n"));
  EXPECT_EQ(scan.surface.mesh.triangles.size(), 3U);
  EXPECT_EQ(scan.surface.mesh.points.size(), 5U);
  EXPECT_EQ(scan.notes.size(), 3U);
  EXPECT_THAT(refusal(file("b.obj", "v 0 0 0\nv 400 0 0\nv 800 0 0\nf 1 2 3\n")),
              HasSubstr("no usable face"));
}

TEST_F(Scans, UselessTextureCoordinatesAreNotUsed) {
  photograph("skin.jpg");
  file("skin.mtl", "newmtl skin\nmap_Kd skin.jpg\n");
  const Scan scan = read_scan(file("a.obj",
                                   "mtllib skin.mtl\nv 0 0 0\nv 400 0 0\nv 400 400 0\nvt 0 0\n"
                                   "usemtl skin\nf 1/1 2/1 3/1\n"));
  EXPECT_FALSE(scan.surface.has_photograph());
  EXPECT_THAT(scan.notes.at(0), HasSubstr("the same"));
}

TEST_F(Scans, FilesOutsideTheFolderAreNeverOpened) {
  fs::create_directories(folder_ / "inner");
  photograph("secret.jpg");
  write_text(folder_ / "inner/a.mtl", "newmtl skin\nmap_Kd ../secret.jpg\n");
  const std::string faces = square + "usemtl skin\nf 1/1 2/2 5/5\n";
  write_text(folder_ / "inner/a.obj", "mtllib a.mtl\n" + faces);
  EXPECT_THAT(refusal(folder_ / "inner/a.obj"), HasSubstr("outside its own folder"));
  write_text(folder_ / "inner/b.obj", "mtllib /etc/passwd\n" + faces);
  EXPECT_THAT(refusal(folder_ / "inner/b.obj"), HasSubstr("outside its own folder"));
  write_text(folder_ / "inner/c.obj", "mtllib absent.mtl\n" + faces);
  EXPECT_THAT(refusal(folder_ / "inner/c.obj"), HasSubstr("missing"));
}

TEST_F(Scans, DamagedFilesNameThePlace) {
  EXPECT_THAT(refusal(file("a.obj", square + "f 1 2 9\n")), HasSubstr("line 11: vertex 9"));
  EXPECT_THAT(refusal(file("b.obj", "v 0 zero 0\n")), HasSubstr("line 1: 'zero'"));
  EXPECT_THAT(refusal(file("c.obj", square)), HasSubstr("no faces"));
  EXPECT_THAT(refusal(file("d.stl", "short")), HasSubstr("STL"));
  EXPECT_THAT(refusal(file("e.ply",
                           "ply\nformat ascii 1.0\nelement vertex 1000000000\nelement face "
                           "1\nend_header\n")),
              HasSubstr("cut short"));
  EXPECT_THAT(refusal(file("f.txt", "hello")), HasSubstr("not a surface scan"));
  file("g.mtl", "newmtl skin\nmap_Kd g.jpg\n");
  file("g.jpg", "no picture");
  EXPECT_THAT(refusal(file("g.obj", "mtllib g.mtl\n" + square + "usemtl skin\nf 1/1 2/2 5/5\n")),
              HasSubstr("neither JPEG nor PNG"));
}

TEST_F(Scans, CopiesReadTheSameAndNameNobody) {
  photograph("Jane Doe.jpg");
  file("Jane Doe.mtl", "# Jane Doe\nnewmtl Jane\nmap_Kd Jane Doe.jpg\n");
  const fs::path original =
      file("Jane Doe.obj", "# Jane Doe\nmtllib Jane Doe.mtl\no Jane\n" + square +
                               "usemtl Jane\nf 1/1 2/2 5/5\nf 2/2 3/3 5/5\n");
  fs::create_directories(folder_ / "case");
  const std::vector<std::string> names = copy_scan(original, folder_ / "case", "scan");
  EXPECT_THAT(names, ::testing::ElementsAre("scan.obj", "scan.mtl", "scan-0.jpg"));
  for (const std::string name : {"scan.obj", "scan.mtl"}) {
    EXPECT_THAT(read_text(folder_ / "case" / name), ::testing::Not(HasSubstr("Jane")));
  }
  const Scan one = read_scan(original), two = read_scan(folder_ / "case/scan.obj");
  EXPECT_EQ(one.surface.mesh.points, two.surface.mesh.points);
  EXPECT_EQ(one.surface.corners, two.surface.corners);
  EXPECT_EQ(one.surface.photograph.rgb, two.surface.photograph.rgb);
}

TEST_F(Scans, WrittenSurfacesComeBack) {
  TexturedSurface surface;
  surface.mesh = {{{0, 0, 0}, {0.4, 0, 0}, {0.4, 0.4, 0}}, {{0, 1, 2}}};
  surface.corners = {{{{0.1F, 0.2F}, {0.9F, 0.2F}, {0.9F, 0.8F}}}};
  surface.photograph = {2, 2, std::vector<unsigned char>(12, 90)};
  write_textured_obj(surface, folder_ / "out.obj");
  const Scan back = read_scan(folder_ / "out.obj");
  EXPECT_NEAR(norm(back.surface.mesh.points[2] - surface.mesh.points[2]), 0, 1e-7);
  EXPECT_NEAR(back.surface.corners[0][1][0], 0.9, 1e-5);
}

}  // namespace
}  // namespace sanatrix::io
