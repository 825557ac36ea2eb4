#include "io/gmsh_library.hpp"

#include <dlfcn.h>
#include <gmshc.h>

#include "core/error.hpp"

namespace sanatrix::io {
namespace {

struct Library {
  decltype(&gmshFree) free;
  decltype(&gmshInitialize) initialize;
  decltype(&gmshFinalize) finalize;
  decltype(&gmshOpen) open;
  decltype(&gmshOptionSetNumber) set_number;
  decltype(&gmshLoggerGetLastError) last_error;
  decltype(&gmshModelGetEntities) entities;
  decltype(&gmshModelGetPhysicalGroups) groups;
  decltype(&gmshModelGetPhysicalGroupsForEntity) groups_of;
  decltype(&gmshModelGetEntitiesForPhysicalGroup) members;
  decltype(&gmshModelGetPhysicalName) name;
  decltype(&gmshModelMeshGetNodes) nodes;
  decltype(&gmshModelMeshGetElements) elements;
};

Library load() {
  // Never closed: its libraries do not all survive being loaded twice.
  void* const handle = ::dlopen(SANATRIX_GMSH_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
  const auto find = [&](auto& function, const char* name) {
    void* const symbol = handle == nullptr ? nullptr : ::dlsym(handle, name);
    if (symbol == nullptr) {
      throw Error(Fault::Resource,
                  fmt::format("the Gmsh library cannot be loaded: {}", ::dlerror()),
                  "install Debian's package libgmsh-dev");
    }
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(symbol);
  };
  Library g{};
  find(g.free, "gmshFree");
  find(g.initialize, "gmshInitialize");
  find(g.finalize, "gmshFinalize");
  find(g.open, "gmshOpen");
  find(g.set_number, "gmshOptionSetNumber");
  find(g.last_error, "gmshLoggerGetLastError");
  find(g.entities, "gmshModelGetEntities");
  find(g.groups, "gmshModelGetPhysicalGroups");
  find(g.groups_of, "gmshModelGetPhysicalGroupsForEntity");
  find(g.members, "gmshModelGetEntitiesForPhysicalGroup");
  find(g.name, "gmshModelGetPhysicalName");
  find(g.nodes, "gmshModelMeshGetNodes");
  find(g.elements, "gmshModelMeshGetElements");
  return g;
}

const Library& gmsh() {
  static const Library library = load();
  return library;
}

/// An array that Gmsh has allocated.
template <class T>
struct Array {
  T* data = nullptr;
  std::size_t size = 0;

  Array() = default;
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  ~Array() {
    if (data != nullptr) {
      gmsh().free(data);
    }
  }
  [[nodiscard]] std::vector<T> copy() const { return {data, data + size}; }
};

/// An array of arrays.
struct Table {
  Array<std::size_t*> rows;
  Array<std::size_t> sizes;
  std::size_t sizes_count = 0;

  Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  ~Table() {
    for (std::size_t i = 0; i < sizes_count; ++i) {
      gmsh().free(rows.data[i]);
    }
  }
};

/// Tags of (dimension, tag) after (dimension, tag).
std::vector<int> second_of_pairs(const std::vector<int>& pairs) {
  std::vector<int> tags;
  for (std::size_t i = 1; i < pairs.size(); i += 2) {
    tags.push_back(pairs[i]);
  }
  return tags;
}

}  // namespace

void GmshFile::check(int error) const {
  if (error != 0) {
    Array<char> text;
    int unused = 0;
    gmsh().last_error(&text.data, &unused);
    const bool silent = text.data == nullptr || *text.data == 0;
    throw Error(
        Fault::Input,
        fmt::format("cannot read mesh {}: {}", name_, silent ? "Gmsh refuses it" : text.data),
        "save it again from Gmsh as format 4.1 or 2.2");
  }
}

GmshFile::GmshFile(const std::filesystem::path& file) : name_(file.string()) {
  int error = 0;
  gmsh().initialize(0, nullptr, 0, &error);
  check(error);
  gmsh().set_number("General.Terminal", 0, &error);
  gmsh().open(file.c_str(), &error);
  try {
    check(error);
  } catch (...) {
    gmsh().finalize(&error);
    throw;
  }
}

GmshFile::~GmshFile() {
  int unused = 0;
  gmsh().finalize(&unused);
}

/// The integers that a call of Gmsh gives, by (data, size, error).
template <class Call>
std::vector<int> GmshFile::integers(const Call& call) const {
  Array<int> found;
  int error = 0;
  call(&found.data, &found.size, &error);
  check(error);
  return found.copy();
}

std::vector<int> GmshFile::entities(int dimension) const {
  return second_of_pairs(integers([&](int** data, std::size_t* size, int* error) {
    gmsh().entities(data, size, dimension, error);
  }));
}

std::vector<int> GmshFile::groups(int dimension) const {
  return second_of_pairs(integers([&](int** data, std::size_t* size, int* error) {
    gmsh().groups(data, size, dimension, error);
  }));
}

std::vector<int> GmshFile::groups_of(int dimension, int entity) const {
  return integers([&](int** data, std::size_t* size, int* error) {
    gmsh().groups_of(dimension, entity, data, size, error);
  });
}

std::vector<int> GmshFile::members(int dimension, int group) const {
  return integers([&](int** data, std::size_t* size, int* error) {
    gmsh().members(dimension, group, data, size, error);
  });
}

std::string GmshFile::group_name(int dimension, int group) const {
  Array<char> name;
  int error = 0;
  gmsh().name(dimension, group, &name.data, &error);
  check(error);
  return name.data == nullptr ? "" : name.data;
}

GmshFile::Nodes GmshFile::nodes(int dimension, int entity) const {
  Array<std::size_t> tags;
  Array<double> coordinates, unused;
  int error = 0;
  gmsh().nodes(&tags.data, &tags.size, &coordinates.data, &coordinates.size, &unused.data,
               &unused.size, dimension, entity, 0, 0, &error);
  check(error);
  return {tags.copy(), coordinates.copy()};
}

std::vector<GmshFile::Elements> GmshFile::elements_of(int dimension, int entity) const {
  Array<int> types;
  Table tags, nodes;
  int error = 0;
  gmsh().elements(&types.data, &types.size, &tags.rows.data, &tags.sizes.data, &tags.sizes_count,
                  &nodes.rows.data, &nodes.sizes.data, &nodes.sizes_count, dimension, entity,
                  &error);
  check(error);
  std::vector<Elements> elements;
  for (std::size_t i = 0; i < types.size; ++i) {
    const std::size_t* const row = nodes.rows.data[i];
    elements.push_back({types.data[i], {row, row + nodes.sizes.data[i]}});
  }
  return elements;
}

}  // namespace sanatrix::io
