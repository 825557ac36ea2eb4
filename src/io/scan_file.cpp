// Reading scans of every format, finding their unit of length, copying and writing them.
#include "io/scan_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_parts.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

RawScan read_raw(const fs::path& file) {
  const std::string extension = extension_of(file);
  if (extension == ".obj") {
    return read_obj(file);
  }
  if (extension == ".ply" || extension == ".stl") {
    return read_ply_or_stl(file);
  }
  throw Error(
      Fault::Input,
      fmt::format("{}: this is not a surface scan that can be read", file.filename().string()),
      "give an .obj (with its .mtl and photographs), .ply or .stl file");
}

struct NamedUnit {
  ScanUnit unit;
  const char* name;
  double metres;
  double least_guess_m;  ///< shorter than this, another unit is likelier
};
constexpr std::array<NamedUnit, 4> units{{{ScanUnit::Millimetre, "mm", 1e-3, 0.15},
                                          {ScanUnit::Centimetre, "cm", 1e-2, 0.20},
                                          {ScanUnit::Inch, "in", 0.0254, 0.15},
                                          {ScanUnit::Metre, "m", 1.0, 0.15}}};

/// Longest side of the box around the points that faces use, in the file's unit.
double extent_of(const RawScan& raw) {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const auto& triangle : raw.triangles) {
    for (const int point : triangle) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = raw.points[static_cast<std::size_t>(point)][k];
        if (std::isfinite(x)) {
          low[k] = std::min(low[k], x);
          high[k] = std::max(high[k], x);
        }
      }
    }
  }
  return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

/// A trunk is between 0.15 and 1.5 m long. The first that fits: only centimetres and inches can be
/// mistaken for each other, and a scan of both breasts is hardly shorter than 20 cm.
NamedUnit find_unit(const RawScan& raw, ScanUnit asked, const std::string& name) {
  constexpr double shortest_m = 0.15, longest_m = 1.5;
  const double extent = extent_of(raw);
  for (const NamedUnit& unit : units) {
    const double metres = unit.metres * extent;
    const bool fits = metres >= shortest_m && metres < longest_m;
    const bool likely = fits && metres >= unit.least_guess_m;
    if (asked == unit.unit || (asked == ScanUnit::Guess && likely)) {
      if (!fits) {
        throw Error(
            Fault::Input,
            fmt::format("{}: in {} the scan would be {:.3g} m long; a trunk is {} to {} m", name,
                        unit.name, metres, shortest_m, longest_m),
            "give the right unit: new --scan-unit, run --set outcome.scan_unit (mm, cm, in, m)");
      }
      return unit;
    }
  }
  throw Error(Fault::Input,
              fmt::format("{}: the scan is {:.3g} units long, which is no trunk in mm, cm, in or m",
                          name, extent),
              "check that the file is a scan of the trunk, and its unit");
}

/// The lines of an OBJ without comments and names; materials are numbered.
class ObjCopy {
 public:
  ObjCopy(const fs::path& from, const fs::path& folder, std::string stem)
      : from_(from), folder_(folder), stem_(std::move(stem)) {}

  std::vector<std::string> write() {
    write_text(folder_ / (stem_ + ".obj"), geometry());
    std::vector<std::string> names{stem_ + ".obj"};
    if (!photographs_.empty()) {
      const std::string library = stem_ + ".mtl";
      names.push_back(library);
      const std::string text = materials(names);
      write_text(folder_ / library, text);
    }
    return names;
  }

 private:
  std::string number_of(const std::string& material) {
    const auto known = std::ranges::find(materials_, material);
    const auto number = known - materials_.begin();
    if (known == materials_.end()) {
      materials_.push_back(material);
    }
    return fmt::format("material{}", number);
  }

  std::string geometry() {
    std::istringstream text(read_text(from_));
    std::string out, body;
    for (std::string line; std::getline(text, line);) {
      std::istringstream words(line);
      std::string key, rest;
      words >> key;
      std::getline(words >> std::ws, rest);
      if (!rest.empty() && rest.back() == '\r') {
        rest.pop_back();
      }
      while (!rest.empty() && rest.back() == ' ') {
        rest.pop_back();
      }
      if (key == "mtllib") {
        photographs_.merge(read_mtl(companion(from_, rest)));
      } else if (key == "usemtl") {
        body.append("usemtl ").append(number_of(rest)).append("\n");
      } else if (key == "v" || key == "vt" || key == "f") {
        body.append(key).append(" ").append(rest).append("\n");
      }
    }
    if (!photographs_.empty()) {
      out = "mtllib " + stem_ + ".mtl\n";
    }
    return out + body;
  }

  std::string materials(std::vector<std::string>& names) {
    std::string out;
    std::map<fs::path, std::string> copied;  // a photograph may serve several materials
    for (const auto& [material, photograph] : photographs_) {
      out += "newmtl " + number_of(material) + "\n";
      if (photograph.empty()) {
        continue;
      }
      auto& name = copied[photograph];
      if (name.empty()) {
        name = fmt::format("{}-{}{}", stem_, copied.size() - 1, extension_of(photograph));
        write_text(folder_ / name, read_text(photograph));
        names.push_back(name);
      }
      out += "map_Kd " + name + "\n";
    }
    return out;
  }

  fs::path from_, folder_;
  std::string stem_;
  std::vector<std::string> materials_;
  std::map<std::string, fs::path> photographs_;
};

}  // namespace

ScanUnit parse_scan_unit(const std::string& name) {
  for (const NamedUnit& unit : units) {
    if (name == unit.name) {
      return unit.unit;
    }
  }
  if (name != "guess") {
    throw Error(Fault::Usage, fmt::format("there is no unit of scans '{}'", name),
                "write guess, mm, cm, in or m");
  }
  return ScanUnit::Guess;
}

Scan read_scan(const fs::path& file, ScanUnit unit) {
  const std::string name = file.filename().string();
  if (!fs::is_regular_file(file)) {
    throw Error(Fault::Input, fmt::format("{}: this scan does not exist", file.string()),
                "check the path");
  }
  const RawScan raw = read_raw(file);
  const NamedUnit found = find_unit(raw, unit, name);
  Scan scan{.surface = {}, .unit = found.name, .notes = raw.notes};
  scan.surface = during(name, [&] { return clean_scan(raw, found.metres, scan.notes); });
  return scan;
}

std::vector<std::string> copy_scan(const fs::path& from, const fs::path& folder,
                                   const std::string& stem) {
  if (extension_of(from) == ".obj") {
    return ObjCopy(from, folder, stem).write();
  }
  // PLY and STL headers may name a person: only the surface is written anew. Their unit is kept.
  const RawScan raw = read_raw(from);
  std::string out = "ply\nformat ascii 1.0\n";
  out += fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
                     raw.points.size());
  const bool coloured = !raw.point_colour.empty();
  if (coloured) {
    out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  out += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                     raw.triangles.size());
  for (std::size_t i = 0; i < raw.points.size(); ++i) {
    const Vec3& p = raw.points[i];
    out += fmt::format("{} {} {}", p[0], p[1], p[2]);
    for (std::size_t k = 0; coloured && k < 3; ++k) {
      out += fmt::format(" {:.0f}", raw.point_colour[i][k]);
    }
    out += '\n';
  }
  for (const auto& [a, b, c] : raw.triangles) {
    out += fmt::format("3 {} {} {}\n", a, b, c);
  }
  write_text(folder / (stem + ".ply"), out);
  return {stem + ".ply"};
}

void write_textured_obj(const TexturedSurface& surface, const fs::path& file) {
  const std::string stem = file.stem().string();
  const bool textured = surface.has_photograph();
  std::string out = "# Sanatrix surface, mm, SPACE=LPS\n";
  if (textured) {
    out += fmt::format("mtllib {0}.mtl\n", stem);
  }
  for (const Vec3& p : surface.mesh.points) {
    out += fmt::format("v {:.4f} {:.4f} {:.4f}\n", 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]);
  }
  if (!textured) {
    for (const auto& [a, b, c] : surface.mesh.triangles) {
      out += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    write_text(file, out);
    return;
  }
  std::string faces = "usemtl skin\n";
  std::size_t corner = 0;
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.mesh.triangles[t];
    if (std::isnan(surface.corners[t][0][0])) {
      faces += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
      continue;
    }
    for (const TextureCorner& at : surface.corners[t]) {
      out += fmt::format("vt {:.6f} {:.6f}\n", at[0], at[1]);
    }
    faces += fmt::format("f {}/{} {}/{} {}/{}\n", a + 1, corner + 1, b + 1, corner + 2, c + 1,
                         corner + 3);
    corner += 3;
  }
  fs::path mtl = file, jpg = file;
  mtl.replace_extension(".mtl");
  jpg.replace_extension(".jpg");
  write_text(jpg, jpeg_bytes(surface.photograph));
  write_text(mtl, fmt::format("newmtl skin\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {}.jpg\n",
                              stem));
  write_text(file, out + faces);
}

}  // namespace sanatrix::io
