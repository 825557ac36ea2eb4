#include "standing/fairing.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

namespace sanatrix::standing {

void fair(Image3<float>& image, const std::vector<bool>& unknown) {
  const auto nx = static_cast<std::size_t>(image.size[0]);
  const std::size_t layer = nx * static_cast<std::size_t>(image.size[1]);
  std::vector<int> number(unknown.size(), -1);
  std::vector<std::size_t> voxels;
  for (std::size_t v = 0; v < unknown.size(); ++v) {
    if (unknown[v]) {
      number[v] = static_cast<int>(voxels.size());
      voxels.push_back(v);
    }
  }
  if (voxels.empty()) {
    return;
  }
  // One equation for every voxel whose Laplacian has an unknown in it: the Laplacian is zero.
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> right;
  const auto add_equation = [&](std::size_t v) {
    const std::array<std::pair<std::size_t, double>, 7> stencil{{{v, -6.0},
                                                                 {v - 1, 1.0},
                                                                 {v + 1, 1.0},
                                                                 {v - nx, 1.0},
                                                                 {v + nx, 1.0},
                                                                 {v - layer, 1.0},
                                                                 {v + layer, 1.0}}};
    const auto row = static_cast<int>(right.size());
    bool any = false;
    double known = 0;
    for (const auto& [at, weight] : stencil) {
      if (number[at] >= 0) {
        entries.emplace_back(row, number[at], weight);
        any = true;
      } else {
        known += weight * image.voxels[at];
      }
    }
    if (any) {
      right.push_back(-known);
    }
  };
  for (int k = 1; k + 1 < image.size[2]; ++k) {
    for (int j = 1; j + 1 < image.size[1]; ++j) {
      for (int i = 1; i + 1 < image.size[0]; ++i) {
        add_equation(static_cast<std::size_t>(k) * layer + static_cast<std::size_t>(j) * nx +
                     static_cast<std::size_t>(i));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(static_cast<int>(right.size()),
                                     static_cast<int>(voxels.size()));
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd start(static_cast<int>(voxels.size()));
  for (std::size_t u = 0; u < voxels.size(); ++u) {
    start[static_cast<int>(u)] = image.voxels[voxels[u]];
  }
  Eigen::LeastSquaresConjugateGradient<Eigen::SparseMatrix<double>> solver;
  solver.setTolerance(1e-5);  // of values of some 10 mm
  solver.setMaxIterations(400);
  solver.compute(matrix);
  const Eigen::VectorXd value = solver.solveWithGuess(
      Eigen::Map<const Eigen::VectorXd>(right.data(), static_cast<int>(right.size())), start);
  for (std::size_t u = 0; u < voxels.size(); ++u) {
    image.voxels[voxels[u]] = static_cast<float>(value[static_cast<int>(u)]);
  }
}

}  // namespace sanatrix::standing
