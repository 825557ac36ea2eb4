// Gmsh meshes by the Gmsh library: physical groups become regions, boundaries and named points.
#include <cstdlib>
#include <fstream>
#include <unordered_map>

#include "core/error.hpp"
#include "io/gmsh_library.hpp"
#include "io/mesh_file.hpp"

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
  Reader(std::string name, const GmshFile& file, double scale)
      : name_(std::move(name)), file_(file) {
    const auto [tags, at] = file.nodes();
    for (std::size_t i = 0; i < tags.size(); ++i) {
      positions_[tags[i]] = scale * Vec3{at[3 * i], at[3 * i + 1], at[3 * i + 2]};
    }
  }

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
    const std::string name = file_.group_name(dimension, group);
    return name.empty() ? fmt::format("{}_{}", prefix, group) : name;
  }

  /// Physical groups; the sign is the orientation and of no interest.
  [[nodiscard]] std::vector<int> groups_of(int dimension, int entity) const {
    std::vector<int> groups = file_.groups_of(dimension, entity);
    for (int& group : groups) {
      group = std::abs(group);
    }
    return groups;
  }

  /// Node tags of the entity's elements, which must all be of one linear type.
  [[nodiscard]] std::vector<std::size_t> element_nodes(int dimension, int entity, int wanted_type,
                                                       const char* wanted_name) const {
    auto all = file_.elements_of(dimension, entity);
    for (const GmshFile::Elements& elements : all) {
      require(elements.type == wanted_type,
              "{}: entity {} of dimension {} has elements of Gmsh type {}; only linear {} are read "
              "(mesh it with order 1)",
              name_, entity, dimension, elements.type, wanted_name);
    }
    return all.empty() ? std::vector<std::size_t>{} : std::move(all.front().nodes);
  }

  void read_cells() {
    for (const int volume : file_.entities(3)) {
      const std::vector<int> groups = groups_of(3, volume);
      require(groups.size() <= 1,
              "{}: volume {} belongs to {} physical volumes, so its tissue is not known", name_,
              volume, groups.size());
      const auto nodes = element_nodes(3, volume, tetrahedron4, "tetrahedra");
      if (nodes.empty()) {
        continue;
      }
      const int region =
          index_of(mesh_.region_names, groups.empty() ? fmt::format("region_{}", volume)
                                                      : name_of(3, groups[0], "region"));
      for (std::size_t i = 0; i < nodes.size(); i += 4) {
        mesh_.cells.push_back({add_vertex(nodes[i]), add_vertex(nodes[i + 1]),
                               add_vertex(nodes[i + 2]), add_vertex(nodes[i + 3])});
        mesh_.region.push_back(region);
      }
    }
  }

  void read_faces() {
    for (const int surface : file_.entities(2)) {
      for (const int group : groups_of(2, surface)) {
        const int name = index_of(mesh_.boundary_names, name_of(2, group, "boundary"));
        const auto nodes = element_nodes(2, surface, triangle3, "triangles");
        for (std::size_t i = 0; i < nodes.size(); i += 3) {
          mesh_.faces.push_back(
              {{vertex_of(nodes[i]), vertex_of(nodes[i + 1]), vertex_of(nodes[i + 2])}, name});
        }
      }
    }
  }

  /// A group of several points gives "name_1", "name_2", ... in the order of their tags.
  void read_named_points() {
    for (const int group : file_.groups(0)) {
      const std::vector<int> points = file_.members(0, group);
      const std::string name = name_of(0, group, "point");
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto tags = file_.nodes(0, points[i]).tags;
        require(tags.size() == 1, "{}: physical point '{}' has no mesh node", name_, name);
        mesh_.named_points[points.size() == 1 ? name : fmt::format("{}_{}", name, i + 1)] =
            vertex_of(tags.front());
      }
    }
  }

  int add_vertex(std::size_t tag) {
    const auto [found, is_new] = vertices_.try_emplace(tag, static_cast<int>(mesh_.points.size()));
    if (is_new) {
      const auto position = positions_.find(tag);
      require(position != positions_.end(), "{}: node {} is used but not given", name_, tag);
      mesh_.points.push_back(position->second);
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
  const GmshFile& file_;
  TetMesh mesh_;
  std::unordered_map<std::size_t, Vec3> positions_;
  std::unordered_map<std::size_t, int> vertices_;
};

/// Gmsh would run a .geo script or guess other formats; only msh is wanted.
void require_msh(const fs::path& file) {
  require(fs::is_regular_file(file), "mesh {} does not exist", file.string());
  std::string first;
  std::ifstream in(file);
  std::getline(in, first);
  require(first.starts_with("$MeshFormat"),
          "{} is not a Gmsh mesh: it does not begin with $MeshFormat", file.string());
}

}  // namespace

TetMesh read_msh(const fs::path& file, LengthUnit unit) {
  require_msh(file);
  const GmshFile open(file);
  return Reader(file.string(), open, unit == LengthUnit::Millimetre ? 1e-3 : 1.0).read();
}

}  // namespace sanatrix::io
