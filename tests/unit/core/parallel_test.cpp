// Pieces of work side by side: each once, and errors arrive.
#include "core/parallel.hpp"

#include <atomic>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace sanatrix {
namespace {

TEST(SideBySide, DoesEveryPieceOnceAndPassesErrorsOn) {
  std::vector<std::atomic<int>> done(1000);
  side_by_side(1000, [&](int i) { ++done[static_cast<std::size_t>(i)]; });
  for (const auto& times : done) {
    EXPECT_EQ(times, 1);
  }
  EXPECT_THROW(side_by_side(10, [](int i) { require(i != 7, "the seventh"); }), Error);
}

}  // namespace
}  // namespace sanatrix
