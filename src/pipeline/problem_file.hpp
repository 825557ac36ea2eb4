// The PROBLEM.json of `sanatrix solve` (docs/user/solve.md): the engine on any tetrahedral mesh.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/mesh_share.hpp"
#include "io/mesh_file.hpp"
#include "mechanics/problem.hpp"
#include "recovery/recovery.hpp"

namespace sanatrix::pipeline {

enum class Mode { Forward, Inverse, Healing };

struct HealingRequest {
  std::shared_ptr<const healing::Model> model;  ///< shared: problems are copied freely
  std::vector<double> wound_fraction;           ///< per cell, 0 or 1
  healing::RdOptions species;
  recovery::Schedule schedule;
};

struct SolveProblem {
  TetMesh mesh;
  /// Given on several ranks: the mesh is this rank's share.
  std::shared_ptr<const fem::MeshShare> share;
  std::filesystem::path mesh_file;
  io::LengthUnit mesh_unit = io::LengthUnit::Metre;
  mechanics::Body body;  ///< its mesh pointer is set by the solver of the problem
  Vec3 gravity{};
  Mode mode = Mode::Forward;
  std::optional<HealingRequest> healing;
};

/// Strict: unknown keys, unknown region and boundary names (listing the existing ones), regions
/// without a law and values out of range are Error{Input}. A relative mesh path is relative to the
/// problem's file. Collective: rank 0 reads the mesh and PETSc distributes it.
SolveProblem read_problem(const std::filesystem::path& file);

}  // namespace sanatrix::pipeline
