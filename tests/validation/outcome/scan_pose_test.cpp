// The development patients' own scans: found from any pose in which a scanner may hold them, and
// what changed between them measured as with the poses that are known.
#include <fstream>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/scan_file.hpp"
#include "outcome/alignment.hpp"
#include "outcome/scan_comparison.hpp"
#include "outcome/scan_target.hpp"
#include "shared_data.hpp"

namespace sanatrix::outcome {
namespace {

namespace fs = std::filesystem;
constexpr double mm = 1e-3, degree = std::numbers::pi / 180;

Rigid true_pose(fs::path scan) {  // patient -> scan
  const auto file = nlohmann::json::parse(std::ifstream(scan.replace_extension(".json")));
  const auto& rows = file.at("true_lps_to_scan_4x4");
  Rigid pose;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      pose.rotation[i][j] = rows[i][j];
    }
    pose.shift[i] = mm * rows[i][3].get<double>();
  }
  return pose;
}

Mat3 turn(const Vec3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 r;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      r[i][j] = (i == j ? c : 0.0) + (1 - c) * axis[i] * axis[j];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    r[i][(i + 1) % 3] -= s * axis[(i + 2) % 3];
    r[(i + 1) % 3][i] += s * axis[(i + 2) % 3];
  }
  return r;
}

Vec3 direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return normalised({x, y, z});
}

/// Turned by up to 60 degrees about its middle and shifted by up to 40 mm.
Rigid within_60_degrees_and_40_mm(const TriMesh& scan, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  Vec3 middle{};
  for (const Vec3& p : scan.points) {
    middle += (1.0 / static_cast<double>(scan.points.size())) * p;
  }
  const Vec3 axis = direction(random), way = direction(random);
  const Mat3 rotation = turn(axis, 60 * degree * share(random));
  return {rotation, middle - rotation * middle + 40 * mm * share(random) * way};
}

double angle_of(const Mat3& r) {
  return std::acos(std::clamp((r[0][0] + r[1][1] + r[2][2] - 1) / 2, -1.0, 1.0));
}

/// How far the follow-up scan is below the scan before surgery, both in the patient's frame.
Retraction dent_between(const TriMesh& before, const TriMesh& after) {
  std::vector<double> inward = signed_distances(before, after);
  for (double& d : inward) {
    d = -d;
  }
  return retraction(before, inward, std::vector<bool>(inward.size(), true));
}

class DevelopmentScans : public ::testing::TestWithParam<const char*> {};

TEST_P(DevelopmentScans, AreFoundFromAnyStartAndTheirDentIsMeasured) {
  SANATRIX_REQUIRE_SHARED(std::string("data/") + GetParam() + "/scan/upright_preop.obj");
  const fs::path followup_file = shared_file.parent_path() / "upright_followup_standin.obj";
  const TriMesh before =
      moved(io::read_scan(shared_file).surface.mesh, inverse(true_pose(shared_file)));
  const TriMesh followup = io::read_scan(followup_file).surface.mesh;
  const Rigid to_scan = true_pose(followup_file);
  const Retraction wanted = dent_between(before, moved(followup, inverse(to_scan)));
  EXPECT_GT(wanted.depth_m, 4 * mm);  // a nominal 9 mm inwards is less along the slanted skin

  const TriMesh patient = coarsened(before, 6 * mm);
  std::mt19937 random(5);
  for (int trial = 0; trial < 3; ++trial) {
    const Rigid start = within_60_degrees_and_40_mm(followup, random);
    const Alignment found = align({patient, std::vector<double>(patient.points.size(), 1.0), {}},
                                  moved(followup, start));
    const Rigid left = found.to_patient * start * to_scan;  // the identity when all is well
    EXPECT_LT(angle_of(left.rotation), 1.5 * degree);
    EXPECT_LT(norm(left(before.points.front()) - before.points.front()), 2 * mm);
    const Retraction dent = dent_between(before, moved(followup, found.to_patient * start));
    EXPECT_NEAR(dent.depth_m, wanted.depth_m, 1 * mm);
    EXPECT_LT(norm(before.points[static_cast<std::size_t>(dent.vertex)] -
                   before.points[static_cast<std::size_t>(wanted.vertex)]),
              15 * mm);  // half of the width of the dent
  }
}

INSTANTIATE_TEST_SUITE_P(Scan, DevelopmentScans, ::testing::Values("dev01", "dev02"),
                         [](const auto& patient) { return std::string(patient.param); });

}  // namespace
}  // namespace sanatrix::outcome
