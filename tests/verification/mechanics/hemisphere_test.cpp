// The benchmark hemisphere against Taylor-Hood reference fields of an independent program.
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "io/mesh_file.hpp"
#include "mechanics/problem.hpp"
#include "shared_data.hpp"

namespace sanatrix::mechanics {
namespace {

struct Hemisphere {
  TetMesh mesh;
  Body body;
};

Hemisphere read_hemisphere(const std::filesystem::path& file, Element element) {
  Hemisphere h;
  h.mesh = io::read_msh(file, io::LengthUnit::Metre);
  h.body.mesh = &h.mesh;
  h.body.element = element;
  h.body.tissue.assign(h.mesh.cells.size(), {150.0, 100.0, 2.5e5, 1000.0, 1.0, 0.0});
  h.body.fixed.assign(h.mesh.points.size(), 0);
  for (const int v : vertices_on(h.mesh, "base")) {
    h.body.fixed[static_cast<std::size_t>(v)] = 7;
  }
  return h;
}

/// x -> u of a reference file "node,x,y,z,ux,uy,uz", by position so that numbering does not matter.
std::map<std::array<long, 3>, Vec3> read_field(const std::filesystem::path& gz) {
  std::map<std::array<long, 3>, Vec3> field;
  FILE* pipe = popen(("zcat '" + gz.string() + "'").c_str(), "r");
  std::array<char, 512> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
    std::istringstream row(line.data());
    std::array<double, 7> v{};
    char comma = 0;
    if (row >> v[0] >> comma >> v[1] >> comma >> v[2] >> comma >> v[3] >> comma >> v[4] >> comma >>
        v[5] >> comma >> v[6]) {
      field[{std::lround(v[1] * 1e8), std::lround(v[2] * 1e8), std::lround(v[3] * 1e8)}] = {
          v[4], v[5], v[6]};
    }
  }
  pclose(pipe);
  return field;
}

const Vec3 prone{0.0, 0.0, 9.81};
const Vec3 upright{0.0, -9.81, 0.0};

struct Difference {
  double apex, field;  // relative to the reference
  std::size_t matched;
};

Difference compare(const Hemisphere& h, const Shape& shape, const std::filesystem::path& file,
                   std::size_t axis) {
  const auto reference = read_field(file);
  double difference = 0.0;
  double size = 0.0;
  std::size_t matched = 0;
  Difference d{};
  const auto apex = static_cast<std::size_t>(h.mesh.named_points.at("apex"));
  for (std::size_t v = 0; v < h.mesh.points.size(); ++v) {
    const Vec3& x = h.mesh.points[v];
    const auto found =
        reference.find({std::lround(x[0] * 1e8), std::lround(x[1] * 1e8), std::lround(x[2] * 1e8)});
    if (found == reference.end()) {
      continue;
    }
    ++matched;
    const Vec3 u = shape.nodes[v] - x;
    difference += dot(u - found->second, u - found->second);
    size += dot(found->second, found->second);
    if (v == apex) {
      d.apex = std::abs(u[axis] / found->second[axis] - 1.0);
    }
  }
  d.field = std::sqrt(difference / size);
  d.matched = matched;
  return d;
}

Difference forward_difference(Element element, const Vec3& gravity, const std::string& file,
                              std::size_t axis, const std::filesystem::path& bench) {
  const Hemisphere h = read_hemisphere(bench / "hemi5k.msh", element);
  Silent silent;
  Solver solver(h.body);
  const Shape shape = solver.forward(solver.straight_nodes(h.mesh.points), gravity, nullptr,
                                     Context("test", silent));
  const Difference d = compare(h, shape, bench / file, axis);
  EXPECT_GT(d.matched, h.mesh.points.size() * 99 / 100);
  return d;
}

TEST(TheHemisphere, WithP1P1IsNearTheTaylorHoodReference) {
  SANATRIX_REQUIRE_SHARED("bench");
  EXPECT_LT(forward_difference(Element::P1P1, prone, "p2p1_5k_prone.csv.gz", 2, shared_file).apex,
            0.02);
  EXPECT_LT(
      forward_difference(Element::P1P1, upright, "p2p1_5k_upright.csv.gz", 1, shared_file).apex,
      0.04);
}

TEST(TheHemisphere, WithP2P1IsTheTaylorHoodReferenceProne) {
  SANATRIX_REQUIRE_SHARED("bench");
  const auto d = forward_difference(Element::P2P1, prone, "p2p1_5k_prone.csv.gz", 2, shared_file);
  EXPECT_LT(d.apex, 0.005);
  EXPECT_LT(d.field, 0.005);
}

TEST(TheHemisphere, WithP2P1IsTheTaylorHoodReferenceUpright) {
  SANATRIX_REQUIRE_SHARED("bench");
  const auto d =
      forward_difference(Element::P2P1, upright, "p2p1_5k_upright.csv.gz", 1, shared_file);
  EXPECT_LT(d.apex, 0.005);
  EXPECT_LT(d.field, 0.005);
}

TEST(TheHemisphere, UnloadedWithP2P1IsTheReferenceUnloadedShape) {
  SANATRIX_REQUIRE_SHARED("bench");
  const Hemisphere h = read_hemisphere(shared_file / "hemiC_v22.msh", Element::P2P1);
  Silent silent;
  Solver solver(h.body);
  const Shape shape =
      solver.inverse(solver.straight_nodes(h.mesh.points), prone, Context("test", silent));
  const Difference d = compare(h, shape, shared_file / "p2p1_C_inv_prone.csv.gz", 2);
  EXPECT_GT(d.matched, h.mesh.points.size() * 99 / 100);
  EXPECT_LT(d.apex, 0.005);
  EXPECT_LT(d.field, 0.005);
}

/// Unloading a body with skin, tension field and two tissues, then loading it again.
void expect_round_trip(Element element, const std::filesystem::path& file, const Vec3& gravity) {
  Hemisphere h = read_hemisphere(file, element);
  for (std::size_t c = 0; c < h.mesh.cells.size(); c += 3) {
    h.body.tissue[c] = {160.0, 160.0, 5e5, 1020.0, 1.0, 0.0};
  }
  h.body.skins.push_back({});
  const int skin = boundary_index(h.mesh, "skin");
  for (const auto& face : h.mesh.faces) {
    if (face.name == skin) {
      h.body.skin_faces.push_back({face.vertex, 0});
    }
  }
  Silent silent;
  const Context ctx("test", silent);
  Solver solver(h.body);
  const auto given = solver.straight_nodes(h.mesh.points);
  const Shape unloaded = solver.inverse(given, gravity, ctx);
  const Shape again = solver.forward(unloaded.nodes, gravity, nullptr, ctx);
  double moved = 0.0;
  double worst = 0.0;
  for (std::size_t n = 0; n < given.size(); ++n) {
    moved = std::max(moved, norm(unloaded.nodes[n] - given[n]));
    worst = std::max(worst, norm(again.nodes[n] - given[n]));
  }
  EXPECT_GT(moved, 2e-3);
  EXPECT_LT(worst / moved, 1e-6);  // C10: solver tolerance, because both solve R(X, x, p) = 0
}

TEST(TheHemisphere, UnloadedAndLoadedAgainIsItself) {
  SANATRIX_REQUIRE_SHARED("bench");
  expect_round_trip(Element::P1P1, shared_file / "hemiC_v22.msh", prone);
  expect_round_trip(Element::P1P1, shared_file / "hemiC_v22.msh", upright);
  expect_round_trip(Element::P2P1, shared_file / "hemiC_v22.msh", prone);
}

}  // namespace
}  // namespace sanatrix::mechanics
