#include "pipeline/model_share.hpp"

#include "fem/session.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"

namespace sanatrix::pipeline {

mechanics::Shape whole_shape(const StageInput& in, Stage stage) {
  return in.writes ? load_shape(in.from(stage) / "shape.bin").shape : mechanics::Shape{};
}

double wall_guard(const StageInput& in) {
  std::vector<double> guard{in.writes ? load_shape(in.from(Stage::Unload) / "shape.bin").wall_guard
                                      : 0.0};
  fem::broadcast(guard);
  return guard[0];
}

ModelShare::ModelShare(const StageInput& in, double wall_guard) {
  const Parameters& parameters = in.parameters();
  if (in.writes) {
    whole_ = load_model(in.from(Stage::Mesh) / "model.bin");
  }
  if (fem::ranks() == 1) {
    body_ = make_body(whole_.mesh, whole_.fibroglandular, parameters);
    guard_wall(body_, wall_guard);
    return;
  }
  share_ = std::make_unique<const fem::MeshShare>(whole_.mesh,
                                                  mechanics::cell_layers(element_of(parameters)));
  const TetMesh& mesh = share_->mesh();
  const bool quadratic = element_of(parameters) == mechanics::Element::P2P1;
  const fem::EdgeTable edges = quadratic ? fem::make_edges(mesh.cells) : fem::EdgeTable{};
  transfers_.emplace(Transfers{fem::vertex_transfer(*share_), fem::cell_transfer(*share_),
                               fem::node_transfer(*share_, edges, whole_.mesh)});
  body_ = make_body(mesh, transfers_->cells.from_leader(whole_.fibroglandular, 1), parameters);
  body_.share = share_.get();
  guard_wall(body_, wall_guard);
}

std::vector<double> ModelShare::distribute_vertices(std::vector<double> whole, int width) const {
  return transfers_ ? transfers_->vertices.from_leader(whole, width) : std::move(whole);
}

std::vector<double> ModelShare::distribute_cells(std::vector<double> whole, int width) const {
  return transfers_ ? transfers_->cells.from_leader(whole, width) : std::move(whole);
}

std::vector<double> ModelShare::collect_vertices(std::vector<double> mine, int width) const {
  return transfers_ ? transfers_->vertices.to_leader(mine, width) : std::move(mine);
}

std::vector<double> ModelShare::collect_cells(std::vector<double> mine, int width) const {
  return transfers_ ? transfers_->cells.to_leader(mine, width) : std::move(mine);
}

mechanics::Shape ModelShare::distribute(const mechanics::Shape& whole) const {
  if (!transfers_) {
    return whole;
  }
  return {unflatten(transfers_->nodes.from_leader(flatten(whole.nodes), 3)),
          transfers_->vertices.from_leader(whole.pressure, 1)};
}

mechanics::Shape ModelShare::collect(const mechanics::Shape& mine) const {
  if (!transfers_) {
    return mine;
  }
  return {unflatten(transfers_->nodes.to_leader(flatten(mine.nodes), 3)),
          transfers_->vertices.to_leader(mine.pressure, 1)};
}

std::vector<std::pair<std::string, double>> ModelShare::numbers() const {
  if (!share_) {
    return {};
  }
  const fem::ShareSizes sizes = fem::sizes(*share_);
  return {{"ranks", fem::ranks()},
          {"vertices", share_->whole_vertices()},
          {"most_own_vertices", sizes.most_own_vertices},
          {"most_ghost_vertices", sizes.most_ghost_vertices}};
}

}  // namespace sanatrix::pipeline
