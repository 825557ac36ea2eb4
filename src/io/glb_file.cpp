#include "io/glb_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/scan_file.hpp"

namespace sanatrix::io {
namespace {

using nlohmann::json;
static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

std::array<float, 3> y_up(const Vec3& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[2]), static_cast<float>(-p[1])};
}

/// The binary chunk with the views and accessors into it.
class Buffer {
 public:
  int add_vectors(const std::vector<std::array<float, 3>>& values) {
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    for (const auto& v : values) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], v[k]);
        high[k] = std::max(high[k], v[k]);
      }
    }
    return add(values, "VEC3", float_type, {{"min", low}, {"max", high}});
  }
  int add_corners(const std::vector<std::array<float, 2>>& values) {
    return add(values, "VEC2", float_type, {});
  }
  int add_numbers(const std::vector<float>& values) {
    const auto [low, high] = std::ranges::minmax(values);
    return add(values, "SCALAR", float_type,
               {{"min", json::array({low})}, {"max", json::array({high})}});
  }
  int add_indices(const std::vector<std::uint32_t>& values) {
    return add(values, "SCALAR", unsigned_type, {});
  }
  int add_bytes(const std::string& bytes_in) {
    align();
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", bytes_in.size()}});
    bytes += bytes_in;
    return static_cast<int>(views.size()) - 1;
  }
  std::string bytes;
  json views = json::array(), accessors = json::array();

 private:
  static constexpr int float_type = 5126, unsigned_type = 5125;

  void align() { bytes.resize((bytes.size() + 3) / 4 * 4, '\0'); }
  template <class T>
  int add(const std::vector<T>& values, const char* type, int component, json accessor) {
    const int view =
        add_bytes({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    accessor["bufferView"] = view;
    accessor["componentType"] = component;
    accessor["count"] = values.size();
    accessor["type"] = type;
    accessors.push_back(std::move(accessor));
    return static_cast<int>(accessors.size()) - 1;
  }
};

/// Every target swells and fades in turn, the last one stays.
void add_animation(std::size_t targets, double seconds, Buffer& buffer, json& document) {
  std::vector<float> times, weights;
  for (std::size_t step = 0; step <= targets; ++step) {
    times.push_back(
        static_cast<float>(seconds * static_cast<double>(step) / static_cast<double>(targets)));
    for (std::size_t target = 0; target < targets; ++target) {
      weights.push_back(step == target + 1 ? 1.0F : 0.0F);
    }
  }
  const int input = buffer.add_numbers(times), output = buffer.add_numbers(weights);
  document["animations"] = {
      {{"name", "after surgery"},
       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
}

json material(const TexturedSurface& surface, Buffer& buffer, json& document) {
  json m{{"name", "skin"},
         {"doubleSided", true},
         {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.85}}}};
  if (surface.has_photograph()) {
    const int view = buffer.add_bytes(jpeg_bytes(surface.photograph));
    document["images"] = {{{"bufferView", view}, {"mimeType", "image/jpeg"}}};
    document["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9729}}};
    document["textures"] = {{{"source", 0}, {"sampler", 0}}};
    m["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  } else {
    m["pbrMetallicRoughness"]["baseColorFactor"] = {0.67, 0.4, 0.28, 1.0};
  }
  return m;
}

std::string packed(const json& document, std::string bytes) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  std::string out;
  const auto word = [&](std::uint32_t value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  word(0x46546C67);  // "glTF"
  word(2);
  word(static_cast<std::uint32_t>(28 + text.size() + bytes.size()));
  word(static_cast<std::uint32_t>(text.size()));
  word(0x4E4F534A);  // "JSON"
  out += text;
  word(static_cast<std::uint32_t>(bytes.size()));
  word(0x004E4942);  // "BIN"
  return out + bytes;
}

}  // namespace

void write_glb(const TexturedSurface& surface, const std::vector<MorphTarget>& targets,
               const std::filesystem::path& file, double seconds) {
  const SeamlessSurface seamless = split_at_seams(surface);
  const auto spread = [&](const std::vector<Vec3>& values) {
    ensure(values.size() == surface.mesh.points.size(), "{} values for {} vertices of a GLB",
           values.size(), surface.mesh.points.size());
    std::vector<std::array<float, 3>> all;
    for (const int origin : seamless.origin) {
      all.push_back(y_up(values[static_cast<std::size_t>(origin)]));
    }
    return all;
  };
  Buffer buffer;
  json document{{"asset", {{"version", "2.0"}, {"generator", "Sanatrix"}}},
                {"extras",
                 {{"notice", "Research use only. Not a medical device."},
                  {"axes", "x patient's left, y superior, z anterior; metres"}}},
                {"scene", 0},
                {"scenes", {{{"nodes", {0}}}}},
                {"nodes", {{{"mesh", 0}, {"name", "patient"}}}}};
  std::vector<std::uint32_t> indices;
  for (const auto& t : seamless.mesh.triangles) {
    for (const int v : t) {
      indices.push_back(static_cast<std::uint32_t>(v));
    }
  }
  const std::vector<Vec3> normals = vertex_normals(surface.mesh);
  json attributes{{"POSITION", buffer.add_vectors(spread(surface.mesh.points))},
                  {"NORMAL", buffer.add_vectors(spread(normals))}};
  if (surface.has_photograph()) {
    std::vector<std::array<float, 2>> corners;
    for (const TextureCorner& at : seamless.corner) {  // glTF counts v downwards
      corners.push_back(std::isnan(at[0]) ? TextureCorner{0, 0} : TextureCorner{at[0], 1 - at[1]});
    }
    attributes["TEXCOORD_0"] = buffer.add_corners(corners);
  }
  json primitive{
      {"attributes", attributes}, {"indices", buffer.add_indices(indices)}, {"material", 0}};
  json names = json::array();
  for (const MorphTarget& target : targets) {
    TriMesh moved = surface.mesh;
    moved.points = target.points;
    std::vector<Vec3> shift = target.points, turn = vertex_normals(moved);
    for (std::size_t v = 0; v < shift.size(); ++v) {
      shift[v] = shift[v] - surface.mesh.points[v];
      turn[v] = turn[v] - normals[v];
    }
    primitive["targets"].push_back({{"POSITION", buffer.add_vectors(spread(shift))},
                                    {"NORMAL", buffer.add_vectors(spread(turn))}});
    names.push_back(target.name);
  }
  json mesh{{"name", "skin"}, {"primitives", {primitive}}};
  if (!targets.empty()) {
    mesh["weights"] = std::vector<double>(targets.size(), 0.0);
    mesh["extras"]["targetNames"] = names;
    add_animation(targets.size(), seconds, buffer, document);
  }
  document["meshes"] = {mesh};
  document["materials"] = {material(surface, buffer, document)};
  document["bufferViews"] = buffer.views;
  document["accessors"] = buffer.accessors;
  document["buffers"] = {{{"byteLength", (buffer.bytes.size() + 3) / 4 * 4}}};
  write_text(file, packed(document, buffer.bytes));
}

}  // namespace sanatrix::io
