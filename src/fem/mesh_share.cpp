#include "fem/mesh_share.hpp"

#include <algorithm>
#include <array>

#include <petscdmplex.h>
#include <petscsf.h>

#include "fem/petsc_check.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {

namespace {

std::size_t index(PetscInt i) {
  return static_cast<std::size_t>(i);
}

/// The names of rank 0, on every rank.
std::vector<std::string> shared_names(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) {
    joined += name + '\n';
  }
  broadcast(joined);
  std::vector<std::string> result;
  for (std::size_t at = 0; at < joined.size();) {
    const std::size_t end = joined.find('\n', at);
    result.push_back(joined.substr(at, end - at));
    at = end + 1;
  }
  return result;
}

}  // namespace

struct MeshShare::Impl {
  TetMesh mesh;
  std::vector<int> vertex, cell;
  std::vector<bool> own;  ///< per point of the plex
  PetscInt first_cell = 0, first_vertex = 0, points = 0;
  int whole_vertices = 0, whole_cells = 0;
  DM plex = nullptr;
  PetscSF owners = nullptr;  ///< of the plex; not ours to destroy
  PetscSF vertex_owners = nullptr;

  ~Impl() {
    PetscSFDestroy(&vertex_owners);
    DMDestroy(&plex);
  }
  /// Copies values from one plex's points to those that the migration made of them.
  static std::vector<PetscInt> follow(PetscSF migration, std::vector<PetscInt> values,
                                      PetscInt points);
  void make_plex(const TetMesh& whole);
  std::vector<PetscInt> mark_faces(const TetMesh& whole) const;
  void take_names(const TetMesh& whole);
  void take_cells(const std::vector<PetscInt>& origin, const std::vector<PetscInt>& region);
  void take_faces(const std::vector<PetscInt>& boundary);
  void take_points(const std::vector<PetscInt>& point_name);
  void find_owners();
  [[nodiscard]] std::array<int, 4> vertices_of(PetscInt point) const;
};

std::vector<PetscInt> MeshShare::Impl::follow(PetscSF migration, std::vector<PetscInt> values,
                                              PetscInt points) {
  if (migration == nullptr) {  // one process: nothing moved
    return values;
  }
  std::vector<PetscInt> moved(index(points), -1);
  check(PetscSFBcastBegin(migration, MPIU_INT, values.data(), moved.data(), MPI_REPLACE),
        "distributing the mesh");
  check(PetscSFBcastEnd(migration, MPIU_INT, values.data(), moved.data(), MPI_REPLACE),
        "distributing the mesh");
  return moved;
}

void MeshShare::Impl::make_plex(const TetMesh& whole) {
  const bool leads = rank() == 0;
  std::vector<PetscInt> cells;
  std::vector<PetscReal> coordinates;
  for (const auto& c : leads ? whole.cells : std::vector<std::array<int, 4>>{}) {
    cells.insert(cells.end(), c.begin(), c.end());
  }
  for (const Vec3& p : leads ? whole.points : std::vector<Vec3>{}) {
    coordinates.insert(coordinates.end(), {p[0], p[1], p[2]});
  }
  check(DMPlexCreateFromCellListPetsc(PETSC_COMM_WORLD, 3, static_cast<PetscInt>(cells.size() / 4),
                                      static_cast<PetscInt>(coordinates.size() / 3), 4, PETSC_TRUE,
                                      cells.data(), 3, coordinates.data(), &plex),
        "building the mesh's topology");
}

/// Per point of the undistributed plex the boundary name of a face, else -1.
std::vector<PetscInt> MeshShare::Impl::mark_faces(const TetMesh& whole) const {
  std::vector<PetscInt> name(index(points), -1);
  if (rank() != 0) {
    return name;
  }
  for (const BoundaryFace& face : whole.faces) {
    std::array<PetscInt, 3> corners{};
    std::ranges::transform(face.vertex, corners.begin(), [&](int v) { return first_vertex + v; });
    PetscInt count = 0;
    const PetscInt* found = nullptr;
    check(DMPlexGetFullJoin(plex, 3, corners.data(), &count, &found), "looking for a face");
    if (count == 1) {
      name[index(found[0])] = face.name;
    }
    check(DMPlexRestoreJoin(plex, 3, corners.data(), &count, &found), "looking for a face");
  }
  return name;
}

void MeshShare::Impl::take_names(const TetMesh& whole) {
  mesh.region_names = shared_names(whole.region_names);
  mesh.boundary_names = shared_names(whole.boundary_names);
  std::vector<std::string> points_named;
  for (const auto& [name, unused] : whole.named_points) {
    points_named.push_back(name);
  }
  for (const std::string& name : shared_names(points_named)) {
    mesh.named_points[name] = -1;
  }
}

/// Vertices of a cell or face in the local mesh, in the plex's order; -1 beyond its corners.
std::array<int, 4> MeshShare::Impl::vertices_of(PetscInt point) const {
  std::array<int, 4> corners{-1, -1, -1, -1};
  PetscInt size = 0;
  PetscInt* closure = nullptr;
  check(DMPlexGetTransitiveClosure(plex, point, PETSC_TRUE, &size, &closure), "reading a cell");
  std::size_t n = 0;
  for (PetscInt i = 0; i < size; ++i) {
    const PetscInt p = closure[2 * i];
    if (p >= first_vertex && p < first_vertex + static_cast<PetscInt>(vertex.size())) {
      corners.at(n++) = static_cast<int>(p - first_vertex);
    }
  }
  check(DMPlexRestoreTransitiveClosure(plex, point, PETSC_TRUE, &size, &closure), "reading a cell");
  return corners;
}

void MeshShare::Impl::take_cells(const std::vector<PetscInt>& origin,
                                 const std::vector<PetscInt>& region) {
  PetscInt end = 0;
  check(DMPlexGetDepthStratum(plex, 0, &first_vertex, &end), "reading the vertices");
  for (PetscInt p = first_vertex; p < end; ++p) {
    vertex.push_back(static_cast<int>(origin[index(p)]));
  }
  Vec coordinates = nullptr;
  PetscSection section = nullptr;
  check(DMGetCoordinatesLocal(plex, &coordinates), "reading the vertices");
  check(DMGetCoordinateSection(plex, &section), "reading the vertices");
  const PetscScalar* x = nullptr;
  check(VecGetArrayRead(coordinates, &x), "reading the vertices");
  for (PetscInt p = first_vertex; p < end; ++p) {
    PetscInt at = 0;
    check(PetscSectionGetOffset(section, p, &at), "reading the vertices");
    mesh.points.push_back({x[at], x[at + 1], x[at + 2]});
  }
  check(VecRestoreArrayRead(coordinates, &x), "reading the vertices");
  check(DMPlexGetHeightStratum(plex, 0, &first_cell, &end), "reading the cells");
  for (PetscInt p = first_cell; p < end; ++p) {
    std::array<int, 4> corners = vertices_of(p);
    const auto at = [&](std::size_t i) {
      return mesh.points[index(corners[i])];
    };
    if (volume(at(0), at(1), at(2), at(3)) < 0.0) {
      std::swap(corners[2], corners[3]);
    }
    mesh.cells.push_back(corners);
    mesh.region.push_back(static_cast<int>(region[index(p)]));
    cell.push_back(static_cast<int>(origin[index(p)]));
  }
}

/// Named faces, turned outwards from the cell behind them.
void MeshShare::Impl::take_faces(const std::vector<PetscInt>& boundary) {
  PetscInt begin = 0;
  PetscInt end = 0;
  check(DMPlexGetHeightStratum(plex, 1, &begin, &end), "reading the faces");
  for (PetscInt p = begin; p < end; ++p) {
    if (boundary[index(p)] < 0) {
      continue;
    }
    const auto corners = vertices_of(p);
    BoundaryFace face{{corners[0], corners[1], corners[2]}, static_cast<int>(boundary[index(p)])};
    const PetscInt* behind = nullptr;
    check(DMPlexGetSupport(plex, p, &behind), "reading the faces");
    Vec3 inside{};
    for (const int v : mesh.cells[index(behind[0] - first_cell)]) {
      inside += 0.25 * mesh.points[index(v)];
    }
    const auto& [a, b, c] = face.vertex;
    if (volume(mesh.points[index(a)], mesh.points[index(b)], mesh.points[index(c)], inside) > 0.0) {
      std::swap(face.vertex[1], face.vertex[2]);
    }
    mesh.faces.push_back(face);
  }
}

void MeshShare::Impl::take_points(const std::vector<PetscInt>& point_name) {
  std::vector<int*> by_number;
  for (auto& [name, at] : mesh.named_points) {
    by_number.push_back(&at);
  }
  for (std::size_t v = 0; v < vertex.size(); ++v) {
    const PetscInt p = first_vertex + static_cast<PetscInt>(v);
    if (own[index(p)] && point_name[index(p)] >= 0) {
      *by_number[index(point_name[index(p)])] = static_cast<int>(v);
    }
  }
}

/// Which points are own, and the owners of the other vertices.
void MeshShare::Impl::find_owners() {
  check(DMGetPointSF(plex, &owners), "reading the owners");
  own.assign(index(points), true);
  PetscInt roots = 0;
  PetscInt leaves = 0;
  const PetscInt* leaf = nullptr;
  const PetscSFNode* root = nullptr;
  check(PetscSFGetGraph(owners, &roots, &leaves, &leaf, &root), "reading the owners");
  std::vector<PetscInt> first(index(ranks()));  // vertex of every rank
  MPI_Allgather(&first_vertex, 1, MPIU_INT, first.data(), 1, MPIU_INT, PETSC_COMM_WORLD);
  const auto vertices = static_cast<PetscInt>(vertex.size());
  std::vector<PetscInt> ghosts;
  std::vector<PetscSFNode> there;
  for (PetscInt i = 0; i < leaves; ++i) {
    const PetscInt p = leaf != nullptr ? leaf[i] : i;
    own[index(p)] = false;
    if (p >= first_vertex && p < first_vertex + vertices) {
      ghosts.push_back(p - first_vertex);
      there.push_back({root[i].rank, root[i].index - first[index(root[i].rank)]});
    }
  }
  check(PetscSFCreate(PETSC_COMM_WORLD, &vertex_owners), "reading the owners");
  check(PetscSFSetGraph(vertex_owners, vertices, static_cast<PetscInt>(ghosts.size()),
                        ghosts.data(), PETSC_COPY_VALUES, there.data(), PETSC_COPY_VALUES),
        "reading the owners");
}

MeshShare::MeshShare(const TetMesh& whole, int layers) : impl_(std::make_unique<Impl>()) {
  Impl& share = *impl_;
  share.take_names(whole);
  share.make_plex(whole);
  check(DMPlexGetChart(share.plex, nullptr, &share.points), "reading the mesh");
  const auto cells = static_cast<PetscInt>(rank() == 0 ? whole.cells.size() : 0);
  const auto vertices = static_cast<PetscInt>(rank() == 0 ? whole.points.size() : 0);
  share.first_vertex = cells;  // as DMPlexCreateFromCellListPetsc numbers them
  share.whole_cells = static_cast<int>(sum(static_cast<double>(cells)));
  share.whole_vertices = static_cast<int>(sum(static_cast<double>(vertices)));
  std::vector<PetscInt> origin(index(share.points), -1);
  std::vector<PetscInt> region(index(share.points), -1);
  std::vector<PetscInt> point_name(index(share.points), -1);
  for (PetscInt c = 0; c < cells; ++c) {
    origin[index(c)] = c;
    region[index(c)] = whole.region[index(c)];
  }
  for (PetscInt v = 0; v < vertices; ++v) {
    origin[index(cells + v)] = v;
  }
  PetscInt number = 0;
  for (const auto& [name, v] : rank() == 0 ? whole.named_points : std::map<std::string, int>{}) {
    point_name[index(cells + v)] = number++;
  }
  const std::vector<PetscInt> boundary = share.mark_faces(whole);

  PetscPartitioner partitioner = nullptr;
  check(DMPlexGetPartitioner(share.plex, &partitioner), "choosing the partitioner");
  check(PetscPartitionerSetType(partitioner, PETSCPARTITIONERPTSCOTCH), "choosing the partitioner");
  PetscSF migration = nullptr;
  DM distributed = nullptr;
  check(DMPlexDistribute(share.plex, layers, &migration, &distributed), "distributing the mesh");
  if (distributed != nullptr) {
    check(DMDestroy(&share.plex), "distributing the mesh");
    share.plex = distributed;
  }
  check(DMPlexGetChart(share.plex, nullptr, &share.points), "reading the mesh");
  const auto follow = [&](std::vector<PetscInt> values) {
    return Impl::follow(migration, std::move(values), share.points);
  };
  share.take_cells(follow(origin), follow(region));
  share.find_owners();
  share.take_faces(follow(boundary));
  share.take_points(follow(point_name));
  PetscSFDestroy(&migration);
}

MeshShare::~MeshShare() = default;

const TetMesh& MeshShare::mesh() const {
  return impl_->mesh;
}
const std::vector<int>& MeshShare::vertex() const {
  return impl_->vertex;
}
const std::vector<int>& MeshShare::cell() const {
  return impl_->cell;
}
bool MeshShare::owns_vertex(int v) const {
  return impl_->own[index(impl_->first_vertex + v)];
}
bool MeshShare::owns_cell(int c) const {
  return impl_->own[index(impl_->first_cell + c)];
}
int MeshShare::whole_vertices() const {
  return impl_->whole_vertices;
}
int MeshShare::whole_cells() const {
  return impl_->whole_cells;
}

Layout MeshShare::layout(const EdgeTable& edges) const {
  std::vector<PetscInt> point;  // of every node
  std::vector<Vec3> position = impl_->mesh.points;
  for (std::size_t v = 0; v < position.size(); ++v) {
    point.push_back(impl_->first_vertex + static_cast<PetscInt>(v));
  }
  for (const auto& [a, b] : edges.edges) {
    const std::array<PetscInt, 2> ends{impl_->first_vertex + a, impl_->first_vertex + b};
    PetscInt count = 0;
    const PetscInt* found = nullptr;
    check(DMPlexGetJoin(impl_->plex, 2, ends.data(), &count, &found), "looking for an edge");
    ensure(count == 1, "an edge of a cell is no edge of the mesh");
    point.push_back(found[0]);
    check(DMPlexRestoreJoin(impl_->plex, 2, ends.data(), &count, &found), "looking for an edge");
    position.push_back(0.5 * (position[index(a)] + position[index(b)]));
  }
  std::vector<int> mine;
  for (std::size_t n = 0; n < point.size(); ++n) {
    if (impl_->own[index(point[n])]) {
      mine.push_back(static_cast<int>(n));
    }
  }
  order_by_place(position, mine);
  Layout layout;
  const auto count = static_cast<int>(mine.size());
  MPI_Exscan(&count, &layout.own_begin, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(&count, &layout.total, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  layout.own_end = layout.own_begin + count;
  std::vector<PetscInt> number(index(impl_->points), -1);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    number[index(point[index(mine[i])])] = layout.own_begin + static_cast<PetscInt>(i);
  }
  if (ranks() > 1) {
    check(PetscSFBcastBegin(impl_->owners, MPIU_INT, number.data(), number.data(), MPI_REPLACE),
          "numbering the nodes");
    check(PetscSFBcastEnd(impl_->owners, MPIU_INT, number.data(), number.data(), MPI_REPLACE),
          "numbering the nodes");
  }
  for (const PetscInt p : point) {
    layout.global.push_back(static_cast<int>(number[index(p)]));
  }
  return layout;
}

void MeshShare::fetch(std::vector<std::uint8_t>& per_vertex) const {
  std::vector<double> values(per_vertex.begin(), per_vertex.end());
  fetch(values, 1);
  per_vertex.assign(values.begin(), values.end());
}

void MeshShare::fetch(std::span<double> per_vertex, int width) const {
  ensure(per_vertex.size() == index(width) * impl_->vertex.size(), "{} values for {} vertices",
         per_vertex.size(), impl_->vertex.size());
  if (ranks() == 1) {
    return;
  }
  MPI_Datatype row = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(width, MPI_DOUBLE, &row);
  MPI_Type_commit(&row);
  double* const values = per_vertex.data();
  check(PetscSFBcastBegin(impl_->vertex_owners, row, values, values, MPI_REPLACE),
        "fetching from the owners");
  check(PetscSFBcastEnd(impl_->vertex_owners, row, values, values, MPI_REPLACE),
        "fetching from the owners");
  MPI_Type_free(&row);
}

}  // namespace sanatrix::fem
