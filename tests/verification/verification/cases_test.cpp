// The fast cases of `sanatrix verify`: code and calculation verification.
#include "case_test.hpp"

namespace sanatrix::verification {
namespace {

INSTANTIATE_TEST_SUITE_P(Fast, AVerificationCase,
                         ::testing::ValuesIn(fast_cases([](Chapter chapter) {
                           return chapter != Chapter::Validation;
                         })),
                         [](const auto& p) { return name_of(p.param); });

TEST_P(AVerificationCase, MeetsItsReference) {
  expect_pass(GetParam());
}

}  // namespace
}  // namespace sanatrix::verification
