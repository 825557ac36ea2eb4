#include "standing/skin_check.hpp"

#include <algorithm>

#include "outcome/scan_target.hpp"

namespace sanatrix::standing {

SkinDistance distance_from_scan(std::span<const Vec3> skin, const TriMesh& scan) {
  const outcome::ScanTarget target(scan);
  SkinDistance result;
  std::vector<double> all;
  for (const Vec3& p : skin) {
    const auto hit = target.closest(p);
    if (target.ends_near(p, hit)) {
      continue;
    }
    all.push_back(hit.distance);
    if (hit.distance > result.largest) {
      result.largest = hit.distance;
      result.worst = p;
    }
  }
  if (!all.empty()) {
    const auto at = all.begin() + static_cast<long>(0.95 * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), at, all.end());
    result.p95 = *at;
  }
  return result;
}

}  // namespace sanatrix::standing
