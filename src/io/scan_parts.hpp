// What the readers of scans hand to each other inside io.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/textured_surface.hpp"

namespace sanatrix::io {

/// A scan as it stands in its file, before anything is mended. Lengths in the file's unit.
struct RawScan {
  std::vector<Vec3> points;          ///< may hold NaN
  std::vector<Colour> point_colour;  ///< per point, or empty
  std::vector<TextureCorner> texture_points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 3>> texture_triangles;  ///< -1: no texture; empty: none has
  std::vector<int> material;                          ///< per triangle, index or -1
  std::vector<std::filesystem::path> photographs;     ///< per material; empty path: none
  std::vector<std::string> notes;
};

inline constexpr std::size_t most_scan_faces = 6'000'000;

RawScan read_obj(const std::filesystem::path& file);
RawScan read_ply_or_stl(const std::filesystem::path& file);

/// The material names of an MTL file and their photographs, which must lie in the MTL's folder.
std::map<std::string, std::filesystem::path> read_mtl(const std::filesystem::path& file);
/// A file named inside a scan: must exist and stay inside the scan's folder. Error{Input}.
std::filesystem::path companion(const std::filesystem::path& scan, const std::string& name);

/// Turns the raw scan into a clean surface in metres.
TexturedSurface clean_scan(const RawScan& raw, double metres_per_unit,
                           std::vector<std::string>& notes);

}  // namespace sanatrix::io
