#include "standing/chest_wall.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>

namespace sanatrix::standing {
namespace {

using meshing::ColumnMap;

constexpr double rim_mm = 28.0;
constexpr double plate_length_mm = 4.0;
/// Where no breast covers it, the chest is round: sum of the skin's curvatures seen from the front.
constexpr double chest_radius_mm = 180.0;

}  // namespace

ColumnMap trunk_without_breasts(const FrontMap& front, const meshing::BreastMap& breasts) {
  ColumnMap base = front.skin_y;
  std::vector<bool> covered;
  for (std::size_t c = 0; c < base.value.size(); ++c) {
    covered.push_back(breasts.side[c] != 0);
  }
  const std::vector<double> beside = frontal_distance(base, covered);
  std::vector<int> unknown(base.value.size(), -1);
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < base.value.size(); ++c) {
    base.value[c] += std::max(0.0, breasts.prominence.value[c]);
    if (beside[c] < rim_mm) {
      unknown[c] = static_cast<int>(columns.size());
      columns.push_back(c);
    }
  }
  // Least sum of squares of slopes and of l x (second differences), l the plate's length, under an
  // even load that bulges the membrane forward as far as a chest.
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Constant(
      static_cast<int>(columns.size()), -base.spacing_mm * base.spacing_mm / chest_radius_mm);
  const auto add = [&](const std::vector<std::pair<std::size_t, double>>& row) {
    for (const auto& [c, a] : row) {
      if (unknown[c] < 0) {
        continue;
      }
      for (const auto& [d, b] : row) {
        if (unknown[d] < 0) {
          right[unknown[c]] -= a * b * base.value[d];
        } else {
          entries.emplace_back(unknown[c], unknown[d], a * b);
        }
      }
    }
  };
  const double bend = plate_length_mm / base.spacing_mm;
  for (int k = 0; k < base.size[1]; ++k) {
    for (int i = 0; i < base.size[0]; ++i) {
      const std::size_t c = base.index(i, k);
      if (i + 1 < base.size[0]) {
        add({{c, 1.0}, {base.index(i + 1, k), -1.0}});
      }
      if (k + 1 < base.size[1]) {
        add({{c, 1.0}, {base.index(i, k + 1), -1.0}});
      }
      if (i > 0 && k > 0 && i + 1 < base.size[0] && k + 1 < base.size[1]) {
        add({{c, 4 * bend},
             {base.index(i + 1, k), -bend},
             {base.index(i - 1, k), -bend},
             {base.index(i, k + 1), -bend},
             {base.index(i, k - 1), -bend}});
      }
    }
  }
  const int n = static_cast<int>(columns.size());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::VectorXd value = solver.solve(right);
  for (int u = 0; u < n; ++u) {
    base.value[columns[static_cast<std::size_t>(u)]] = value[u];
  }
  return base;
}

}  // namespace sanatrix::standing
