// The curves where the patches of a domain's surface meet, and whether a mesh can resolve them.
#pragma once

#include <set>
#include <vector>

#include "meshing/deadline.hpp"
#include "meshing/domain_surface.hpp"

namespace sanatrix::meshing {

/// A chain of edges between two patches. Ends where other curves begin; closed when the first
/// vertex comes again at the end.
struct PatchCurve {
  std::vector<int> vertices;
  std::set<Patch> patches;
};
std::vector<PatchCurve> find_curves(const DomainSurface& surface);

/// How far apart [mm] curves stay from each other away from their common ends, or a third of
/// the length of the shortest curve if that is less. A mesh needs smaller edges than this.
double clearance_mm(const DomainSurface& surface, const std::vector<PatchCurve>& curves,
                    const Deadline& deadline);

}  // namespace sanatrix::meshing
