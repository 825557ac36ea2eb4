#include "healing/diffusion.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "core/error.hpp"

namespace sanatrix::healing {
namespace {

/// Gradients of the four linear shape functions, times 6 V, and 6 V itself.
struct Tetrahedron {
  std::array<Vec3, 4> gradient;
  double volume6;
};

Tetrahedron tetrahedron(const std::array<int, 4>& v, std::span<const Vec3> points) {
  const Vec3 a = points[v[1]] - points[v[0]];
  const Vec3 b = points[v[2]] - points[v[0]];
  const Vec3 c = points[v[3]] - points[v[0]];
  Tetrahedron t{{Vec3{}, cross(b, c), cross(c, a), cross(a, b)}, 0.0};
  t.gradient[0] = -1.0 * (t.gradient[1] + t.gradient[2] + t.gradient[3]);
  t.volume6 = dot(a, t.gradient[1]);
  return t;
}

/// The vertex's part V of the wound is a layer of thickness V/A under the surface; its middle is
/// V/2A away from healthy tissue, so that D A (healthy - q) / (V/2A) flows into V. At corners and
/// on single protruding cells V/A is no thickness; there the exchange is held to what the same
/// cells conduct in three directions. Any value tends to the same limit on fine meshes.
double surface_exchange(double volume, double area, double weights) {
  const double per_thickness = area / volume;
  return std::min(2.0 * per_thickness * per_thickness, 4.0 * weights);
}

/// Size: number of species, known to the compiler so that the sums stay in registers.
template <std::size_t Size>
void apply_group(const Diffusion& d, std::span<const double> healthy, std::span<const double> q,
                 std::span<double> out) {
  const Laplacian& l = d.laplacian;
  for (std::size_t i = 0; i < l.exchange.size(); ++i) {
    std::array<double, Size> here, sum;
    std::copy_n(q.begin() + d.first + i * Size, Size, here.begin());
    for (std::size_t s = 0; s < Size; ++s) {
      sum[s] = l.exchange[i] * (healthy[s] - here[s]);
    }
    for (int e = l.row[i]; e < l.row[i + 1]; ++e) {
      const auto [column, weight] = l.entries[e];
      for (std::size_t s = 0; s < Size; ++s) {
        // Differences, so that a uniform field stays uniform to the last bit.
        sum[s] += weight * (q[column + s] - here[s]);
      }
    }
    for (std::size_t s = 0; s < Size; ++s) {
      out[d.first + i * Size + s] = d.diffusivity[s] * sum[s];
    }
  }
}

constexpr std::size_t most_species = 8;

/// apply_group of the right size.
template <std::size_t... Size>
void apply_group_of(const Diffusion& d, std::span<const double> healthy, std::span<const double> q,
                    std::span<double> out, std::index_sequence<Size...>) {
  const std::size_t n = d.diffusivity.size();
  ensure(n <= most_species, "healing: more than {} species of one kind", most_species);
  ((n == Size + 1 ? apply_group<Size + 1>(d, healthy, q, out) : void()), ...);
}

}  // namespace

Laplacian make_laplacian(const TetMesh& mesh, std::span<const Vec3> points, const WoundMap& wound,
                         Domain domain, const std::vector<bool>& near,
                         std::span<const int> vertices) {
  constexpr int absent = -1;
  std::vector<int> row_of(points.size(), absent);
  for (std::size_t r = 0; r < vertices.size(); ++r) {
    row_of[vertices[r]] = static_cast<int>(r);
  }
  std::vector<std::map<int, double>> rows(vertices.size());
  std::vector<double> volume24(vertices.size());  // 24 x lumped volume
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (domain == Domain::Wound && !wound.cell[c]) {
      continue;
    }
    const auto& cell = mesh.cells[c];
    const Tetrahedron t = tetrahedron(cell, points);
    for (int a = 0; a < 4; ++a) {
      const int r = row_of[cell[a]];
      if (r == absent) {
        continue;
      }
      volume24[r] += t.volume6;
      for (int b = 0; b < 4; ++b) {
        if (b != a) {  // K_ab = V (g_a / 6V) . (g_b / 6V)
          rows[r][cell[b]] -= dot(t.gradient[a], t.gradient[b]) / (6.0 * t.volume6);
        }
      }
    }
  }
  Laplacian l;
  l.row.push_back(0);
  for (std::size_t r = 0; r < vertices.size(); ++r) {
    double weights = 0.0;
    double far = 0.0;
    for (const auto& [column, conductance] : rows[r]) {
      const double weight = 24.0 * conductance / volume24[r];
      if (near[column]) {
        l.entries.push_back({column, weight});
        weights += weight;
      } else {
        far += weight;
      }
    }
    l.exchange.push_back(
        domain == Domain::Wound
            ? surface_exchange(volume24[r] / 24.0, wound.area[vertices[r]], weights)
            : far);
    l.diagonal.push_back(weights + l.exchange.back());
    l.row.push_back(static_cast<int>(l.entries.size()));
  }
  return l;
}

void Diffusion::apply(std::span<const double> q, std::span<double> out) const {
  apply_group_of(*this, healthy, q, out, std::make_index_sequence<most_species>());
}

void Diffusion::apply_homogeneous(std::span<const double> q, std::span<double> out) const {
  apply_group_of(*this, std::vector<double>(healthy.size()), q, out,
                 std::make_index_sequence<most_species>());
}

}  // namespace sanatrix::healing
