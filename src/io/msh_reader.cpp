// Gmsh meshes by the Gmsh library: physical groups become regions, boundaries and named points.
#include <cstdlib>
#include <exception>
#include <fstream>
#include <unordered_map>

#include <gmsh.h>

#include "core/error.hpp"
#include "io/mesh_file.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

constexpr int triangle3 = 2, tetrahedron4 = 4;  // Gmsh's element type numbers

/// The Gmsh library is one global model; this opens it for one file and leaves nothing behind.
class GmshSession {
 public:
  explicit GmshSession(const fs::path& file) {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    try {
      gmsh::open(file.string());
    } catch (...) {
      gmsh::finalize();
      throw;
    }
  }
  ~GmshSession() { gmsh::finalize(); }
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;
};

struct Entity {
  int tag;
  std::vector<int> groups;  ///< physical groups it belongs to
};

std::vector<Entity> entities_of(int dimension) {
  gmsh::vectorpair found;
  gmsh::model::getEntities(found, dimension);
  std::vector<Entity> entities;
  for (const auto& [unused, tag] : found) {
    Entity entity{tag, {}};
    gmsh::model::getPhysicalGroupsForEntity(dimension, tag, entity.groups);
    for (int& group : entity.groups) {
      group = std::abs(group);  // the sign is the orientation
    }
    entities.push_back(std::move(entity));
  }
  return entities;
}

std::string name_of(int dimension, int group, const char* prefix) {
  std::string name;
  gmsh::model::getPhysicalName(dimension, group, name);
  return name.empty() ? fmt::format("{}_{}", prefix, group) : name;
}

int index_of(std::vector<std::string>& names, const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) {
      return static_cast<int>(i);
    }
  }
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

/// Node tags of the entity's elements, which must all be of one linear type.
std::vector<std::size_t> element_nodes(int dimension, int entity, int wanted_type,
                                       const char* wanted_name, const std::string& file) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, dimension, entity);
  for (const int type : types) {
    require(type == wanted_type,
            "{}: entity {} of dimension {} has elements of Gmsh type {}; only linear {} are read "
            "(mesh it with order 1)",
            file, entity, dimension, type, wanted_name);
  }
  return nodes.empty() ? std::vector<std::size_t>{} : nodes.front();
}

/// Turns Gmsh's node tags into vertices; only nodes of tetrahedra become vertices.
class Reader {
 public:
  Reader(std::string file, double scale) : file_(std::move(file)) {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates, unused;
    gmsh::model::mesh::getNodes(tags, coordinates, unused);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      positions_[tags[i]] =
          scale * Vec3{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    }
  }

  TetMesh read() {
    read_cells();
    require(!mesh_.cells.empty(), "{} has no tetrahedra: it needs a meshed volume", file_);
    read_faces();
    read_named_points();
    check_and_orient(mesh_, file_);
    return std::move(mesh_);
  }

 private:
  void read_cells() {
    for (const Entity& volume : entities_of(3)) {
      require(volume.groups.size() <= 1,
              "{}: volume {} belongs to {} physical volumes, so its tissue is not known", file_,
              volume.tag, volume.groups.size());
      const auto nodes = element_nodes(3, volume.tag, tetrahedron4, "tetrahedra", file_);
      if (nodes.empty()) {
        continue;
      }
      const int region = index_of(mesh_.region_names, volume.groups.empty()
                                                          ? fmt::format("region_{}", volume.tag)
                                                          : name_of(3, volume.groups[0], "region"));
      for (std::size_t i = 0; i < nodes.size(); i += 4) {
        mesh_.cells.push_back({add_vertex(nodes[i]), add_vertex(nodes[i + 1]),
                               add_vertex(nodes[i + 2]), add_vertex(nodes[i + 3])});
        mesh_.region.push_back(region);
      }
    }
  }

  void read_faces() {
    for (const Entity& surface : entities_of(2)) {
      for (const int group : surface.groups) {
        const int name = index_of(mesh_.boundary_names, name_of(2, group, "boundary"));
        const auto nodes = element_nodes(2, surface.tag, triangle3, "triangles", file_);
        for (std::size_t i = 0; i < nodes.size(); i += 3) {
          mesh_.faces.push_back(
              {{vertex_of(nodes[i]), vertex_of(nodes[i + 1]), vertex_of(nodes[i + 2])}, name});
        }
      }
    }
  }

  /// A group of several points gives "name_1", "name_2", ... in the order of their tags.
  void read_named_points() {
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups, 0);
    for (const auto& [dimension, group] : groups) {
      std::vector<int> points;
      gmsh::model::getEntitiesForPhysicalGroup(0, group, points);
      const std::string name = name_of(0, group, "point");
      for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<std::size_t> tags;
        std::vector<double> coordinates, unused;
        gmsh::model::mesh::getNodes(tags, coordinates, unused, 0, points[i]);
        require(tags.size() == 1, "{}: physical point '{}' has no mesh node", file_, name);
        mesh_.named_points[points.size() == 1 ? name : fmt::format("{}_{}", name, i + 1)] =
            vertex_of(tags.front());
      }
    }
  }

  int add_vertex(std::size_t tag) {
    const auto [found, is_new] = vertices_.try_emplace(tag, static_cast<int>(mesh_.points.size()));
    if (is_new) {
      const auto position = positions_.find(tag);
      require(position != positions_.end(), "{}: node {} is used but not given", file_, tag);
      mesh_.points.push_back(position->second);
    }
    return found->second;
  }

  int vertex_of(std::size_t tag) const {
    const auto found = vertices_.find(tag);
    require(found != vertices_.end(),
            "{}: node {} of a physical surface or point belongs to no tetrahedron", file_, tag);
    return found->second;
  }

  std::string file_;
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
  const auto broken = [&](const std::string& cause) {
    return Error(Fault::Input, fmt::format("cannot read mesh {}: {}", file.string(), cause),
                 "save it again from Gmsh as format 4.1 or 2.2");
  };
  try {
    const GmshSession session(file);
    return Reader(file.string(), unit == LengthUnit::Millimetre ? 1e-3 : 1.0).read();
  } catch (const std::string& gmsh_message) {  // what the Gmsh library throws
    throw broken(gmsh_message);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw broken(e.what());
  }
}

}  // namespace sanatrix::io
