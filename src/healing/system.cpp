#include "healing/system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/session.hpp"
#include "healing/neighbourhood.hpp"

namespace sanatrix::healing {
namespace {

/// Inverse of a small dense row-major matrix, in place (Gauss-Jordan with row pivoting).
void invert(std::span<double> m, int n, std::vector<int>& pivots) {
  pivots.resize(n);
  for (int k = 0; k < n; ++k) {
    int p = k;
    for (int i = k + 1; i < n; ++i) {
      p = std::abs(m[i * n + k]) > std::abs(m[p * n + k]) ? i : p;
    }
    pivots[k] = p;
    if (p != k) {
      std::swap_ranges(m.begin() + k * n, m.begin() + (k + 1) * n, m.begin() + p * n);
    }
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

/// y[unknown of a] = sum over b of block(a, b) x[unknown of b], block after block.
template <class Store>
void multiply_blocks(std::span<const int> first, std::span<const int> unknown,
                     std::span<const double> blocks, std::span<const double> x, Store store) {
  const double* entry = blocks.data();
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    for (int a = first[i]; a < first[i + 1]; ++a) {
      double sum = 0.0;
      for (int b = first[i]; b < first[i + 1]; ++b) {
        sum += *entry++ * x[unknown[b]];
      }
      store(unknown[a], sum);
    }
  }
}

}  // namespace

System::System(const TetMesh& mesh, std::span<const Vec3> points,
               std::span<const double> wound_fraction, const Model& model,
               const fem::MeshShare* share)
    : model_(&model),
      share_(share),
      species_(static_cast<int>(model.species().size())),
      wound_(make_wound_map(mesh, points, wound_fraction, share)) {
  for (int s = 0; s < species_; ++s) {
    const Species& kind = model.species()[s];
    Group& group = groups_[kind.clamped_outside ? 1 : 0];
    group.species.push_back(s);
    group.diffusion.diffusivity.push_back(kind.diffusivity);
    group.diffusion.healthy.push_back(kind.healthy);
  }
  const std::vector<bool> near = neighbourhood(model, points, wound_, share);
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (near[v] && fem::owns_vertex(share, v)) {
      own_.push_back(static_cast<int>(v));
      wound_share_.push_back(wound_.fraction[v]);
      if (wound_.vertex[v]) {
        groups_[1].vertices.push_back(static_cast<int>(v));
      }
    }
  }
  groups_[0].vertices = own_;
  for (Group& group : groups_) {
    group.diffusion.first = own_unknowns_;
    own_unknowns_ += group.stride() * static_cast<int>(group.vertices.size());
  }
  all_unknowns_ = static_cast<int>(fem::sum(share, own_unknowns_));
  wound_unknowns_ =
      static_cast<int>(fem::sum(share, species_ * static_cast<double>(groups_[1].vertices.size())));
  const std::vector<double> global = global_numbers();
  for (std::size_t g = 0; g < 2; ++g) {
    groups_[g].diffusion.laplacian = make_laplacian(
        mesh, points, wound_, g == 0 ? Domain::Mesh : Domain::Wound, near, groups_[g].vertices);
    localise_columns(g, global);
  }
  index_vertices();
}

/// For every vertex and either group the global number of its first unknown, -1 where it has none.
/// Numbers go process after process, and within one as in its own vector.
std::vector<double> System::global_numbers() const {
  std::vector<double> global(2 * wound_.vertex.size(), -1.0);
  if (share_ == nullptr) {
    return global;  // nobody asks: there are no ghosts
  }
  const double before = fem::sum_before(own_unknowns_);
  for (std::size_t g = 0; g < 2; ++g) {
    double next = before + groups_[g].diffusion.first;
    for (const int v : groups_[g].vertices) {
      global[2 * v + g] = next;
      next += groups_[g].stride();
    }
  }
  share_->fetch(global, 2);
  return global;
}

/// Columns that are vertices become places in the local vector: own unknowns, then ghosts.
void System::localise_columns(std::size_t g, std::span<const double> global) {
  Group& group = groups_[g];
  auto& entries = group.diffusion.laplacian.entries;
  const auto mine = [&](int vertex) {
    return fem::owns_vertex(share_, vertex);
  };
  std::vector<int> strangers;
  for (const auto& e : entries) {
    if (!mine(e.column)) {
      strangers.push_back(e.column);
    }
  }
  std::ranges::sort(strangers);
  const auto repeated = std::ranges::unique(strangers);
  strangers.erase(repeated.begin(), repeated.end());
  const int first_ghost = own_unknowns_ + static_cast<int>(ghosts_.size());
  for (const int v : strangers) {
    for (int s = 0; s < group.stride(); ++s) {
      ghosts_.push_back(static_cast<int>(global[2 * v + g]) + s);
    }
  }
  const auto place = [](const std::vector<int>& sorted, int vertex) {
    return static_cast<int>(std::ranges::lower_bound(sorted, vertex) - sorted.begin());
  };
  for (auto& e : entries) {
    e.column = mine(e.column)
                   ? group.diffusion.first + group.stride() * place(group.vertices, e.column)
                   : first_ghost + group.stride() * place(strangers, e.column);
  }
}

void System::index_vertices() {
  std::vector<int> place(wound_.vertex.size(), -1);  // among own vertices
  for (std::size_t i = 0; i < own_.size(); ++i) {
    place[own_[i]] = static_cast<int>(i);
  }
  std::vector<std::vector<std::array<int, 2>>> of(own_.size());  // species, unknown
  for (const Group& group : groups_) {
    int unknown = group.diffusion.first;
    for (const int v : group.vertices) {
      for (const int s : group.species) {
        of[place[v]].push_back({s, unknown++});
      }
    }
  }
  first_.push_back(0);
  block_.push_back(0);
  for (auto& unknowns : of) {
    std::ranges::sort(unknowns);
    for (const auto& [s, k] : unknowns) {
      species_of_.push_back(s);
      unknown_.push_back(k);
    }
    const int size = static_cast<int>(unknowns.size());
    first_.push_back(first_.back() + size);
    block_.push_back(block_.back() + size * size);
  }
  at_vertices_.resize(of.size() * species_);
  rates_.resize(at_vertices_.size());
  full_jacobian_.resize(at_vertices_.size() * species_);
  source_jacobian_.resize(block_.back());
  // What is clamped stays as it is written here.
  for (std::size_t k = 0; k < at_vertices_.size(); ++k) {
    at_vertices_[k] = model_->species()[k % species_].healthy;
  }
}

std::vector<double> System::initial_state() const {
  std::vector<double> q;
  q.reserve(wound_.vertex.size() * species_);
  for (const bool wounded : wound_.vertex) {
    for (const Species& s : model_->species()) {
      q.push_back(wounded ? s.wounded : s.healthy);
    }
  }
  return q;
}

void System::pick_unknowns(std::span<const double> state, std::span<double> own) const {
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (int k = first_[i]; k < first_[i + 1]; ++k) {
      own[unknown_[k]] = state[own_[i] * species_ + species_of_[k]];
    }
  }
}

void System::gather(std::span<const double> own, std::span<double> at_vertices) const {
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (int k = first_[i]; k < first_[i + 1]; ++k) {
      at_vertices[i * species_ + species_of_[k]] = own[unknown_[k]];
    }
  }
}

std::vector<double> System::at_vertices(std::span<const double> own) const {
  std::vector<double> mine = at_vertices_;
  gather(own, mine);
  std::vector<double> result;
  result.reserve(wound_.vertex.size() * species_);
  for (std::size_t v = 0; v < wound_.vertex.size(); ++v) {
    for (const Species& s : model_->species()) {
      result.push_back(s.healthy);
    }
  }
  for (std::size_t i = 0; i < own_.size(); ++i) {
    std::copy_n(mine.begin() + i * species_, species_, result.begin() + own_[i] * species_);
  }
  if (share_ != nullptr) {
    share_->fetch(result, species_);
  }
  return result;
}

void System::rate(std::span<const double> q, std::span<double> dq) {
  for (const Group& group : groups_) {
    group.diffusion.apply(q, dq);
  }
  gather(q, at_vertices_);
  model_->source(at_vertices_, wound_share_, rates_, {});
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (int k = first_[i]; k < first_[i + 1]; ++k) {
      dq[unknown_[k]] += rates_[i * species_ + species_of_[k]];
    }
  }
}

void System::linearise(std::span<const double> q) {
  gather(q, at_vertices_);
  model_->source(at_vertices_, wound_share_, rates_, full_jacobian_);
  double* entry = source_jacobian_.data();
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (int a = first_[i]; a < first_[i + 1]; ++a) {
      const double* const row = &full_jacobian_[(i * species_ + species_of_[a]) * species_];
      for (int b = first_[i]; b < first_[i + 1]; ++b) {
        *entry++ = row[species_of_[b]];
      }
    }
  }
}

void System::apply(std::span<const double> v, std::span<double> jv) const {
  for (const Group& group : groups_) {
    group.diffusion.apply_homogeneous(v, jv);
  }
  multiply_blocks(first_, unknown_, source_jacobian_, v,
                  [&](int k, double value) { jv[k] += value; });
}

void System::factorise(double gamma) {
  block_inverse_.resize(source_jacobian_.size());
  std::ranges::transform(source_jacobian_, block_inverse_.begin(),
                         [&](double j) { return -gamma * j; });
  std::vector<double> diagonal(own_unknowns_);
  for (const auto& [species, vertices, d] : groups_) {
    for (std::size_t k = 0; k < species.size() * vertices.size(); ++k) {
      diagonal[d.first + k] =
          d.diffusivity[k % species.size()] * d.laplacian.diagonal[k / species.size()];
    }
  }
  std::vector<int> pivots;
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    const int size = first_[i + 1] - first_[i];
    const auto block = std::span(block_inverse_).subspan(block_[i], size * size);
    for (int a = 0; a < size; ++a) {
      block[a * size + a] += 1.0 + gamma * diagonal[unknown_[first_[i] + a]];
    }
    invert(block, size, pivots);
  }
}

void System::precondition(std::span<const double> r, std::span<double> z) const {
  multiply_blocks(first_, unknown_, block_inverse_, r, [&](int k, double value) { z[k] = value; });
}

System::StepLimit System::explicit_limit() const {
  std::vector<double> radius(own_unknowns_);
  for (const auto& [species, vertices, d] : groups_) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      double weights = d.laplacian.diagonal[i];
      for (int e = d.laplacian.row[i]; e < d.laplacian.row[i + 1]; ++e) {
        weights += std::abs(d.laplacian.entries[e].weight);
      }
      for (std::size_t s = 0; s < species.size(); ++s) {
        radius[d.first + i * species.size() + s] = d.diffusivity[s] * weights;
      }
    }
  }
  std::vector<double> magnitude(source_jacobian_.size());
  std::ranges::transform(source_jacobian_, magnitude.begin(), [](double j) { return std::abs(j); });
  multiply_blocks(first_, unknown_, magnitude, std::vector<double>(own_unknowns_, 1.0),
                  [&](int k, double sum) { radius[k] += sum; });
  StepLimit limit{std::numeric_limits<double>::max(), 0, 0};
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (int k = first_[i]; k < first_[i + 1]; ++k) {
      if (radius[unknown_[k]] * limit.dt > 2.0) {
        limit = {2.0 / radius[unknown_[k]], species_of_[k], own_[i]};
      }
    }
  }
  return limit;
}

}  // namespace sanatrix::healing
