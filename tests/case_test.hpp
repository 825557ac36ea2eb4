// Cases of `sanatrix verify` as tests: one test per case.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared_data.hpp"
#include "verification/case.hpp"

namespace sanatrix::verification {

/// Keys of the cases that are fast enough for the tests.
template <class Wanted>
std::vector<std::string> fast_cases(Wanted wanted) {
  std::vector<std::string> keys;
  for (const Case& one : all_cases()) {
    if (one.cost == Cost::Fast && wanted(one.chapter)) {
      keys.push_back(one.key);
    }
  }
  return keys;
}

/// Names of tests are made of letters and digits.
inline std::string name_of(std::string key) {
  std::ranges::replace(key, '-', '_');
  return key;
}

class AVerificationCase : public ::testing::TestWithParam<std::string> {};

inline void expect_pass(const std::string& key) {
  setenv("SANATRIX_SHARED", testing::shared_folder().c_str(), 0);
  const auto one = std::ranges::find(all_cases(), key, &Case::key);
  Silent silent;
  const Findings found = one->run(Context("verify", silent));
  if (!found.skipped.empty()) {
    GTEST_SKIP() << found.skipped;
  }
  EXPECT_FALSE(found.checks.empty());
  for (const Check& check : found.checks) {
    EXPECT_TRUE(check.pass()) << check.name << ": " << check.computed << " is outside " << check.low
                              << " ... " << check.high << " (" << check.reason << ")";
  }
}

}  // namespace sanatrix::verification
