// Meshes from Gmsh files: physical groups become regions, boundaries and named points.
#include <unordered_map>

#include "core/error.hpp"
#include "io/mesh_file.hpp"
#include "io/msh_file.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr int triangle3 = 2, tetrahedron4 = 4;  // Gmsh's element type numbers

int index_of(std::vector<std::string>& names, const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) {
      return static_cast<int>(i);
    }
  }
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

/// Turns Gmsh's node tags into vertices; only nodes of tetrahedra become vertices.
class Reader {
 public:
  Reader(std::string name, const MshFile& file, double scale)
      : name_(std::move(name)), file_(file), scale_(scale) {}

  TetMesh read() {
    read_cells();
    require(!mesh_.cells.empty(), "{} has no tetrahedra: it needs a meshed volume", name_);
    read_faces();
    read_named_points();
    check_and_orient(mesh_, name_);
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] std::string name_of(int dimension, int group, const char* prefix) const {
    const auto name = file_.group_names.find({dimension, group});
    return name == file_.group_names.end() || name->second.empty()
               ? fmt::format("{}_{}", prefix, group)
               : name->second;
  }

  void require_type(const MshPart& part, int wanted, const char* wanted_name) const {
    require(part.type == wanted,
            "{}: entity {} of dimension {} has elements of Gmsh type {}; only linear {} are read",
            name_, part.entity, part.dimension, part.type, wanted_name);
  }

  void read_cells() {
    std::map<int, int> groups;  // of volumes
    for (const auto& [part, nodes] : file_.parts) {
      if (part.dimension != 3) {
        continue;
      }
      const auto [other, is_new] = groups.try_emplace(part.entity, part.group);
      require(other->second == part.group,
              "{}: volume {} belongs to several physical volumes ({} and {}), so its tissue is not "
              "known",
              name_, part.entity, other->second, part.group);
      require_type(part, tetrahedron4, "tetrahedra");
      const int region =
          index_of(mesh_.region_names, part.group == 0 ? fmt::format("region_{}", part.entity)
                                                       : name_of(3, part.group, "region"));
      for (std::size_t i = 0; i < nodes.size(); i += 4) {
        mesh_.cells.push_back({add_vertex(nodes[i]), add_vertex(nodes[i + 1]),
                               add_vertex(nodes[i + 2]), add_vertex(nodes[i + 3])});
        mesh_.region.push_back(region);
      }
    }
  }

  void read_faces() {
    for (const auto& [part, nodes] : file_.parts) {
      if (part.dimension != 2 || part.group == 0) {
        continue;
      }
      require_type(part, triangle3, "triangles");
      const int name = index_of(mesh_.boundary_names, name_of(2, part.group, "boundary"));
      for (std::size_t i = 0; i < nodes.size(); i += 3) {
        mesh_.faces.push_back(
            {{vertex_of(nodes[i]), vertex_of(nodes[i + 1]), vertex_of(nodes[i + 2])}, name});
      }
    }
  }

  /// A group of several points gives "name_1", "name_2", ... in the order of their tags.
  void read_named_points() {
    std::map<int, std::vector<std::size_t>> groups;
    for (const auto& [part, nodes] : file_.parts) {
      if (part.dimension == 0 && part.group != 0) {
        std::vector<std::size_t>& all = groups[part.group];
        all.insert(all.end(), nodes.begin(), nodes.end());
      }
    }
    for (const auto& [group, nodes] : groups) {
      const std::string name = name_of(0, group, "point");
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        mesh_.named_points[nodes.size() == 1 ? name : fmt::format("{}_{}", name, i + 1)] =
            vertex_of(nodes[i]);
      }
    }
  }

  int add_vertex(std::size_t tag) {
    const auto [found, is_new] = vertices_.try_emplace(tag, static_cast<int>(mesh_.points.size()));
    if (is_new) {
      const auto node = file_.nodes.find(tag);
      require(node != file_.nodes.end(), "{}: node {} is used but not given", name_, tag);
      mesh_.points.push_back(scale_ * node->second);
    }
    return found->second;
  }

  int vertex_of(std::size_t tag) const {
    const auto found = vertices_.find(tag);
    require(found != vertices_.end(),
            "{}: node {} of a physical surface or point belongs to no tetrahedron", name_, tag);
    return found->second;
  }

  std::string name_;
  const MshFile& file_;
  double scale_;
  TetMesh mesh_;
  std::unordered_map<std::size_t, int> vertices_;
};

}  // namespace

TetMesh read_msh(const fs::path& file, LengthUnit unit) {
  require(fs::is_regular_file(file), "mesh {} does not exist", file.string());
  const MshFile found = read_msh_file(file);
  return Reader(file.string(), found, unit == LengthUnit::Millimetre ? 1e-3 : 1.0).read();
}

}  // namespace sanatrix::io
