// Wavefront OBJ and MTL as scanners write them. Own reader: general ones either lose the groups of
// several photographs or follow file names anywhere on the disk.
#include <algorithm>
#include <charconv>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_parts.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// The next word of a line, which is shortened by it.
std::string_view next_word(std::string_view& line) {
  const auto first = line.find_first_not_of(blanks);
  if (first == std::string_view::npos) {
    line = {};
    return {};
  }
  const auto last = std::min(line.find_first_of(blanks, first), line.size());
  const std::string_view word = line.substr(first, last - first);
  line.remove_prefix(last);
  return word;
}

/// Calls use(line, number) for every line.
template <class Use>
void for_each_line(std::string_view text, Use&& use) {
  std::size_t number = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    use(text.substr(0, end), ++number);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

class ObjReader {
 public:
  explicit ObjReader(const fs::path& file) : file_(file), name_(file.filename().string()) {}

  RawScan read() {
    const std::string text = read_text(file_);
    for_each_line(text, [&](std::string_view line, std::size_t number) {
      line_ = number;
      take(line);
    });
    finish();
    return std::move(scan_);
  }

 private:
  void take(std::string_view line) {
    const std::string_view key = next_word(line);
    if (key == "v") {
      scan_.points.push_back({real(line), real(line), real(line)});
      take_colour(line);
    } else if (key == "vt") {
      const double u = real(line);
      scan_.texture_points.push_back({static_cast<float>(u), static_cast<float>(real(line))});
    } else if (key == "f") {
      face(line);
    } else if (key == "usemtl") {
      use_material(std::string(trimmed(line)));
    } else if (key == "mtllib") {
      libraries_.emplace_back(trimmed(line));
    }
  }

  /// Some scanners write red, green, blue after a vertex, as 0..1 or 0..255.
  void take_colour(std::string_view line) {
    Colour colour{};
    for (float& channel : colour) {
      if (trimmed(line).empty() || trimmed(line).starts_with('#')) {
        return;
      }
      channel = static_cast<float>(real(line));
    }
    // Vertices without colours before it stay black, which is taken for no colour.
    scan_.point_colour.resize(scan_.points.size() - 1);
    scan_.point_colour.push_back(colour);
  }

  double real(std::string_view& line) {
    std::string_view word = next_word(line);
    if (word.starts_with('+')) {
      word.remove_prefix(1);
    }
    double value = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    // MSVC writes NaN as "-nan(ind)", "1.#QNAN"; from_chars knows the first kind.
    if (word.find("1.#") != std::string_view::npos) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    require(problem == std::errc{} && end == word.data() + word.size(),
            "{}, line {}: '{}' is not a number", name_, line_, word);
    return value;
  }

  /// 1-based or, when negative, counted from the end; 0 stands for absent.
  int index(std::string_view word, std::size_t count, std::string_view what) const {
    long value = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    require(problem == std::errc{} && end == word.data() + word.size() && value != 0,
            "{}, line {}: '{}' is not the number of a {}", name_, line_, word, what);
    const long at = value > 0 ? value - 1 : static_cast<long>(count) + value;
    require(at >= 0 && at < static_cast<long>(count),
            "{}, line {}: {} {} does not exist; there are {} so far", name_, line_, what, value,
            count);
    return static_cast<int>(at);
  }

  void face(std::string_view line) {
    corners_.clear();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const auto slash = std::min(word.find('/'), word.size());
      Corner corner{index(word.substr(0, slash), scan_.points.size(), "vertex"), -1};
      std::string_view rest = word.substr(std::min(slash + 1, word.size()));
      rest = rest.substr(0, std::min(rest.find('/'), rest.size()));
      if (!rest.empty()) {
        corner.texture = index(rest, scan_.texture_points.size(), "texture point");
      }
      corners_.push_back(corner);
    }
    require(corners_.size() >= 3, "{}, line {}: a face with {} corners", name_, line_,
            corners_.size());
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      const Corner &a = corners_[0], &b = corners_[k - 1], &c = corners_[k];
      scan_.triangles.push_back({a.point, b.point, c.point});
      scan_.texture_triangles.push_back({a.texture, b.texture, c.texture});
      scan_.material.push_back(material_);
    }
    require(scan_.triangles.size() <= most_scan_faces,
            "{}: more than {} triangles; reduce the scan in the scanner's software", name_,
            most_scan_faces);
  }

  void use_material(const std::string& name) {
    const auto known = std::ranges::find(materials_, name);
    material_ = static_cast<int>(known - materials_.begin());
    if (known == materials_.end()) {
      materials_.push_back(name);
    }
  }

  /// Gives every material its photograph.
  void finish() {
    require(!scan_.triangles.empty(),
            "{}: there are no faces in it; export the surface, not points", name_);
    finish_colours();
    std::map<std::string, fs::path> photographs;
    for (const std::string& library : libraries_) {
      photographs.merge(read_mtl(companion(file_, library)));
    }
    if (materials_.empty() && photographs.size() == 1) {  // some scanners leave usemtl out
      materials_.push_back(photographs.begin()->first);
      std::ranges::fill(scan_.material, 0);
    }
    for (const std::string& material : materials_) {
      const auto found = photographs.find(material);
      scan_.photographs.push_back(found == photographs.end() ? fs::path() : found->second);
      if (!libraries_.empty() && found == photographs.end()) {
        scan_.notes.push_back(fmt::format(
            "the material '{}' is not described: its faces have no photograph", material));
      }
    }
  }

  void finish_colours() {
    if (scan_.point_colour.empty()) {
      return;
    }
    scan_.point_colour.resize(scan_.points.size());
    float brightest = 0;
    for (const Colour& colour : scan_.point_colour) {
      brightest = std::max({brightest, colour[0], colour[1], colour[2]});
    }
    const float scale = brightest <= 1.0F ? 255.0F : 1.0F;
    for (Colour& colour : scan_.point_colour) {
      for (float& channel : colour) {
        channel *= scale;
      }
    }
  }

  struct Corner {
    int point, texture;
  };
  fs::path file_;
  std::string name_;
  std::size_t line_ = 0;
  RawScan scan_;
  std::vector<Corner> corners_;
  std::vector<std::string> materials_, libraries_;
  int material_ = -1;
};

/// The file name of a map_Kd line: what is left when its options are gone.
std::string_view map_name(std::string_view line) {
  // Options take a fixed number of words; -o, -s and -t take up to three numbers.
  while (trimmed(line).starts_with('-')) {
    std::string_view rest = line;
    const std::string_view option = next_word(rest);
    int words = option == "-mm" ? 2 : 1;
    if (option == "-o" || option == "-s" || option == "-t") {
      words = 3;
    }
    for (int i = 0; i < words; ++i) {
      next_word(rest);
    }
    line = rest;
  }
  return trimmed(line);
}

}  // namespace

fs::path companion(const fs::path& scan, const std::string& name) {
  std::string portable = name;
  std::ranges::replace(portable, '\\', '/');
  const fs::path folder = fs::weakly_canonical(fs::absolute(scan)).parent_path();
  const fs::path named(portable);
  fs::path there = fs::weakly_canonical(folder / named);
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), there.begin(), there.end());
  if (named.is_absolute() || end != folder.end() || portable.find(':') != std::string::npos) {
    throw Error(Fault::Input,
                fmt::format("{}: it names a file outside its own folder, '{}'",
                            scan.filename().string(), name),
                "put the file beside the scan and name it without a folder");
  }
  if (!fs::is_regular_file(there)) {
    throw Error(
        Fault::Input,
        fmt::format("{}: the file '{}' that it names is missing", scan.filename().string(), name),
        "copy the whole folder of the scan, with material file and photographs");
  }
  return there;
}

std::map<std::string, fs::path> read_mtl(const fs::path& file) {
  std::map<std::string, fs::path> photographs;
  std::string material;
  for_each_line(read_text(file), [&](std::string_view line, std::size_t) {
    const std::string_view key = next_word(line);
    if (key == "newmtl") {
      material = trimmed(line);
      photographs[material];
    } else if (key == "map_Kd" || key == "map_kd") {
      photographs[material] = companion(file, std::string(map_name(line)));
    }
  });
  return photographs;
}

RawScan read_obj(const fs::path& file) {
  return ObjReader(file).read();
}

}  // namespace sanatrix::io
