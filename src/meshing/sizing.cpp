// Edge lengths from the distance to the focus and the thickness of the tissue.
#include "meshing/sizing.hpp"

#include <algorithm>
#include <cmath>

namespace sanatrix::meshing {
namespace {

/// Edges grow by this much per mm away from the focus; steeper gradings cost angles.
constexpr double growth = 0.4;
/// Thin tissue gets elements of this part of its thickness, but not below the floor, which keeps
/// the skin over the sternum from using up all vertices.
constexpr double thickness_part = 0.55;
constexpr double thin_floor_mm = 5.0;
/// Edges outside the focus may grow by this before the focus is made coarser too.
constexpr double most_far_growth = 1.6;
/// The focus may become coarser by this; beyond it the number of vertices must give way.
constexpr double most_near_growth = 2.0;
/// First guess of vertices per (edge length)^3; meshes of patients need 1.0 to 1.3.
constexpr double usual_vertices_per_cube = 1.15;

}  // namespace

Sizing::Sizing(const Anatomy& anatomy, const MeshOptions& options)
    : thickness_(anatomy.thickness),
      focus_(options.focus),
      asked_near_mm_(1e3 * options.near_edge_m),
      asked_far_mm_(1e3 * options.far_edge_m),
      vertices_per_cube_(usual_vertices_per_cube) {
  const Image3<float>& skin = anatomy.outside_skin;
  constexpr int step = 2;
  volume_per_sample_mm3_ = skin.voxel_volume_mm3() * step * step * step;
  for (int k = 0; k < skin.size[2]; k += step) {
    for (int j = 0; j < skin.size[1]; j += step) {
      for (int i = 0; i < skin.size[0]; i += step) {
        const std::size_t voxel = skin.index(i, j, k);
        const Vec3 p = skin.position_mm(i, j, k);
        bool inside = skin.voxels[voxel] < 0.0F && anatomy.behind_chest.voxels[voxel] < 0.0F;
        for (std::size_t a = 0; a < 3; ++a) {
          inside = inside && p[a] > anatomy.box.low_mm[a] && p[a] < anatomy.box.high_mm[a];
        }
        if (inside) {
          samples_.push_back({thickness_.voxels[voxel], beyond_focus_mm(p)});
        }
      }
    }
  }
  set_scale(1.0);
}

double Sizing::beyond_focus_mm(const Vec3& p_mm) const {
  if (!focus_) {
    return 1e3;
  }
  const Vec3 p = 1e-3 * p_mm;
  const Vec3 axis = focus_->b - focus_->a;
  const double t =
      std::clamp(dot(p - focus_->a, axis) / std::max(dot(axis, axis), 1e-12), 0.0, 1.0);
  return 1e3 * (norm(p - (focus_->a + t * axis)) - focus_->radius);
}

double Sizing::edge_mm(const Sample& s) const {
  const double in_thin = std::max(thin_part_ * s.thickness, thin_floor_mm);
  const double in_focus = near_mm_ + growth * std::max(0.0, s.beyond_focus);
  return std::min({far_mm_, in_thin, in_focus});
}

double Sizing::edge_mm(const Vec3& p_mm) const {
  return edge_mm(Sample{sample(thickness_, p_mm), beyond_focus_mm(p_mm)});
}

void Sizing::set_scale(double scale) {
  far_mm_ = std::max(asked_far_mm_ * std::min(scale, most_far_growth), asked_near_mm_);
  near_mm_ = std::min(asked_near_mm_ * std::max(1.0, scale / most_far_growth), far_mm_);
  thin_part_ = thickness_part * std::clamp(scale, 1.0, most_far_growth);
}

double Sizing::edge_cubes() const {
  double sum = 0.0;
  for (const Sample& s : samples_) {
    const double h = edge_mm(s);
    sum += 1.0 / (h * h * h);
  }
  return volume_per_sample_mm3_ * sum;
}

void Sizing::learn(int count) {
  const Known latest{edge_cubes(), static_cast<double>(count)};
  vertices_per_cube_ = latest.count / latest.cubes;
  other_vertices_ = 0.0;
  if (known_ && std::abs(latest.cubes - known_->cubes) > 0.05 * known_->cubes) {
    // The slope between two meshes shows what part of the vertices the sizes do not govern.
    const double slope = (latest.count - known_->count) / (latest.cubes - known_->cubes);
    vertices_per_cube_ = std::clamp(slope, 0.3 * vertices_per_cube_, vertices_per_cube_);
    other_vertices_ = latest.count - vertices_per_cube_ * latest.cubes;
  }
  known_ = latest;
}

void Sizing::aim_at(int target) {
  double low = 0.1;
  double high = most_far_growth * most_near_growth;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    set_scale(middle);
    (other_vertices_ + vertices_per_cube_ * edge_cubes() > target ? low : high) = middle;
  }
  set_scale(high);
}

}  // namespace sanatrix::meshing
