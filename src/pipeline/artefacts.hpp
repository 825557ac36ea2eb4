// The files by which stages hand over their results: exact arrays for the next stage, VTU and VTP
// in LPS millimetres for people.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "io/mesh_file.hpp"
#include "mechanics/problem.hpp"
#include "meshing/breast_mesh.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::pipeline {

void save_model(const meshing::BreastModel& model, const std::filesystem::path& file);
meshing::BreastModel load_model(const std::filesystem::path& file);

/// A shape with the smallest det F of the solve that made it.
struct SolvedShape {
  mechanics::Shape shape;
  double min_jacobian = 1.0;
  double wall_guard = 1.0;  ///< with which it was found (guard_wall); of the unloaded shape
};
void save_shape(const SolvedShape& solved, const std::filesystem::path& file);
SolvedShape load_shape(const std::filesystem::path& file);

void save_wound(const surgery::Wound& wound, const std::filesystem::path& file);
surgery::Wound load_wound(const std::filesystem::path& file);

/// The first nodes of a shape are the mesh's vertices.
std::span<const Vec3> vertices(const TetMesh& mesh, const mechanics::Shape& shape);

std::vector<double> flatten(std::span<const Vec3> points);
std::vector<Vec3> unflatten(std::span<const double> numbers);

/// The model in one pose, with its tissue and the displacement from another pose.
void write_pose(const meshing::BreastModel& model, std::span<const Vec3> pose,
                std::span<const Vec3> from, const std::filesystem::path& file);
/// The model's skin in one pose; point fields are given per mesh vertex.
void write_skin(const TetMesh& mesh, std::span<const Vec3> pose, const io::Fields& vertex_fields,
                const std::filesystem::path& file);
/// Length of the mean displacement over the volume of the first pose: the one number of a pose that
/// does not depend on where the mesh is fine [mm].
double mean_move_mm(const TetMesh& mesh, std::span<const Vec3> from, std::span<const Vec3> to);
/// Lengths in mm, as displacement fields of artefacts have them.
io::Field displacement_mm(std::span<const Vec3> from, std::span<const Vec3> to);

}  // namespace sanatrix::pipeline
