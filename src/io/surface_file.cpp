// Binary STL and PLY for 3D printing, Slicer and Blender: LPS millimetres, said in the header.
#include <array>
#include <bit>
#include <cstdint>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/mesh_file.hpp"

namespace sanatrix::io {
namespace {

static_assert(std::endian::native == std::endian::little, "STL and PLY are written little-endian");

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::array<float, 3> millimetres(const Vec3& p) {
  return {static_cast<float>(1e3 * p[0]), static_cast<float>(1e3 * p[1]),
          static_cast<float>(1e3 * p[2])};
}

std::string stl(const TriMesh& surface) {
  std::string out = "Sanatrix surface, mm, SPACE=LPS";
  out.resize(80, ' ');
  append(out, static_cast<std::uint32_t>(surface.triangles.size()));
  for (const auto& triangle : surface.triangles) {
    std::array<Vec3, 3> x;
    for (std::size_t i = 0; i < 3; ++i) {
      x[i] = surface.points[static_cast<std::size_t>(triangle[i])];
    }
    const Vec3 n = cross(x[1] - x[0], x[2] - x[0]);
    const Vec3 unit = norm(n) > 0 ? normalised(n) : n;
    append(out, std::array<float, 3>{static_cast<float>(unit[0]), static_cast<float>(unit[1]),
                                     static_cast<float>(unit[2])});
    for (const Vec3& corner : x) {
      append(out, millimetres(corner));
    }
    append(out, std::uint16_t{0});
  }
  return out;
}

std::string ply(const TriMesh& surface) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Sanatrix surface, mm\ncomment SPACE=LPS\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      surface.points.size(), surface.triangles.size());
  for (const Vec3& p : surface.points) {
    append(out, millimetres(p));
  }
  for (const auto& triangle : surface.triangles) {
    append(out, std::uint8_t{3});
    append(out, triangle);
  }
  return out;
}

}  // namespace

void write_surface(const TriMesh& surface, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension != ".stl" && extension != ".ply") {
    throw Error(Fault::Usage, fmt::format("{} has no surface extension", file.string()),
                "name it .stl or .ply");
  }
  write_text(file, extension == ".stl" ? stl(surface) : ply(surface));
}

}  // namespace sanatrix::io
