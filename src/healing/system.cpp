#include "healing/system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

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

WoundMap wound_map(const TetMesh& mesh, std::span<const Vec3> points,
                   std::span<const double> wound_fraction) {
  WoundMap map{std::vector<bool>(points.size()), std::vector<double>(points.size())};
  std::vector<double> volume(points.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const double v = tetrahedron(mesh.cells[c], points).volume6;
    for (const int i : mesh.cells[c]) {
      volume[i] += v;
      map.fraction[i] += v * wound_fraction[c];
      map.vertex[i] = map.vertex[i] || wound_fraction[c] >= 0.5;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    ensure(volume[i] > 0.0, "vertex {} of the healing mesh belongs to no cell", i);
    map.fraction[i] /= volume[i];
  }
  return map;
}

/// Inverse of a small dense row-major matrix, in place (Gauss-Jordan with row pivoting).
void invert(std::span<double> m, int n, std::vector<int>& pivots) {
  pivots.resize(n);
  for (int k = 0; k < n; ++k) {
    int p = k;
    for (int i = k + 1; i < n; ++i) {
      p = std::abs(m[i * n + k]) > std::abs(m[p * n + k]) ? i : p;
    }
    pivots[k] = p;
    std::swap_ranges(m.begin() + k * n, m.begin() + (k + 1) * n, m.begin() + p * n);
    const double scale = 1.0 / m[k * n + k];
    m[k * n + k] = 1.0;
    for (int j = 0; j < n; ++j) {
      m[k * n + j] *= scale;
    }
    for (int i = 0; i < n; ++i) {
      if (i == k) {
        continue;
      }
      const double factor = m[i * n + k];
      m[i * n + k] = 0.0;
      for (int j = 0; j < n; ++j) {
        m[i * n + j] -= factor * m[k * n + j];
      }
    }
  }
  for (int k = n - 1; k >= 0; --k) {  // row swaps of the matrix are column swaps of its inverse
    for (int i = 0; pivots[k] != k && i < n; ++i) {
      std::swap(m[i * n + k], m[i * n + pivots[k]]);
    }
  }
}

}  // namespace

int Partition::chunk_begin(int chunk, int vertices) {
  const int size = (vertices + chunks - 1) / chunks;
  return std::min(chunk * size, vertices);
}

int Partition::rank_begin(int rank, int ranks, int vertices) {
  return chunk_begin(rank * chunks / ranks, vertices);
}

System::System(const TetMesh& mesh, std::span<const Vec3> points,
               std::span<const double> wound_fraction, const Model& model, int rank, int ranks)
    : model_(&model),
      species_(static_cast<int>(model.species().size())),
      vertices_(static_cast<int>(points.size())),
      begin_(Partition::rank_begin(rank, ranks, vertices_)),
      end_(Partition::rank_begin(rank + 1, ranks, vertices_)),
      wound_(wound_map(mesh, points, wound_fraction)) {
  for (int i = 0; i < vertices_; ++i) {
    for (int s = 0; s < species_; ++s) {
      const bool held = model.species()[s].clamped_outside && !wound_.vertex[i];
      free_ += held ? 0 : 1;
      free_wound_ += wound_.vertex[i] ? 1 : 0;
      if (held && i >= begin_ && i < end_) {
        clamped_.push_back((i - begin_) * species_ + s);
      }
    }
  }
  for (const Species& s : model.species()) {
    diffusivity_.push_back(s.diffusivity);
  }
  assemble(mesh, points);
}

void System::assemble(const TetMesh& mesh, std::span<const Vec3> points) {
  std::vector<std::map<int, double>> rows(own());
  std::vector<double> mass(own());  // times 24
  for (const auto& cell : mesh.cells) {
    const Tetrahedron t = tetrahedron(cell, points);
    for (int a = 0; a < 4; ++a) {
      const int i = cell[a] - begin_;
      if (i < 0 || i >= own()) {
        continue;
      }
      mass[i] += t.volume6;
      for (int b = 0; b < 4; ++b) {
        if (b != a) {  // K_ab = V (g_a / 6V) . (g_b / 6V)
          rows[i][cell[b]] -= dot(t.gradient[a], t.gradient[b]) / (6.0 * t.volume6);
        }
      }
    }
  }
  std::vector<int> columns;
  row_.assign(1, 0);
  diagonal_.assign(own(), 0.0);
  for (int i = 0; i < own(); ++i) {
    for (const auto& [column, stiffness] : rows[i]) {
      columns.push_back(column);
      entries_.push_back({column, 24.0 * stiffness / mass[i]});
      diagonal_[i] += entries_.back().weight;
    }
    row_.push_back(static_cast<int>(entries_.size()));
  }
  localise(columns);
}

/// Global columns become local ones: own vertices first, then ghosts.
void System::localise(const std::vector<int>& columns) {
  for (const int c : columns) {
    if (c < begin_ || c >= end_) {
      ghosts_.push_back(c);
    }
  }
  std::ranges::sort(ghosts_);
  ghosts_.erase(std::ranges::unique(ghosts_).begin(), ghosts_.end());
  for (Entry& e : entries_) {
    const bool mine = e.column >= begin_ && e.column < end_;
    e.column = mine ? e.column - begin_
                    : own() + static_cast<int>(std::ranges::lower_bound(ghosts_, e.column) -
                                               ghosts_.begin());
  }
}

std::vector<double> System::initial_state() const {
  std::vector<double> q;
  q.reserve(static_cast<std::size_t>(vertices_) * species_);
  for (int i = 0; i < vertices_; ++i) {
    for (const Species& s : model_->species()) {
      q.push_back(wound_.vertex[i] ? s.wounded : s.healthy);
    }
  }
  return q;
}

void System::diffuse(std::span<const double> q, std::span<double> out) const {
  const int n = species_;
  std::vector<double>& sum = work_;
  sum.resize(n);
  for (int i = 0; i < own(); ++i) {
    const double* const here = q.data() + static_cast<std::size_t>(i) * n;
    std::ranges::fill(sum, 0.0);
    for (int e = row_[i]; e < row_[i + 1]; ++e) {
      // Differences, so that a uniform field stays uniform to the last bit.
      const double* const there = q.data() + static_cast<std::size_t>(entries_[e].column) * n;
      for (int s = 0; s < n; ++s) {
        sum[s] += entries_[e].weight * (there[s] - here[s]);
      }
    }
    for (int s = 0; s < n; ++s) {
      out[static_cast<std::size_t>(i) * n + s] = diffusivity_[s] * sum[s];
    }
  }
}

void System::hold_clamped(std::span<double> own_values) const {
  for (const int c : clamped_) {
    own_values[c] = 0.0;
  }
}

void System::rate(std::span<const double> q, std::span<double> dq) const {
  const std::size_t size = static_cast<std::size_t>(own()) * species_;
  model_->source(q.first(size), std::span(wound_.fraction).subspan(begin_, own()), dq, {});
  std::vector<double> flux(size);
  diffuse(q, flux);
  for (std::size_t k = 0; k < size; ++k) {
    dq[k] += flux[k];
  }
  hold_clamped(dq);
}

void System::linearise(std::span<const double> q) {
  const std::size_t size = static_cast<std::size_t>(own()) * species_;
  jacobian_.resize(size * species_);
  std::vector<double> unused(size);
  model_->source(q.first(size), std::span(wound_.fraction).subspan(begin_, own()), unused,
                 jacobian_);
}

void System::apply(std::span<const double> v, std::span<double> jv) const {
  diffuse(v, jv);
  const int n = species_;
  const double* j = jacobian_.data();
  for (int i = 0; i < own(); ++i) {
    for (int s = 0; s < n; ++s) {
      for (int t = 0; t < n; ++t) {
        jv[i * n + s] += *j++ * v[i * n + t];
      }
    }
  }
  hold_clamped(jv);
}

void System::factorise(double gamma) {
  const int n = species_;
  block_inverse_.assign(jacobian_.size(), 0.0);
  std::ranges::transform(jacobian_, block_inverse_.begin(), [&](double j) { return -gamma * j; });
  for (const int c : clamped_) {
    std::fill_n(block_inverse_.begin() + static_cast<std::ptrdiff_t>(c) * n, n, 0.0);
  }
  for (int i = 0; i < own(); ++i) {
    for (int s = 0; s < n; ++s) {
      block_inverse_[(i * n + s) * n + s] += 1.0 + gamma * diffusivity_[s] * diagonal_[i];
    }
  }
  for (const int c : clamped_) {
    block_inverse_[c * n + c % n] = 1.0;
  }
  std::vector<int> pivots;
  for (int i = 0; i < own(); ++i) {
    invert(std::span(block_inverse_).subspan(static_cast<std::size_t>(i) * n * n, n * n), n, pivots);
  }
}

void System::precondition(std::span<const double> r, std::span<double> z) const {
  const int n = species_;
  const double* m = block_inverse_.data();
  for (int i = 0; i < own(); ++i) {
    for (int s = 0; s < n; ++s) {
      double sum = 0.0;
      for (int t = 0; t < n; ++t) {
        sum += *m++ * r[i * n + t];
      }
      z[i * n + s] = sum;
    }
  }
}

System::StepLimit System::explicit_limit() const {
  StepLimit limit{std::numeric_limits<double>::max(), 0, 0};
  const int n = species_;
  for (int i = 0; i < own(); ++i) {
    double weights = 0.0;
    for (int e = row_[i]; e < row_[i + 1]; ++e) {
      weights += std::abs(entries_[e].weight);
    }
    for (int s = 0; s < n; ++s) {
      double radius = diffusivity_[s] * (weights + std::abs(diagonal_[i]));
      for (int t = 0; t < n; ++t) {
        radius += std::abs(jacobian_[(i * n + s) * n + t]);
      }
      const bool held = std::ranges::binary_search(clamped_, i * n + s);
      if (!held && radius * limit.dt > 2.0) {
        limit = {2.0 / radius, s, begin_ + i};
      }
    }
  }
  return limit;
}

}  // namespace sanatrix::healing
