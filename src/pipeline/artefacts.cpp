#include "pipeline/artefacts.hpp"

#include <algorithm>
#include <sstream>

#include "core/archive.hpp"
#include "core/error.hpp"

namespace sanatrix::pipeline {
namespace {

using Integers = std::vector<std::int64_t>;

std::string join(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

template <std::size_t N>
Integers flatten_indices(const std::vector<std::array<int, N>>& rows) {
  Integers flat;
  flat.reserve(rows.size() * N);
  for (const auto& row : rows) {
    flat.insert(flat.end(), row.begin(), row.end());
  }
  return flat;
}

template <std::size_t N>
std::vector<std::array<int, N>> unflatten_indices(const Integers& flat) {
  std::vector<std::array<int, N>> rows(flat.size() / N);
  for (std::size_t i = 0; i < rows.size() * N; ++i) {
    rows[i / N][i % N] = static_cast<int>(flat[i]);
  }
  return rows;
}

template <class To, class From>
std::vector<To> cast(const std::vector<From>& values) {
  std::vector<To> result;
  result.reserve(values.size());
  for (const auto value : values) {
    result.push_back(static_cast<To>(value));
  }
  return result;
}

void put_mesh(const TetMesh& mesh, Archive& archive) {
  archive.reals["points"] = flatten(mesh.points);
  archive.integers["cells"] = flatten_indices(mesh.cells);
  archive.integers["region"] = cast<std::int64_t>(mesh.region);
  std::vector<std::array<int, 4>> faces;
  for (const BoundaryFace& face : mesh.faces) {
    faces.push_back({face.vertex[0], face.vertex[1], face.vertex[2], face.name});
  }
  archive.integers["faces"] = flatten_indices(faces);
  archive.texts["region_names"] = join(mesh.region_names);
  archive.texts["boundary_names"] = join(mesh.boundary_names);
}

TetMesh get_mesh(const Archive& archive) {
  TetMesh mesh;
  mesh.points = unflatten(archive.real("points"));
  mesh.cells = unflatten_indices<4>(archive.integer("cells"));
  mesh.region = cast<int>(archive.integer("region"));
  for (const auto& row : unflatten_indices<4>(archive.integer("faces"))) {
    mesh.faces.push_back({{row[0], row[1], row[2]}, row[3]});
  }
  mesh.region_names = split(archive.texts.at("region_names"));
  mesh.boundary_names = split(archive.texts.at("boundary_names"));
  return mesh;
}

}  // namespace

std::vector<double> flatten(std::span<const Vec3> points) {
  std::vector<double> flat;
  flat.reserve(points.size() * 3);
  for (const Vec3& p : points) {
    flat.insert(flat.end(), p.begin(), p.end());
  }
  return flat;
}

std::vector<Vec3> unflatten(std::span<const double> numbers) {
  std::vector<Vec3> points(numbers.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  }
  return points;
}

void save_model(const meshing::BreastModel& model, const std::filesystem::path& file) {
  Archive archive;
  put_mesh(model.mesh, archive);
  archive.reals["fibroglandular"] = model.fibroglandular;
  archive.integers["side"] = cast<std::int64_t>(model.side);
  archive.integers["in_breast"] = cast<std::int64_t>(model.in_breast);
  archive.reals["midline_x_m"] = {model.midline_x_m};
  archive.integers["nipple_vertex"] = {model.nipple_vertex[0], model.nipple_vertex[1]};
  archive.texts["warnings"] = join(model.warnings);
  archive.save(file);
}

meshing::BreastModel load_model(const std::filesystem::path& file) {
  const Archive archive = Archive::load(file);
  meshing::BreastModel model;
  model.mesh = get_mesh(archive);
  model.fibroglandular = archive.real("fibroglandular");
  model.side = cast<signed char>(archive.integer("side"));
  model.in_breast = cast<bool>(archive.integer("in_breast"));
  model.midline_x_m = archive.real("midline_x_m").at(0);
  const Integers& nipples = archive.integer("nipple_vertex");
  model.nipple_vertex = {static_cast<int>(nipples.at(0)), static_cast<int>(nipples.at(1))};
  model.warnings = split(archive.texts.at("warnings"));
  return model;
}

void save_shape(const SolvedShape& solved, const std::filesystem::path& file) {
  Archive archive;
  archive.reals["nodes"] = flatten(solved.shape.nodes);
  archive.reals["pressure"] = solved.shape.pressure;
  archive.reals["min_jacobian"] = {solved.min_jacobian};
  archive.reals["wall_guard"] = {solved.wall_guard};
  archive.save(file);
}

SolvedShape load_shape(const std::filesystem::path& file) {
  const Archive archive = Archive::load(file);
  return {{unflatten(archive.real("nodes")), archive.real("pressure")},
          archive.real("min_jacobian").at(0),
          archive.real("wall_guard").at(0)};
}

void save_wound(const surgery::Wound& wound, const std::filesystem::path& file) {
  Archive archive;
  archive.reals["fraction"] = wound.fraction;
  archive.reals["numbers"] = {wound.excised_m3, wound.exact_m3, wound.min_skin_distance_m,
                              wound.min_chest_distance_m};
  Integers lines;  // length, vertices, length, vertices ...
  for (const std::vector<int>& line : wound.incision_vertices) {
    lines.push_back(static_cast<std::int64_t>(line.size()));
    lines.insert(lines.end(), line.begin(), line.end());
  }
  archive.integers["incisions"] = lines;
  archive.texts["warnings"] = join(wound.warnings);
  archive.save(file);
}

surgery::Wound load_wound(const std::filesystem::path& file) {
  const Archive archive = Archive::load(file);
  const std::vector<double>& numbers = archive.real("numbers");
  surgery::Wound wound{.fraction = archive.real("fraction"),
                       .excised_m3 = numbers.at(0),
                       .exact_m3 = numbers.at(1),
                       .min_skin_distance_m = numbers.at(2),
                       .min_chest_distance_m = numbers.at(3),
                       .incision_vertices = {},
                       .warnings = split(archive.texts.at("warnings"))};
  const Integers& lines = archive.integer("incisions");
  for (std::size_t at = 0; at < lines.size(); at += 1 + static_cast<std::size_t>(lines[at])) {
    const auto first = lines.begin() + static_cast<std::ptrdiff_t>(at) + 1;
    wound.incision_vertices.push_back(cast<int>(Integers(first, first + lines[at])));
  }
  return wound;
}

std::span<const Vec3> vertices(const TetMesh& mesh, const mechanics::Shape& shape) {
  ensure(shape.nodes.size() >= mesh.points.size(), "{} nodes for {} vertices", shape.nodes.size(),
         mesh.points.size());
  return std::span(shape.nodes).first(mesh.points.size());
}

double mean_move_mm(const TetMesh& mesh, std::span<const Vec3> from, std::span<const Vec3> to) {
  const std::vector<double> volumes = cell_volumes(mesh, from);
  Vec3 sum{};
  double total = 0.0;
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    total += volumes[c];
    for (const int vertex : mesh.cells[c]) {
      const auto v = static_cast<std::size_t>(vertex);
      sum += 0.25 * volumes[c] * (to[v] - from[v]);
    }
  }
  return 1e3 * norm(sum) / total;
}

io::Field displacement_mm(std::span<const Vec3> from, std::span<const Vec3> to) {
  std::vector<Vec3> moved;
  moved.reserve(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    moved.push_back(to[i] - from[i]);
  }
  return io::vector_field("displacement_mm", moved, 1e3);
}

void write_pose(const meshing::BreastModel& model, std::span<const Vec3> pose,
                std::span<const Vec3> from, const std::filesystem::path& file) {
  io::Fields fields;
  fields.point.push_back(displacement_mm(from, pose));
  fields.cell.push_back(io::scalar_field("fibroglandular_fraction", model.fibroglandular));
  fields.cell.push_back(io::scalar_field("side", cast<double>(model.side)));
  fields.cell.push_back(io::scalar_field("in_breast", cast<double>(model.in_breast)));
  io::write_vtu(model.mesh, pose, fields, file, io::LengthUnit::Millimetre);
}

void write_skin(const TetMesh& mesh, std::span<const Vec3> pose, const io::Fields& vertex_fields,
                const std::filesystem::path& file) {
  const Surface skin = extract_surface(mesh, pose, {"skin"});
  io::Fields fields;
  for (const io::Field& field : vertex_fields.point) {
    io::Field part{field.name, field.components, {}};
    const auto n = static_cast<std::size_t>(field.components);
    for (const int vertex : skin.vertex) {
      const auto first = field.values.begin() + static_cast<std::ptrdiff_t>(vertex * n);
      part.values.insert(part.values.end(), first, first + static_cast<std::ptrdiff_t>(n));
    }
    fields.point.push_back(std::move(part));
  }
  io::write_vtp(skin.mesh, fields, file, io::LengthUnit::Millimetre);
}

}  // namespace sanatrix::pipeline
