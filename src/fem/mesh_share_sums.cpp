// What all shares of a mesh come to: sums, largest values and sizes.
#include "fem/mesh_share.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {

double sum(const MeshShare* share, double mine) {
  return share == nullptr ? mine : sum(mine);
}
void sum_each(const MeshShare* share, std::span<double> mine) {
  if (share != nullptr) {
    sum_each(mine);
  }
}
double largest(const MeshShare* share, double mine) {
  return share == nullptr ? mine : largest(mine);
}

ShareSizes sizes(const MeshShare& share) {
  const std::size_t all = share.vertex().size();
  double own = 0.0;
  for (std::size_t v = 0; v < all; ++v) {
    own += owns_vertex(&share, v) ? 1.0 : 0.0;
  }
  const double ghosts = static_cast<double>(all) - own;
  return {static_cast<int>(largest(own)), static_cast<int>(largest(ghosts)), sum(ghosts) / ranks()};
}

}  // namespace sanatrix::fem
