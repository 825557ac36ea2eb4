// Where the shared development data lies: SANATRIX_SHARED, default ../shared beside the checkout.
#pragma once

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

namespace sanatrix::testing {

inline std::filesystem::path shared_folder() {
  const char* given = std::getenv("SANATRIX_SHARED");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(SANATRIX_SOURCE_DIR) / ".." / "shared";
}

}  // namespace sanatrix::testing

/// Skips the test with a message where the shared data is absent.
#define SANATRIX_REQUIRE_SHARED(relative)                                                    \
  const std::filesystem::path shared_file = sanatrix::testing::shared_folder() / (relative); \
  if (!std::filesystem::exists(shared_file)) {                                               \
    GTEST_SKIP() << shared_file << " is absent (set SANATRIX_SHARED to the shared folder)";  \
  }
