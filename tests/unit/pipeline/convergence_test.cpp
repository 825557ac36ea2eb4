// Error bars from three meshes, where the limit is known.
#include "pipeline/convergence.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace sanatrix::pipeline {
namespace {

std::vector<double> values_of_order(double p, const std::vector<double>& h, double limit) {
  std::vector<double> values;
  for (const double edge : h) {
    values.push_back(limit + 3.0 * std::pow(edge, p));
  }
  return values;
}

TEST(Richardson, FindsTheOrderForUnequalRatiosAndItsBarHoldsTheLimit) {
  const std::vector<double> h{1.7, 1.25, 1.0};
  for (const double p : {1.0, 1.4, 2.0}) {
    const std::vector<double> values = values_of_order(p, h, 7.0);
    const ErrorBar bar = richardson(h, values);
    EXPECT_NEAR(bar.order, p, 1e-9);
    EXPECT_TRUE(bar.observed);
    EXPECT_NEAR(bar.half_size, 1.25 * (values.back() - 7.0), 1e-8);  // the safety factor
  }
}

TEST(Richardson, FasterThanSecondOrderCountsAsSecondOrder) {
  const std::vector<double> h{2.0, 1.4, 1.0};
  const ErrorBar bar = richardson(h, values_of_order(3.0, h, 7.0));
  EXPECT_NEAR(bar.order, 2.0, 1e-9);
  EXPECT_GT(bar.half_size, 3.0 * std::pow(1.0, 3));
}

TEST(Richardson, ValuesThatDoNotSettleGetNoOrderAndAtLeastTheirSpread) {
  const std::vector<double> h{1.69, 1.3, 1.0};
  for (const std::vector<double>& values :
       {std::vector{1.0, 2.0, 1.9}, {1.0, 1.1, 1.3}, {1.0, 2.0, 2.0}}) {
    const ErrorBar bar = richardson(h, values);
    EXPECT_FALSE(bar.observed);
    EXPECT_EQ(bar.order, 1.0);
    EXPECT_GE(bar.half_size, *std::ranges::max_element(values) - *std::ranges::min_element(values));
  }
  const ErrorBar same = richardson(h, std::vector{4.0, 4.0, 4.0});
  EXPECT_TRUE(same.observed);
  EXPECT_EQ(same.half_size, 0.0);
}

TEST(Richardson, OfMoreMeshesTheFinestThreeCount) {
  const std::vector<double> h{3.0, 1.7, 1.25, 1.0};
  std::vector<double> values = values_of_order(2.0, h, 7.0);
  values.front() = 100.0;
  EXPECT_NEAR(richardson(h, values).order, 2.0, 1e-9);
}

}  // namespace
}  // namespace sanatrix::pipeline
