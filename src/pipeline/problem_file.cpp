#include "pipeline/problem_file.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "fem/session.hpp"
#include "io/mesh_file.hpp"
#include "pipeline/json_object.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr double huge = 1e12;   // [Pa] and the like: beyond it, a unit was mistaken
constexpr double small = 1e-6;  // smallest positive value that makes sense

std::size_t index_of(const std::vector<std::string>& names, const std::string& given,
                     const std::string& what) {
  const auto at = std::ranges::find(names, given);
  require(at != names.end(), "{}: the mesh has no such {}; it has: {}", given, what,
          fmt::join(names, ", "));
  return static_cast<std::size_t>(at - names.begin());
}

mechanics::Tissue read_tissue(const JsonObject& law, bool needs_density) {
  law.allow({"law", "c1", "c2", "kappa", "density"});
  law.choice("law", {"mooney_rivlin"});
  mechanics::Tissue tissue;
  tissue.c1 = law.number("c1", 0, huge);
  tissue.c2 = law.number("c2", 0, huge);
  tissue.kappa = law.number("kappa", small, huge);
  require(tissue.c1 + tissue.c2 > 0, "{}: c1 + c2 must be positive", law.name("c1"));
  tissue.density = needs_density || law.has("density") ? law.number("density", 0, 1e5) : 0.0;
  return tissue;
}

mechanics::Skin read_skin(const JsonObject& law) {
  law.allow({"law", "alpha", "beta", "c2", "thickness", "density", "tension_field"});
  law.choice("law", {"veronda_westmann"});
  const mechanics::Skin standard;
  mechanics::Skin skin;
  skin.alpha = law.number("alpha", 0, huge);
  skin.beta = law.number("beta", 0, 1e3);
  skin.c2 = law.number("c2", -huge, huge);
  skin.thickness = law.number("thickness", 0, 0.1);
  skin.density = law.number_or("density", 0, 1e5, standard.density);
  skin.tension_field = law.flag_or("tension_field", standard.tension_field);
  return skin;
}

void read_regions(const JsonObject& regions, bool needs_density, SolveProblem& problem) {
  const TetMesh& mesh = problem.mesh;
  std::vector<std::optional<mechanics::Tissue>> laws(mesh.region_names.size());
  for (const auto& [name, unused] : regions.raw().items()) {
    laws[index_of(mesh.region_names, name, "region")] =
        read_tissue(regions.object(name), needs_density);
  }
  for (std::size_t r = 0; r < laws.size(); ++r) {
    require(laws[r].has_value(), "regions: the mesh's region '{}' has no law",
            mesh.region_names[r]);
  }
  for (const int region : mesh.region) {
    problem.body.tissue.push_back(*laws[static_cast<std::size_t>(region)]);
  }
}

void read_skins(const JsonObject& skins, SolveProblem& problem) {
  const TetMesh& mesh = problem.mesh;
  for (const auto& [name, unused] : skins.raw().items()) {
    const std::size_t boundary = index_of(mesh.boundary_names, name, "boundary");
    const int law = static_cast<int>(problem.body.skins.size());
    problem.body.skins.push_back(read_skin(skins.object(name)));
    for (const BoundaryFace& face : mesh.faces) {
      if (face.name == static_cast<int>(boundary)) {
        problem.body.skin_faces.push_back({face.vertex, law});
      }
    }
  }
}

std::uint8_t read_directions(const JsonObject& fixed, const std::string& name) {
  const std::string letters = fixed.text(name);
  std::uint8_t bits = 0;
  for (const char letter : letters) {
    require(letter >= 'x' && letter <= 'z', "{}: '{}' is not made of the letters x, y and z",
            fixed.name(name), letters);
    bits = static_cast<std::uint8_t>(bits | (1 << (letter - 'x')));
  }
  require(bits != 0, "{}: say which directions are held: x, y, z or several", fixed.name(name));
  return bits;
}

void read_fixed(const JsonObject& fixed, SolveProblem& problem) {
  const TetMesh& mesh = problem.mesh;
  std::vector<std::string> known = mesh.boundary_names;
  for (const auto& [name, unused] : mesh.named_points) {
    known.push_back(name);
  }
  for (const auto& [name, unused] : fixed.raw().items()) {
    const std::uint8_t bits = read_directions(fixed, name);
    index_of(known, name, "boundary or point");
    std::vector<int> held = vertices_on(mesh, name);
    if (const auto point = mesh.named_points.find(name);
        boundary_index(mesh, name) < 0 && point->second >= 0) {
      held = {point->second};
    }
    for (const int vertex : held) {
      problem.body.fixed[static_cast<std::size_t>(vertex)] |= bits;
    }
  }
}

HealingRequest read_healing(const JsonObject& j, const TetMesh& mesh) {
  j.allow({"preset", "overrides", "wound", "days", "mechanics_interval_days",
           "mechanics_density_change", "record_interval_days", "scheme", "dt_s",
           "relative_tolerance"});
  HealingRequest request;
  const std::vector<std::string> overrides =
      j.has("overrides") ? j.texts("overrides") : std::vector<std::string>{};
  request.model = healing::make_model(j.text("preset"), overrides);
  std::vector<bool> wounded(mesh.region_names.size(), false);
  for (const std::string& name : j.texts("wound")) {
    wounded[index_of(mesh.region_names, name, "region")] = true;
  }
  require(std::ranges::find(wounded, true) != wounded.end(),
          "{}: name at least one region that is the wound", j.name("wound"));
  for (const int region : mesh.region) {
    request.wound_fraction.push_back(wounded[static_cast<std::size_t>(region)] ? 1.0 : 0.0);
  }
  recovery::Schedule& schedule = request.schedule;
  schedule.days = j.number_or("days", small, 3650, schedule.days);
  schedule.mechanics_interval_days =
      j.number_or("mechanics_interval_days", 0.01, 3650, schedule.mechanics_interval_days);
  schedule.mechanics_density_change =
      j.number_or("mechanics_density_change", 0.0, 1.0, schedule.mechanics_density_change);
  schedule.record_interval_days =
      j.number_or("record_interval_days", 0.001, 3650, schedule.record_interval_days);
  if (j.has("scheme") && j.choice("scheme", {"cvode", "explicit"}) == "explicit") {
    request.species.scheme = healing::Scheme::Explicit;
  }
  request.species.dt_s = j.number_or("dt_s", small, 1e6, request.species.dt_s);
  request.species.relative_tolerance =
      j.number_or("relative_tolerance", 1e-12, 0.1, request.species.relative_tolerance);
  return request;
}

Mode read_mode(const JsonObject& root) {
  const std::string mode = root.choice("mode", {"forward", "inverse", "healing"});
  return mode == "forward" ? Mode::Forward : mode == "inverse" ? Mode::Inverse : Mode::Healing;
}

void load_mesh(SolveProblem& problem) {
  const fs::path& file = problem.mesh_file;
  const io::LengthUnit unit = problem.mesh_unit;
  if (fem::ranks() == 1) {
    problem.mesh = io::read_msh(file, unit);
    return;
  }
  problem.share =
      std::make_shared<fem::MeshShare>(fem::rank() == 0 ? io::read_msh(file, unit) : TetMesh{},
                                       mechanics::cell_layers(problem.body.element));
  problem.mesh = problem.share->mesh();
  problem.body.share = problem.share.get();
}

SolveProblem problem_from(const JsonObject& root, const fs::path& folder) {
  root.allow(
      {"mesh", "unit", "element", "regions", "skins", "fixed", "gravity", "mode", "healing"});
  SolveProblem problem;
  problem.mode = read_mode(root);
  require(root.has("healing") == (problem.mode == Mode::Healing),
          "healing: this key belongs to mode \"healing\", and only to it");
  if (root.has("element")) {
    problem.body.element =
        mechanics::element_named(root.choice("element", mechanics::element_names()));
  }
  if (root.has("gravity") || problem.mode != Mode::Healing) {
    const std::vector<double> g = root.numbers("gravity", 3);
    problem.gravity = {g[0], g[1], g[2]};
  }
  problem.mesh_file = folder / root.text("mesh");
  problem.mesh_unit =
      root.choice("unit", {"m", "mm"}) == "m" ? io::LengthUnit::Metre : io::LengthUnit::Millimetre;
  load_mesh(problem);
  problem.body.fixed.assign(problem.mesh.points.size(), 0);
  read_regions(root.object("regions"), norm(problem.gravity) > 0, problem);
  if (root.has("skins")) {
    read_skins(root.object("skins"), problem);
  }
  if (root.has("fixed")) {
    read_fixed(root.object("fixed"), problem);
  }
  if (problem.mode == Mode::Healing) {
    problem.healing = read_healing(root.object("healing"), problem.mesh);
  }
  return problem;
}

}  // namespace

SolveProblem read_problem(const fs::path& file) {
  const std::string name = file.filename().string();
  const json j = json::parse(read_text(file), nullptr, false);
  require(!j.is_discarded(), "{}: this is not JSON", name);
  return during(name, [&] { return problem_from(JsonObject(j, ""), file.parent_path()); });
}

}  // namespace sanatrix::pipeline
