// The model of a case over the ranks of a run: PETSc distributes the mesh, every rank computes on
// its share, and rank 0 alone knows the whole, which it reads and writes. One rank works on the
// whole itself.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fem/mesh_share.hpp"
#include "fem/transfer.hpp"
#include "mechanics/problem.hpp"
#include "meshing/breast_mesh.hpp"
#include "pipeline/runner.hpp"

namespace sanatrix::pipeline {

/// The shape a stage left, on rank 0; empty elsewhere.
mechanics::Shape whole_shape(const StageInput& in, Stage stage);

/// The guard with which the unloaded shape was found, on every rank; the poses from it use the
/// same.
double wall_guard(const StageInput& in);

/// All calls are collective but those that say otherwise.
class ModelShare {
 public:
  ModelShare(const StageInput& in, double wall_guard);
  ModelShare(const ModelShare&) = delete;
  ModelShare& operator=(const ModelShare&) = delete;

  /// On rank 0, empty elsewhere. Not collective.
  [[nodiscard]] const meshing::BreastModel& whole() const { return whole_; }
  /// Of this rank's share, its cells on the wall guarded. Not collective.
  [[nodiscard]] const mechanics::Body& body() const { return body_; }

  // What rank 0 gives for the whole, on every rank for its share; `width` numbers per item.
  [[nodiscard]] mechanics::Shape distribute(const mechanics::Shape& whole) const;
  [[nodiscard]] std::vector<double> distribute_vertices(std::vector<double> whole, int width) const;
  [[nodiscard]] std::vector<double> distribute_cells(std::vector<double> whole, int width) const;
  // The other way; empty but on rank 0.
  [[nodiscard]] mechanics::Shape collect(const mechanics::Shape& mine) const;
  [[nodiscard]] std::vector<double> collect_vertices(std::vector<double> mine, int width) const;
  [[nodiscard]] std::vector<double> collect_cells(std::vector<double> mine, int width) const;

  /// How the mesh lies on several ranks, for stage.json; nothing on one.
  [[nodiscard]] std::vector<std::pair<std::string, double>> numbers() const;

 private:
  struct Transfers {
    fem::Transfer vertices, cells, nodes;
  };
  meshing::BreastModel whole_;
  std::unique_ptr<const fem::MeshShare> share_;  ///< on several ranks
  mechanics::Body body_;
  std::optional<Transfers> transfers_;
};

}  // namespace sanatrix::pipeline
