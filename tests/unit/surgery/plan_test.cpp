// Plans as JSON: what is read, what is refused and with which words, what is kept.
#include "surgery/plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "shared_data.hpp"

namespace sanatrix::surgery {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

json minimal() {
  return json::parse(R"({"operated_side": "L", "tumour": {"centre_lps_mm": [60, -40, 5],
    "equivalent_radius_mm": 6}, "planned_margin_mm": 8})");
}

std::string refusal(const json& document) {
  try {
    read_plan(document.dump(), "p.json");
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Input);
    EXPECT_EQ(e.one_line().find('\n'), std::string::npos);
    return e.one_line();
  }
  return "accepted";
}

TEST(APlan, NeedsOnlySideCentreRadiusAndMargin) {
  const Plan plan = read_plan(minimal().dump(), "p.json");
  EXPECT_EQ(plan.side, Side::Left);
  EXPECT_EQ(plan.frame, Frame::Prone);
  EXPECT_DOUBLE_EQ(plan.tumour_centre[1], -0.040);
  EXPECT_DOUBLE_EQ(plan.tumour_radius, 0.006);
  EXPECT_DOUBLE_EQ(plan.margin, 0.008);
  EXPECT_FALSE(plan.radius || plan.axis);
}

TEST(APlan, OfTheSharedPatientsIsReadAsWritten) {
  SANATRIX_REQUIRE_SHARED("data/dev01/plan.json");
  const Plan one = read_plan(read_text(shared_file), "plan.json");
  EXPECT_EQ(one.side, Side::Left);
  EXPECT_NEAR(one.tumour_centre[0], 0.09416, 1e-12);
  EXPECT_NEAR(one.radius.value(), 0.0157, 1e-12);
  EXPECT_NEAR(norm(one.axis.value()), 1.0, 1e-12);
  const auto second = sanatrix::testing::shared_folder() / "data/dev02/plan.json";
  EXPECT_EQ(read_plan(read_text(second), "plan.json").side, Side::Right);
}

TEST(APlan, ThatIsWrongIsRefusedByTheNameOfItsKey) {
  const auto with = [](const std::string& pointer, const json& value) {
    json document = minimal();
    document[json::json_pointer(pointer)] = value;
    return refusal(document);
  };
  EXPECT_THAT(with("/operated_side", "left"), HasSubstr("operated_side"));
  EXPECT_THAT(with("/midline_x_mm", 70.0), HasSubstr("patient's RIGHT"));
  EXPECT_THAT(with("/operated_side", "R") + with("/midline_x_mm", 0.0), HasSubstr("accepted"));
  EXPECT_THAT(with("/tumour/centre_lps_mm", json::array({60, -40})), HasSubstr("centre_lps_mm"));
  EXPECT_THAT(with("/tumour/centre_lps_mm/1", 1e300 * 1e300), HasSubstr("finite"));
  EXPECT_THAT(with("/tumour/centre_lps_mm/1", "x"), HasSubstr("finite"));
  EXPECT_THAT(with("/tumour/centre_lps_mm/1", -40000.0), HasSubstr("millimetres"));
  EXPECT_THAT(with("/tumour/equivalent_radius_mm", 0.006), HasSubstr("equivalent_radius_mm"));
  EXPECT_THAT(with("/planned_margin_mm", -1.0), HasSubstr("planned_margin_mm"));
  EXPECT_THAT(with("/clearance_mm", 0.0), HasSubstr("clearance_mm"));
  EXPECT_THAT(with("/resection/radius_mm", 5.0), HasSubstr("smaller than the tumour"));
  EXPECT_THAT(with("/resection/axis_towards_skin_lps", json::array({0, 0, 0})), HasSubstr("zero"));
  EXPECT_THAT(with("/frame", "sitting"), HasSubstr("frame"));
  EXPECT_THAT(with("/coordinates", "LPS mm, SUPINE configuration"), HasSubstr("SUPINE"));
  EXPECT_THAT(with("/incisions_lps_mm", json::array({json::array()})), HasSubstr("incisions"));
  json no_tumour = minimal();
  no_tumour.erase("tumour");
  EXPECT_THAT(refusal(no_tumour), HasSubstr("tumour.centre_lps_mm is missing"));
  EXPECT_THAT(refusal(json::array()), HasSubstr("not a JSON object"));
}

TEST(APlan, SurvivesWritingWithKeysThatAreNotOurs) {
  json document = minimal();
  document["patient"] = "p3";
  document["resection"]["radius_mm"] = 14.0;
  document["incisions_lps_mm"] = {{{60, -80, 5}, {70, -80, 5}}};
  Plan plan = read_plan(document.dump(), "p.json");
  plan.frame = Frame::Supine;
  plan.tumour_centre[0] = 0.065;
  const std::string text = write_plan(plan);
  EXPECT_EQ(json::parse(text)["patient"], "p3");
  const Plan again = read_plan(text, "again.json");
  EXPECT_EQ(again.frame, Frame::Supine);
  EXPECT_DOUBLE_EQ(again.tumour_centre[0], 0.065);
  ASSERT_EQ(again.incisions.size(), 1u);
  EXPECT_DOUBLE_EQ(again.incisions[0][1][0], 0.070);
}

TEST(APlan, KeepsItsSegmentAndRefusesOneThatIsNotMeant) {
  json document = minimal();
  document["resection"]["segment"] = {
      {"apex_lps_mm", {70, -90, 5}}, {"angle_deg", 50.0}, {"to_mm", 60.0}};
  const Plan again = read_plan(write_plan(read_plan(document.dump(), "p.json")), "again.json");
  ASSERT_TRUE(again.segment.has_value());
  EXPECT_DOUBLE_EQ(again.segment->apex[0], 0.070);
  EXPECT_NEAR(again.segment->angle.value(), 50 * 3.14159265358979 / 180, 1e-12);
  EXPECT_FALSE(again.segment->from.has_value());
  EXPECT_DOUBLE_EQ(again.segment->to.value(), 0.060);
  document["resection"]["outline_lps_mm"] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  EXPECT_THAT(refusal(document), HasSubstr("both a segment and an outline"));
  document["resection"].erase("outline_lps_mm");
  document["resection"]["segment"]["angle_deg"] = 0.8;  // radians by mistake
  EXPECT_THAT(refusal(document), HasSubstr("angle_deg is 0.8, not within"));
}

TEST(APlan, CylinderOfTumourAndMarginFollowsTheMargin) {
  json document = minimal();
  document["resection"]["radius_mm"] = 14.0;
  Plan plan = read_plan(document.dump(), "p.json");
  set_plan_value(plan, "margin_mm", "12");
  EXPECT_NEAR(plan.radius.value(), 0.018, 1e-12);
  set_plan_value(plan, "radius_mm", "25");
  set_plan_value(plan, "margin_mm", "10");
  EXPECT_NEAR(plan.radius.value(), 0.025, 1e-12);
  EXPECT_THROW(set_plan_value(plan, "margin_mm", "12mm"), Error);
  EXPECT_THROW(set_plan_value(plan, "radius_mm", "5"), Error);
  try {
    set_plan_value(plan, "depth_mm", "5");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Usage);
  }
}

}  // namespace
}  // namespace sanatrix::surgery
