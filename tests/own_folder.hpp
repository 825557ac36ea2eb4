// A fresh folder for one test, so that tests can run side by side.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace sanatrix::testing {

inline std::filesystem::path own_folder() {
  const auto& test = *::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) /
      ("sanatrix-" + std::to_string(::getpid()) + "-" + test.name());
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace sanatrix::testing
