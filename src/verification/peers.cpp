// The benchmark hemisphere against Taylor-Hood fields of an independent program. Needs the shared
// development data.
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <zlib.h>

#include "core/error.hpp"
#include "io/mesh_file.hpp"
#include "mechanics/problem.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Element;

const Vec3 prone{0.0, 0.0, 9.81};
const Vec3 upright{0.0, -9.81, 0.0};

struct Hemisphere {
  TetMesh mesh;
  mechanics::Body body;
};

Hemisphere read_hemisphere(const std::string& file, Element element) {
  Hemisphere h;
  h.mesh = io::read_msh(file, io::LengthUnit::Metre);
  h.body.element = element;
  h.body.tissue.assign(h.mesh.cells.size(), {150.0, 100.0, 2.5e5, 1000.0, 1.0, 0.0});
  h.body.fixed.assign(h.mesh.points.size(), 0);
  for (const int v : vertices_on(h.mesh, "base")) {
    h.body.fixed[static_cast<std::size_t>(v)] = 7;
  }
  return h;
}

using Key = std::array<long, 3>;
Key key_of(const Vec3& p) {
  return {std::lround(p[0] * 1e8), std::lround(p[1] * 1e8), std::lround(p[2] * 1e8)};
}

/// x -> u of a reference file "node,x,y,z,ux,uy,uz", by position so that numbering does not matter.
std::map<Key, Vec3> read_field(const std::string& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
  require(in != nullptr, "{}: cannot be read", file);
  std::map<Key, Vec3> field;
  std::array<char, 512> line{};
  while (gzgets(in.get(), line.data(), static_cast<int>(line.size())) != nullptr) {
    std::istringstream row(line.data());
    std::array<double, 7> v{};
    char comma = 0;
    if (row >> v[0] >> comma >> v[1] >> comma >> v[2] >> comma >> v[3] >> comma >> v[4] >> comma >>
        v[5] >> comma >> v[6]) {
      field[key_of({v[1], v[2], v[3]})] = {v[4], v[5], v[6]};
    }
  }
  return field;
}

struct Load {
  const char* name;
  Vec3 gravity;
  const char* reference;
  std::size_t axis;
  bool inverse;
};
const Load load_prone{"prone", prone, "bench/p2p1_5k_prone.csv.gz", 2, false};
const Load load_upright{"upright", upright, "bench/p2p1_5k_upright.csv.gz", 1, false};
const Load unload_prone{"unloaded from prone", prone, "bench/p2p1_C_inv_prone.csv.gz", 2, true};

struct Bounds {
  double apex, field;  // relative
};

void compare(const std::string& mesh_file, Element element, const Load& load, const Bounds& bounds,
             Findings& found, const Context& ctx) {
  const std::string mesh_path = shared_file(mesh_file);
  const std::string reference_path = shared_file(load.reference);
  if (mesh_path.empty() || reference_path.empty()) {
    found.skipped = "the shared development data is absent (set SANATRIX_SHARED)";
    return;
  }
  Hemisphere h = read_hemisphere(mesh_path, element);
  h.body.mesh = &h.mesh;
  mechanics::Solver solver(h.body);
  const auto given = solver.straight_nodes(h.mesh.points);
  const mechanics::Shape shape = load.inverse ? solver.inverse(given, load.gravity, ctx)
                                              : solver.forward(given, load.gravity, nullptr, ctx);
  const auto reference = read_field(reference_path);
  double difference = 0.0;
  double size = 0.0;
  std::size_t matched = 0;
  const auto apex = static_cast<std::size_t>(h.mesh.named_points.at("apex"));
  const std::string name = fmt::format("{}, {}", title_of(element), load.name);
  for (std::size_t v = 0; v < h.mesh.points.size(); ++v) {
    const auto at = reference.find(key_of(h.mesh.points[v]));
    if (at == reference.end()) {
      continue;
    }
    ++matched;
    const Vec3 u = shape.nodes[v] - h.mesh.points[v];
    difference += dot(u - at->second, u - at->second);
    size += dot(at->second, at->second);
    if (v == apex) {
      found.checks.push_back(near(name + ": apex", 1e3 * at->second[load.axis], 1e3 * u[load.axis],
                                  1e3 * bounds.apex * std::abs(at->second[load.axis]), "mm",
                                  fmt::format("{:.1f} %", 100 * bounds.apex)));
    }
  }
  found.checks.push_back(within(name + ": relative difference of the field", 0.0, bounds.field,
                                std::sqrt(difference / size), "", "l2 over the vertices"));
  found.checks.push_back(
      within(name + ": vertices compared", 0.99, 1.0,
             static_cast<double>(matched) / static_cast<double>(h.mesh.points.size()), "",
             "share of all"));
}

Findings hemisphere_p1p1(const Context& ctx) {
  Findings found;
  compare("bench/hemi5k.msh", Element::P1P1, load_prone, {0.02, 0.03}, found, ctx);
  compare("bench/hemi5k.msh", Element::P1P1, load_upright, {0.04, 0.05}, found, ctx);
  return found;
}

Findings hemisphere_smoothed(const Context& ctx) {
  Findings found;
  compare("bench/hemi5k.msh", Element::Smoothed, load_prone, {0.01, 0.02}, found, ctx);
  compare("bench/hemi5k.msh", Element::Smoothed, load_upright, {0.02, 0.025}, found, ctx);
  return found;
}

Findings hemisphere_inverse(const Context& ctx) {
  Findings found;
  compare("bench/hemiC_v22.msh", Element::P2P1, unload_prone, {0.005, 0.005}, found, ctx);
  return found;
}

Findings hemisphere_p2p1(const Context& ctx) {
  Findings found;
  compare("bench/hemi5k.msh", Element::P2P1, load_prone, {0.005, 0.005}, found, ctx);
  compare("bench/hemi5k.msh", Element::P2P1, load_upright, {0.005, 0.005}, found, ctx);
  return found;
}

constexpr auto about =
    "Half a ball of 65 mm under gravity, 22,035 tetrahedra, c1 = 150 Pa, c2 = 100 Pa, kappa = "
    "2.5e5 Pa, no skin. Reference: Taylor-Hood by an independent FEniCSx program on the same "
    "mesh. ";

}  // namespace

void add_peers(std::vector<Case>& cases) {
  cases.push_back(
      {"hemisphere-p1p1", "Hemisphere against a peer, P1/P1", Chapter::CodeVerification, Cost::Fast,
       std::string(about) + "The goal is 2 % prone and 4 % upright, at a hundredth of the time.",
       hemisphere_p1p1});
  cases.push_back({"hemisphere-smoothed", "Hemisphere against a peer, smoothed P1/P1",
                   Chapter::CodeVerification, Cost::Fast,
                   std::string(about) + "Half of what P1/P1 is allowed at the apex.",
                   hemisphere_smoothed});
  cases.push_back({"hemisphere-inverse", "Hemisphere unloaded, against a peer",
                   Chapter::CodeVerification, Cost::Fast,
                   "The same on 2,751 tetrahedra, the given mesh being the loaded shape.",
                   hemisphere_inverse});
  cases.push_back({"hemisphere-p2p1", "Hemisphere against a peer, P2/P1", Chapter::CodeVerification,
                   Cost::Full,
                   std::string(about) + "Same element, same mesh: the same answer within 0.5 %.",
                   hemisphere_p2p1});
}

}  // namespace sanatrix::verification
