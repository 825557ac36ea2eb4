// A Gmsh file as it stands: nodes, elements by entity and physical group, names.
#pragma once

#include <compare>
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix::io {

/// Elements of one kind on one entity of the model, as members of one physical group.
struct MshPart {
  int dimension, entity;
  int group;  ///< 0: none; without its sign, which is an orientation
  int type;   ///< Gmsh's number of the kind of element
  auto operator<=>(const MshPart&) const = default;
};

struct MshFile {
  std::unordered_map<std::size_t, Vec3> nodes;  ///< by tag, in the file's unit
  /// Node tags, element by element, in the order of the file. What belongs to two groups is in two
  /// parts. Not every tag needs to be among the nodes.
  std::map<MshPart, std::vector<std::size_t>> parts;
  std::map<std::pair<int, int>, std::string> group_names;  ///< by dimension and group
};

/// Formats 2 and 4.1, text or binary in this machine's byte order, linear elements. Error{Input}
/// names the file, the line or byte, and what is wrong there.
MshFile read_msh_file(const std::filesystem::path& file);

}  // namespace sanatrix::io
