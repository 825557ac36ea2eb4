#include "outcome/discretisation.hpp"

namespace sanatrix::outcome {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Du/DX of a linear cell; row i is the gradient of u_i.
Mat3 gradient(const std::array<int, 4>& cell, std::span<const Vec3> points,
              std::span<const Vec3> displacement) {
  Mat3 edges{};  // columns: X_a - X_0
  Mat3 moved{};  // columns: u_a - u_0
  for (std::size_t a = 0; a < 3; ++a) {
    const Vec3 X = points[index(cell[a + 1])] - points[index(cell[0])];
    const Vec3 u = displacement[index(cell[a + 1])] - displacement[index(cell[0])];
    for (std::size_t i = 0; i < 3; ++i) {
      edges[i][a] = X[i];
      moved[i][a] = u[i];
    }
  }
  return moved * inverse(edges);
}

double squared(const Mat3& m) {
  return dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2]);
}

void add(Mat3& sum, double weight, const Mat3& m) {
  for (std::size_t i = 0; i < 3; ++i) {
    sum[i] += weight * m[i];
  }
}

}  // namespace

double relative_displacement_error(const TetMesh& mesh, std::span<const Vec3> points,
                                   std::span<const Vec3> displacement,
                                   const std::vector<bool>& used) {
  const std::vector<double> volumes = cell_volumes(mesh, points);
  std::vector<Mat3> of_cell(mesh.cells.size(), Mat3{});
  std::vector<Mat3> at_vertex(points.size(), Mat3{});
  std::vector<double> weight(points.size(), 0.0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (used[c]) {
      of_cell[c] = gradient(mesh.cells[c], points, displacement);
      for (const int v : mesh.cells[c]) {
        add(at_vertex[index(v)], volumes[c], of_cell[c]);
        weight[index(v)] += volumes[c];
      }
    }
  }
  double error = 0.0;
  double size = 0.0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (!used[c]) {
      continue;
    }
    // int |G - g|^2 of the linear field of differences d_a: V/20 (|sum d|^2 + sum |d|^2)
    Mat3 sum{};
    double squares = 0.0;
    for (const int v : mesh.cells[c]) {
      Mat3 difference{};
      add(difference, 1.0 / weight[index(v)], at_vertex[index(v)]);
      add(difference, -1.0, of_cell[c]);
      add(sum, 1.0, difference);
      squares += squared(difference);
    }
    error += volumes[c] / 20.0 * (squared(sum) + squares);
    size += volumes[c] * squared(of_cell[c]);
  }
  return size > 0.0 ? error / size : 0.0;
}

}  // namespace sanatrix::outcome
