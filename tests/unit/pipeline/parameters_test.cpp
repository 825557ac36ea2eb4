// Parameters: what is accepted, how it is kept, and what is refused with which words.
#include "pipeline/parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"

namespace sanatrix::pipeline {
namespace {

using ::testing::HasSubstr;

TEST(Parameters, HaveDefaultsUntilGiven) {
  Parameters p;
  EXPECT_EQ(p.number("heal.days"), 90.0);
  EXPECT_FALSE(p.has("mesh.target_vertices"));
  p.set("heal.days=30");
  EXPECT_EQ(p.number("heal.days"), 30.0);
  p.set("heal.days=");
  EXPECT_EQ(p.number("heal.days"), 90.0);
}

TEST(Parameters, EqualValuesHaveOneSpelling) {
  Parameters a, b;
  a.set("surgery.margin_mm=15");
  b.set("surgery.margin_mm=1.50e1");
  EXPECT_EQ(a.given(), b.given());
}

TEST(Parameters, EveryDefaultIsAccepted) {
  for (const ParameterInfo& info : parameter_table()) {
    Parameters p;
    EXPECT_NO_THROW(p.set(info.key, info.standard)) << info.key;
    EXPECT_FALSE(info.doc.empty()) << info.key;
  }
  EXPECT_NO_THROW(Parameters{}.check());
}

TEST(Parameters, UnknownKeysAreAUsageErrorThatListsTheKnownOnes) {
  Parameters p;
  try {
    p.set("mesh.colour=red");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Usage);
    EXPECT_THAT(e.hint(), HasSubstr("mesh.target_vertices"));
  }
}

TEST(Parameters, ValuesOutsideTheirRangeAreRefused) {
  Parameters p;
  for (const char* bad : {"heal.days=0", "heal.days=nan", "heal.days=9 days", "heal.days=1e99",
                          "mesh.target_vertices=1000.5", "solver.element=p3p3"}) {
    EXPECT_THROW(p.set(bad), Error) << bad;
  }
  EXPECT_TRUE(p.given().empty());
}

TEST(Parameters, OverridesOfTheModelAreCheckedTogether) {
  Parameters p;
  p.set("heal.overrides=no_such_value=1");
  EXPECT_THROW(p.check(), Error);
  p.set("heal.overrides=");
  p.set("tissue.preset=wood");
  EXPECT_THROW(p.check(), Error);
}

}  // namespace
}  // namespace sanatrix::pipeline
