// Design, three gravity poses with the P2/P1 element, voxels, plan, and the pose after surgery.
#include "phantom/phantom.hpp"

#include "core/error.hpp"
#include "mechanics/problem.hpp"
#include "phantom/plan.hpp"
#include "phantom/scar.hpp"
#include "phantom/voxelise.hpp"

namespace sanatrix::phantom {
namespace {

constexpr double g = 9.81;  // [m/s2]
constexpr std::uint8_t fixed_xyz = 7, fixed_z = 4;

mechanics::Body body_of(const TetMesh& mesh, std::span<const double> gland) {
  const mechanics::TissuePreset preset = mechanics::tissue_preset("vavourakis2016");
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = mechanics::Element::P2P1;
  for (const double fraction : gland) {
    body.tissue.push_back(mechanics::mix(preset.adipose, preset.fibroglandular, fraction));
  }
  body.skins = {preset.skin};
  const int skin = boundary_index(mesh, "skin");
  for (const BoundaryFace& face : mesh.faces) {
    if (face.name == skin) {
      body.skin_faces.push_back({face.vertex, 0});
    }
  }
  body.fixed.assign(mesh.points.size(), 0);
  for (const auto& [name, directions] :
       {std::pair{"chest", fixed_xyz}, {"superior", fixed_z}, {"inferior", fixed_z}}) {
    for (const int v : vertices_on(mesh, name)) {
      body.fixed[static_cast<std::size_t>(v)] |= directions;
    }
  }
  return body;
}

std::vector<Vec3> vertices_of(const mechanics::Shape& shape, std::size_t count) {
  return {shape.nodes.begin(), shape.nodes.begin() + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace

Density parse_density(const std::string& name) {
  for (const auto& [known, density] : {std::pair{"fatty", Density::Fatty},
                                       {"scattered", Density::Scattered},
                                       {"heterogeneous", Density::Heterogeneous},
                                       {"dense", Density::Dense}}) {
    if (name == known) {
      return density;
    }
  }
  throw Error(Fault::Usage, "unknown density \"" + name + "\"",
              "write one of: fatty, scattered, heterogeneous, dense");
}

Phantom make_phantom(const Options& options, const Context& ctx) {
  require(options.volume_cm3 >= 150.0 && options.volume_cm3 <= 1500.0,
          "phantom: a breast of {} cm3 is outside 150 to 1500 cm3", options.volume_cm3);
  ctx.at(0.0, "designing the unloaded body");
  const Anatomy anatomy(options.volume_cm3 * 1e-6, options.seed);
  const TissueMap tissue(anatomy, options.density, options.seed);
  BodyMesh body = mesh_body(anatomy, options.edge_m);
  const std::size_t vertices = body.mesh.points.size();

  Phantom phantom;
  phantom.fibroglandular = gland_fractions(body, anatomy, tissue);
  const mechanics::Body solid = body_of(body.mesh, phantom.fibroglandular);
  // Displacements of 10 mm are then right to far less than a micrometre.
  mechanics::Solver solver(solid, {.relative_tolerance = 1e-6});
  const std::vector<Vec3> reference = curved_nodes(body, anatomy, solver.edges());

  ctx.at(0.05, "prone pose, P2/P1");
  const mechanics::Shape prone = during("phantom prone", [&] {
    return solver.forward(reference, {0, -g, 0}, nullptr, ctx.part(0.05, 0.25));
  });
  ctx.at(0.25, "supine pose, P2/P1");
  const mechanics::Shape supine = during("phantom supine", [&] {
    return solver.forward(reference, {0, g, 0}, nullptr, ctx.part(0.25, 0.5));
  });
  ctx.at(0.5, "upright pose, P2/P1");
  const mechanics::Shape upright = during("phantom upright", [&] {
    const Context in_part = ctx.part(0.5, 0.75);
    // A heavy breast creases at its fold: half of the load first is faster than failing at all of
    // it.
    if (options.volume_cm3 > 900.0) {
      const auto half = solver.forward(reference, {0, 0, -0.5 * g}, nullptr, in_part);
      return solver.forward(reference, {0, 0, -g}, &half, in_part);
    }
    return solver.forward(reference, {0, 0, -g}, nullptr, in_part);
  });
  phantom.prone = vertices_of(prone, vertices);
  phantom.supine = vertices_of(supine, vertices);
  phantom.upright = vertices_of(upright, vertices);

  const QuadraticCells cells(body.mesh, solver.edges());
  phantom.labels = voxelise(body, anatomy, tissue, cells, reference, prone.nodes, options.voxel_mm,
                            ctx.part(0.75, 0.85));
  ctx.at(0.85, "writing the plan");
  phantom.plan_json = plan_json(phantom.labels, anatomy, "phantom-" + std::to_string(options.seed));

  const Context last = ctx.part(0.85, 1.0);
  Scar scar = during("phantom's surgery", [&] {
    return scar_of(phantom.plan_json, body.mesh, phantom.prone, solid.tissue, last.part(0.0, 0.3));
  });
  phantom.excised_m3 = scar.excised_m3;
  solver.set_tissue(scar.tissue);
  const mechanics::Shape after = during("phantom upright after surgery", [&] {
    return solver.forward(reference, {0, 0, -g}, &upright, last.part(0.3, 1.0));
  });
  const auto skin_of = [&](const std::vector<Vec3>& nodes) {
    return cells.boundary("skin", nodes);
  };
  phantom.skin = {skin_of(reference), skin_of(prone.nodes), skin_of(supine.nodes),
                  skin_of(upright.nodes), skin_of(after.nodes)};
  phantom.mesh = std::move(body.mesh);
  ctx.at(1.0, "done");
  return phantom;
}

}  // namespace sanatrix::phantom
