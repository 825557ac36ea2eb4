#include "outcome/warp.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Sparse>

#include "core/error.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

std::vector<std::array<int, 2>> edges_of(const TriMesh& surface) {
  std::vector<std::array<int, 2>> edges;
  for (const auto& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::ranges::unique(edges).begin(), edges.end());
  return edges;
}

/// Counterparts of the vertices on the scan, as a sparse least squares problem for their motion.
class Bending {
 public:
  Bending(const TriMesh& skin, const TriMesh& scan)
      : surface_(skin), target_(scan), edges_(edges_of(skin)), areas_(vertex_areas(skin)) {
    displacement_.assign(skin.points.size(), Vec3{});
    rest_ = skin.points;
  }

  /// One step with the given stiffness; counterparts farther than `reach` do not count.
  void step(double stiffness, double reach) {
    using Matrix = Eigen::SparseMatrix<double>;
    const auto n = static_cast<Eigen::Index>(3 * surface_.points.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    add_membrane(stiffness, entries);
    add_counterparts(reach, entries, right);
    Matrix a(n, n);
    a.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<Matrix> solver(a);
    ensure(solver.info() == Eigen::Success, "the warp's equations cannot be solved");
    const Eigen::VectorXd x = solver.solve(right);
    for (std::size_t v = 0; v < rest_.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        displacement_[v][k] = x[static_cast<Eigen::Index>(3 * v + k)];
      }
      surface_.points[v] = rest_[v] + displacement_[v];
    }
  }

  Warp result() {
    std::vector<double> distances;
    for (const Vec3& p : surface_.points) {
      if (const auto hit = target_.closest(p); !hit.on_border) {
        distances.push_back(hit.distance);
      }
    }
    Warp warp{std::move(surface_), 0.0};
    if (!distances.empty()) {
      std::ranges::sort(distances);
      warp.median_m = distances[distances.size() / 2];
    }
    return warp;
  }

 private:
  using Entries = std::vector<Eigen::Triplet<double>>;

  /// stiffness x sum over edges |u_a - u_b|^2, plus a trace of mass so that nothing floats.
  void add_membrane(double stiffness, Entries& entries) const {
    for (const auto& [a, b] : edges_) {
      for (int k = 0; k < 3; ++k) {
        const int i = 3 * a + k, j = 3 * b + k;
        entries.emplace_back(i, i, stiffness);
        entries.emplace_back(j, j, stiffness);
        entries.emplace_back(i, j, -stiffness);
        entries.emplace_back(j, i, -stiffness);
      }
    }
    for (int i = 0; i < static_cast<int>(3 * rest_.size()); ++i) {
      entries.emplace_back(i, i, 1e-9);
    }
  }

  void add_counterparts(double reach, Entries& entries, Eigen::VectorXd& right) const {
    constexpr double along = 0.05;  // share of the point-to-point term: sliding is nearly free
    const std::vector<Vec3> normals = vertex_normals(surface_);
    double mean_area = 0;
    for (const double area : areas_) {
      mean_area += area / static_cast<double>(areas_.size());
    }
    for (std::size_t v = 0; v < rest_.size(); ++v) {
      const auto hit = target_.closest(surface_.points[v]);
      const double far = hit.distance / reach;
      if (hit.on_border || far >= 1 || dot(hit.normal, normals[v]) < 0.5) {
        continue;
      }
      const double weight = areas_[v] / mean_area * (1 - far * far) * (1 - far * far);
      const Vec3 wanted = hit.point - rest_[v];
      for (std::size_t r = 0; r < 3; ++r) {
        double sum = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const double entry = weight * (hit.normal[r] * hit.normal[c] + (r == c ? along : 0.0));
          entries.emplace_back(static_cast<int>(3 * v + r), static_cast<int>(3 * v + c), entry);
          sum += entry * wanted[c];
        }
        right[static_cast<Eigen::Index>(3 * v + r)] += sum;
      }
    }
  }

  TriMesh surface_;
  ScanTarget target_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<double> areas_;
  std::vector<Vec3> rest_, displacement_;
};

}  // namespace

Warp warp_onto(const TriMesh& skin, const TriMesh& scan) {
  Bending bending(skin, scan);
  for (const double stiffness : {10.0, 3.0, 1.0, 0.3, 0.1, 0.1}) {
    bending.step(stiffness, 0.03);
  }
  return bending.result();
}

std::vector<Vec3> carry_to_scan(const Warp& warp, std::span<const Vec3> displacement,
                                const TriMesh& scan, double fade_m) {
  ensure(displacement.size() == warp.surface.points.size(), "{} displacements for {} vertices",
         displacement.size(), warp.surface.points.size());
  const SurfaceTree tree(warp.surface);
  std::vector<Vec3> carried;
  carried.reserve(scan.points.size());
  for (const Vec3& p : scan.points) {
    const SurfaceTree::Hit hit = tree.closest(p);
    const auto& triangle = warp.surface.triangles[static_cast<std::size_t>(hit.triangle)];
    const std::array<double, 3> weights = weights_in(warp.surface, hit.triangle, hit.point);
    const double t = std::min(hit.distance / fade_m, 1.0);
    const double share = 1 - t * t * (3 - 2 * t);
    Vec3 u{};
    for (std::size_t k = 0; k < 3; ++k) {
      u += share * weights[k] * displacement[static_cast<std::size_t>(triangle[k])];
    }
    carried.push_back(u);
  }
  return carried;
}

}  // namespace sanatrix::outcome
