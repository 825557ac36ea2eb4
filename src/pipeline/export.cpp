#include "pipeline/export.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/stage_store.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;

/// More materials than this make a file that no program reads in reasonable time.
constexpr std::size_t most_materials = 64;

using Constants = std::array<double, 4>;
Constants constants_of(const mechanics::Tissue& t) {
  return {t.integrity * t.c1, t.integrity * t.c2, t.kappa, t.density};
}

/// One material per distinct tissue; where there are too many, equal intervals of c1 + c2 whose
/// members share their mean.
void add_materials(const std::vector<mechanics::Tissue>& tissue, io::PeerModel& model) {
  std::vector<double> stiffness;
  for (const mechanics::Tissue& t : tissue) {
    stiffness.push_back(t.integrity * (t.c1 + t.c2));
  }
  std::map<Constants, int> distinct;
  for (const mechanics::Tissue& t : tissue) {
    distinct.try_emplace(constants_of(t), static_cast<int>(distinct.size()));
  }
  const auto [low, high] = std::ranges::minmax(stiffness);
  const bool binned = distinct.size() > most_materials;
  const auto group = [&](std::size_t c) {
    if (!binned) {
      return distinct.at(constants_of(tissue[c]));
    }
    const double share = (stiffness[c] - low) / (high - low);
    return std::min(static_cast<int>(share * most_materials), static_cast<int>(most_materials) - 1);
  };
  std::map<int, std::pair<Constants, int>> sums;
  for (std::size_t c = 0; c < tissue.size(); ++c) {
    auto& [sum, count] = sums[group(c)];
    const Constants now = constants_of(tissue[c]);
    std::ranges::transform(sum, now, sum.begin(), std::plus<>());
    ++count;
  }
  model.mesh.region_names.clear();
  std::map<int, int> region;
  for (const auto& [key, entry] : sums) {
    const auto& [sum, count] = entry;
    region[key] = static_cast<int>(model.materials.size());
    const std::string name = fmt::format("tissue_{}", model.materials.size());
    model.materials.push_back(
        {name, sum[0] / count, sum[1] / count, sum[2] / count, sum[3] / count});
    model.mesh.region_names.push_back(name);
  }
  double largest = 0.0;
  for (std::size_t c = 0; c < tissue.size(); ++c) {
    model.mesh.region[c] = region.at(group(c));
    const io::PeerMaterial& m = model.materials[static_cast<std::size_t>(model.mesh.region[c])];
    largest = std::max(largest, std::abs(m.c1 + m.c2 - stiffness[c]) / stiffness[c]);
  }
  if (binned) {
    model.notes.push_back(fmt::format(
        "{} tissues are brought together in {} materials; c1 + c2 changes by at most {:.2g} %",
        distinct.size(), model.materials.size(), 100.0 * largest));
  }
}

/// The boundary that consists of exactly these faces, or "".
std::string boundary_with(const TetMesh& mesh, std::size_t faces, const std::array<int, 3>& one) {
  for (std::size_t b = 0; b < mesh.boundary_names.size(); ++b) {
    const auto named = [&](const BoundaryFace& face) {
      return face.name == static_cast<int>(b);
    };
    if (static_cast<std::size_t>(std::ranges::count_if(mesh.faces, named)) == faces &&
        std::ranges::any_of(mesh.faces, [&](const BoundaryFace& face) {
          return named(face) && face.vertex == one;
        })) {
      return mesh.boundary_names[b];
    }
  }
  return "";
}

void add_skin(const mechanics::Body& body, io::PeerModel& model) {
  for (std::size_t s = 0; s < body.skins.size(); ++s) {
    const mechanics::Skin& skin = body.skins[s];
    io::PeerMembrane membrane{
        "", "", skin.alpha, skin.beta, skin.c2, skin.thickness, skin.density, skin.tension_field};
    for (const auto& face : body.skin_faces) {
      if (face.law == static_cast<int>(s)) {
        membrane.faces.push_back(face.vertex);
      }
    }
    if (membrane.faces.empty()) {
      continue;
    }
    membrane.boundary = boundary_with(model.mesh, membrane.faces.size(), membrane.faces.front());
    membrane.name = fmt::format("membrane_{}", s);
    model.membranes.push_back(std::move(membrane));
    if (skin.tension_field) {
      model.notes.emplace_back("in Sanatrix the skin bears no compression (tension field)");
    }
  }
}

Vec3 gravity_of(const std::string& pose) {
  return pose == "prone" ? gravity_prone : pose == "supine" ? gravity_supine : gravity_upright;
}

}  // namespace

io::PeerModel export_case(const Case& patient, const std::string& pose) {
  if (status(patient, Stage::Unload).state != State::Fresh) {
    throw Error(Fault::Input, "the case has no up-to-date stress-free shape to export",
                "make it with `sanatrix run CASE --to unload`");
  }
  const meshing::BreastModel breasts = load_model(patient.stage_folder(Stage::Mesh) / "model.bin");
  const auto unloaded = load_shape(patient.stage_folder(Stage::Unload) / "shape.bin");
  const mechanics::Body body = make_body(breasts.mesh, breasts.fibroglandular, patient.parameters);
  io::PeerModel model;
  model.title = fmt::format("{}, stress-free shape, {} gravity, exported by Sanatrix",
                            patient.pseudonym, pose);
  model.mesh = breasts.mesh;
  const auto points = vertices(breasts.mesh, unloaded.shape);
  model.mesh.points.assign(points.begin(), points.end());
  model.fixed = body.fixed;
  model.gravity = gravity_of(pose);
  model.element = mechanics::name_of(body.element);
  add_materials(body.tissue, model);
  add_skin(body, model);
  if (unloaded.wall_guard > 1.0) {
    model.notes.push_back(fmt::format(
        "cells on the chest wall answer with {:g} times their own bulk modulus here (docs/adr, "
        "18), which no file holds: poses differ there",
        unloaded.wall_guard));
  }
  return model;
}

io::PeerModel export_problem(const SolveProblem& problem, const std::string& title) {
  require(problem.mode != Mode::Healing, "mode healing cannot be exported: peers have no healing");
  io::PeerModel model;
  model.title = title + ", exported by Sanatrix";
  model.mesh = problem.mesh;
  model.fixed = problem.body.fixed;
  model.gravity = problem.gravity;
  model.element = mechanics::name_of(problem.body.element);
  std::vector<bool> known(problem.mesh.region_names.size(), false);
  model.materials.resize(known.size());
  for (std::size_t c = 0; c < problem.mesh.cells.size(); ++c) {
    const auto r = static_cast<std::size_t>(problem.mesh.region[c]);
    if (!known[r]) {
      const mechanics::Tissue& t = problem.body.tissue[c];
      model.materials[r] = {problem.mesh.region_names[r], t.c1, t.c2, t.kappa, t.density};
      known[r] = true;
    }
  }
  add_skin(problem.body, model);
  if (problem.mode == Mode::Inverse) {
    model.notes.emplace_back(
        "this mesh is the loaded shape: the problem asks for the stress-free one");
  }
  return model;
}

std::string problem_json(const io::PeerModel& model, const std::string& mesh_file) {
  json regions = json::object();
  for (const io::PeerMaterial& m : model.materials) {
    regions[m.name] = {{"law", "mooney_rivlin"},
                       {"c1", m.c1},
                       {"c2", m.c2},
                       {"kappa", m.kappa},
                       {"density", m.density}};
  }
  json j{{"mesh", mesh_file},        {"unit", "m"},
         {"element", model.element}, {"mode", "forward"},
         {"gravity", model.gravity}, {"regions", regions}};
  // A boundary is held where all its vertices are.
  for (std::size_t b = 0; b < model.mesh.boundary_names.size(); ++b) {
    std::uint8_t held = 7;
    const std::string& name = model.mesh.boundary_names[b];
    const std::vector<int> on = vertices_on(model.mesh, name);
    for (const int v : on) {
      held &= model.fixed[static_cast<std::size_t>(v)];
    }
    std::string letters;
    for (int i = 0; i < 3; ++i) {
      letters += (held >> i & 1) != 0 ? std::string(1, static_cast<char>('x' + i)) : "";
    }
    if (!on.empty() && !letters.empty()) {
      j["fixed"][name] = letters;
    }
  }
  for (const io::PeerMembrane& m : model.membranes) {
    ensure(!m.boundary.empty(), "membrane {} is not a whole boundary", m.name);
    j["skins"][m.boundary] = {{"law", "veronda_westmann"},
                              {"alpha", m.alpha},
                              {"beta", m.beta},
                              {"c2", m.c2},
                              {"thickness", m.thickness},
                              {"density", m.density},
                              {"tension_field", m.tension_field}};
  }
  return j.dump(2) + "\n";
}

}  // namespace sanatrix::pipeline
