// The Gmsh library, loaded when the first mesh is read: it brings sixty others (CAD kernels,
// windows) whose start would cost every command a third of a second.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace sanatrix::io {

/// One .msh file, open in Gmsh's only model: no two at a time. Numbers are Gmsh's own. All of it
/// throws Fault::Input with what Gmsh says of the file, and Fault::Resource where Gmsh is missing.
class GmshFile {
 public:
  struct Nodes {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates;  ///< 3 a node, in the file's unit
  };
  struct Elements {
    int type;
    std::vector<std::size_t> nodes;  ///< tags, element by element
  };

  explicit GmshFile(const std::filesystem::path& file);
  ~GmshFile();
  GmshFile(const GmshFile&) = delete;
  GmshFile& operator=(const GmshFile&) = delete;

  [[nodiscard]] std::vector<int> entities(int dimension) const;
  /// Physical groups of a dimension, of an entity, and the entities of a group.
  [[nodiscard]] std::vector<int> groups(int dimension) const;
  [[nodiscard]] std::vector<int> groups_of(int dimension, int entity) const;
  [[nodiscard]] std::vector<int> members(int dimension, int group) const;
  [[nodiscard]] std::string group_name(int dimension, int group) const;  ///< may be empty
  /// Of an entity, or all.
  [[nodiscard]] Nodes nodes(int dimension = -1, int entity = -1) const;
  [[nodiscard]] std::vector<Elements> elements_of(int dimension, int entity) const;

 private:
  void check(int error) const;
  template <class Call>
  [[nodiscard]] std::vector<int> integers(const Call& call) const;

  std::string name_;
};

}  // namespace sanatrix::io
