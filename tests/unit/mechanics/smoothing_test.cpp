// Every cell gives a sixth of itself to each of its edges' smoothing domains, or keeps it.
#include "mechanics/smoothing.hpp"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "geometry/structured_mesh.hpp"

namespace sanatrix::mechanics {
namespace {

struct SomeDomains : ::testing::Test {
  TetMesh mesh = block({0.02, 0.01, 0.01}, {4, 3, 3});
  SmoothingDomains domains{mesh.cells, fem::make_edges(mesh.cells)};
  std::vector<Tissue> tissue = std::vector<Tissue>(mesh.cells.size());

  /// Domains that a cell is inside of.
  std::vector<int> times_inside() const {
    std::vector<int> times(mesh.cells.size(), 0);
    for (int d = 0; d < domains.size(); ++d) {
      for (std::size_t i = 0; i < domains.cells(d).size(); ++i) {
        times[static_cast<std::size_t>(domains.cells(d)[i])] += domains.inside(d)[i];
      }
    }
    return times;
  }
};

TEST_F(SomeDomains, CountTheirNodesAsTheirCellsDo) {
  for (int d = 0; d < domains.size(); ++d) {
    std::vector<bool> used(domains.nodes(d).size(), false);
    for (std::size_t i = 0; i < domains.cells(d).size(); ++i) {
      const auto& cell = mesh.cells[static_cast<std::size_t>(domains.cells(d)[i])];
      for (std::size_t a = 0; a < 4; ++a) {
        const auto corner = static_cast<std::size_t>(domains.corners(d)[i][a]);
        ASSERT_EQ(domains.nodes(d)[corner], cell[a]);
        used[corner] = true;
      }
    }
    EXPECT_TRUE(std::ranges::all_of(used, std::identity{}));
  }
}

TEST_F(SomeDomains, OfUniformTissueHoldAllOfIt) {
  domains.leave_out_soft(tissue);
  EXPECT_EQ(times_inside(), std::vector<int>(mesh.cells.size(), 6));
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    EXPECT_EQ(domains.left_out(static_cast<int>(c)), 0.0);
  }
}

TEST_F(SomeDomains, LeaveAFreshWoundAndAGuardedCellToThemselves) {
  const std::size_t soft = mesh.cells.size() / 2;
  tissue[soft].integrity = 0.01;
  tissue.front().guard = 5.0;
  domains.leave_out_soft(tissue);
  EXPECT_EQ(domains.left_out(static_cast<int>(soft)), 1.0);
  EXPECT_EQ(times_inside()[soft], 0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    EXPECT_EQ(domains.left_out(static_cast<int>(c)), c == soft || c == 0 ? 1.0 : 0.0);
  }
}

TEST_F(SomeDomains, LeaveMuchSofterTissueToItselfAtItsWallOnly) {
  const std::size_t soft = mesh.cells.size() / 2;
  for (Tissue& t : tissue) {
    t.c1 = t.c2 = 5.0;
  }
  domains.leave_out_soft(tissue);
  EXPECT_EQ(domains.left_out(static_cast<int>(soft)), 0.0);
  tissue[soft == 0 ? 1 : 0].c1 = 200.0;  // one stiff cell: what shares an edge with it keeps a part
  domains.leave_out_soft(tissue);
  double kept = 0.0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    EXPECT_LT(domains.left_out(static_cast<int>(c)), 1.0);
    kept += domains.left_out(static_cast<int>(c));
  }
  EXPECT_GT(kept, 0.0);
}

}  // namespace
}  // namespace sanatrix::mechanics
