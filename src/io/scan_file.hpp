// Three-dimensional photographs as 3dMD, Vectra and hand-held scanners deliver them: OBJ with MTL
// and JPG/PNG, PLY, STL. docs/user/scans.md
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/textured_surface.hpp"

namespace sanatrix::io {

enum class ScanUnit { Guess, Metre, Centimetre, Millimetre, Inch };
/// "guess", "m", "cm", "mm" or "in"; Error{Usage} otherwise.
ScanUnit parse_scan_unit(const std::string& name);

struct Scan {
  TexturedSurface surface;         ///< [m], in the scanner's own frame
  std::string unit;                ///< of the file: "mm", "cm", "in" or "m"
  std::vector<std::string> notes;  ///< what was repaired or left out, one sentence each
};

/// Reads a scan and mends what can be mended: polygons are cut into triangles; faces with NaN,
/// without area or given twice are dropped; loose bits and unused points are dropped; a surface
/// that is inside out is turned. Several photographs become one. Error{Input} names the file, the
/// line and the cause: unreadable, no faces, index out of range, more than 6 million faces,
/// material file or photograph missing or outside the scan's folder, no size between 0.15 and 2.5
/// m.
Scan read_scan(const std::filesystem::path& file, ScanUnit unit = ScanUnit::Guess);

/// Copies a scan with its material file and photographs as STEM.obj, STEM.mtl, STEM-0.jpg, ...
/// into a folder, without comments and names of objects, which may name a person. Returns the
/// copies' names, the scan itself first.
std::vector<std::string> copy_scan(const std::filesystem::path& from,
                                   const std::filesystem::path& folder, const std::string& stem);

/// Pixels of a JPEG or PNG file. Error{Input} when it is not one, or larger than 16384 a side.
Photograph read_photograph(const std::filesystem::path& file);
/// A JPEG's bytes.
std::string jpeg_bytes(const Photograph& photograph, int quality = 88);
/// OBJ with MTL and JPG beside it, in LPS millimetres.
void write_textured_obj(const TexturedSurface& surface, const std::filesystem::path& file);

}  // namespace sanatrix::io
