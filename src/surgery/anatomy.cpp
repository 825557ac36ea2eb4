#include "surgery/anatomy.hpp"

#include <algorithm>
#include <cmath>

namespace sanatrix::surgery {
namespace {

std::vector<std::vector<int>> edges_of(const TriMesh& surface) {
  std::vector<std::vector<int>> result(surface.points.size());
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      result[static_cast<std::size_t>(a)].push_back(b);
      result[static_cast<std::size_t>(b)].push_back(a);
    }
  }
  return result;
}

}  // namespace

DistanceField::DistanceField(const SurfaceTree& tree, std::span<const Vec3> body) : tree_(&tree) {
  Vec3 high = body[0];
  low_ = body[0];
  for (const Vec3& p : body) {
    for (std::size_t c = 0; c < 3; ++c) {
      low_[c] = std::min(low_[c], p[c]);
      high[c] = std::max(high[c], p[c]);
    }
  }
  std::size_t count = 1;
  for (std::size_t c = 0; c < 3; ++c) {
    low_[c] -= step;
    size_[c] = static_cast<int>((high[c] - low_[c]) / step) + 3;
    count *= static_cast<std::size_t>(size_[c]);
  }
  samples_ = std::vector<std::atomic<float>>(count);
}

float DistanceField::at(std::array<int, 3> node) const {
  const auto index = [this](const std::array<int, 3>& n) {
    return (static_cast<std::size_t>(n[2]) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(n[1])) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(n[0]);
  };
  std::atomic<float>& sample = samples_[index(node)];
  float value = sample.load(std::memory_order_relaxed);
  if (value == 0.0F) {
    const Vec3 p = low_ + Vec3{step * node[0], step * node[1], step * node[2]};
    value = static_cast<float>(tree_->closest(p).distance);
    sample.store(value, std::memory_order_relaxed);  // whoever else measures finds the same
  }
  return value;
}

double DistanceField::operator()(const Vec3& p) const {
  std::array<int, 3> node{};
  Vec3 part{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double x = (p[c] - low_[c]) / step;
    node[c] = static_cast<int>(std::floor(x));
    if (node[c] < 0 || node[c] + 1 >= size_[c]) {
      return tree_->closest(p).distance;
    }
    part[c] = x - node[c];
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight =
        (i ? part[0] : 1 - part[0]) * (j ? part[1] : 1 - part[1]) * (k ? part[2] : 1 - part[2]);
    sum += weight * at({node[0] + i, node[1] + j, node[2] + k});
  }
  return sum;
}

Anatomy::Anatomy(const TetMesh& mesh, std::span<const Vec3> points, double midline_x_m)
    : mesh_(&mesh),
      points_(points),
      midline_x_m_(midline_x_m),
      skin_(extract_surface(mesh, points, {"skin"})),
      chest_(extract_surface(mesh, points, {"chest"})),
      skin_tree_(skin_.mesh),
      chest_tree_(chest_.mesh),
      to_skin_(skin_tree_, points),
      to_chest_(chest_tree_, points),
      body_(mesh, points),
      skin_edges_(edges_of(skin_.mesh)) {}

}  // namespace sanatrix::surgery
