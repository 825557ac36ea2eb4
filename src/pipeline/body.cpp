#include "pipeline/body.hpp"

#include <algorithm>

namespace sanatrix::pipeline {
namespace {

constexpr std::uint8_t fixed_xyz = 7, fixed_z = 4;

/// A given parameter replaces the preset's value; scale brings its unit to SI.
void replace(double& value, const Parameters& parameters, const std::string& key,
             double scale = 1.0) {
  if (parameters.has(key)) {
    value = scale * parameters.number(key);
  }
}

void replace_tissue(mechanics::Tissue& tissue, const Parameters& p, const std::string& prefix) {
  replace(tissue.c1, p, prefix + "_c1_pa");
  replace(tissue.c2, p, prefix + "_c2_pa");
  replace(tissue.kappa, p, prefix + "_kappa_pa");
  replace(tissue.density, p, prefix + "_density_kg_m3");
}

void fix(mechanics::Body& body, const std::string& boundary, std::uint8_t directions) {
  for (const int vertex : vertices_on(*body.mesh, boundary)) {
    body.fixed[static_cast<std::size_t>(vertex)] |= directions;
  }
}

}  // namespace

mechanics::TissuePreset tissue_values(const Parameters& p) {
  mechanics::TissuePreset preset = mechanics::tissue_preset(p.text("tissue.preset"));
  replace_tissue(preset.adipose, p, "tissue.adipose");
  replace_tissue(preset.fibroglandular, p, "tissue.fibroglandular");
  replace(preset.skin.thickness, p, "skin.thickness_mm", 1e-3);
  replace(preset.skin.alpha, p, "skin.alpha_pa");
  replace(preset.skin.beta, p, "skin.beta");
  replace(preset.skin.c2, p, "skin.c2_pa");
  replace(preset.skin.density, p, "skin.density_kg_m3");
  preset.skin.tension_field = p.text("skin.tension_field") == "yes";
  return preset;
}

mechanics::Element element_of(const Parameters& parameters) {
  return mechanics::element_named(parameters.text("solver.element"));
}

mechanics::Body make_body(const TetMesh& mesh, std::span<const double> fibroglandular,
                          const Parameters& parameters) {
  const mechanics::TissuePreset values = tissue_values(parameters);
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element_of(parameters);
  for (const double fraction : fibroglandular) {
    body.tissue.push_back(mechanics::mix(values.adipose, values.fibroglandular, fraction));
  }
  if (parameters.text("skin.enabled") == "yes") {
    const int skin = boundary_index(mesh, "skin");
    for (const BoundaryFace& face : mesh.faces) {
      if (face.name == skin) {
        body.skin_faces.push_back({face.vertex, 0});
      }
    }
    body.skins = {values.skin};
  }
  body.fixed.assign(mesh.points.size(), 0);
  fix(body, "chest", fixed_xyz);
  fix(body, "superior", fixed_z);
  fix(body, "inferior", fixed_z);
  return body;
}

void guard_wall(mechanics::Body& body, double guard) {
  for (std::size_t c = 0; c < body.tissue.size(); ++c) {
    const bool touches = std::ranges::any_of(body.mesh->cells[c], [&](int vertex) {
      return body.fixed[static_cast<std::size_t>(vertex)] == fixed_xyz;
    });
    body.tissue[c].guard = touches ? guard : 1.0;
  }
}

mechanics::SolveOptions solve_options(const Parameters& parameters) {
  mechanics::SolveOptions options;
  options.relative_tolerance = parameters.number("solver.relative_tolerance");
  return options;
}

}  // namespace sanatrix::pipeline
