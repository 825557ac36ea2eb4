// The built-in patient: sizes, tissue shares, labels and plan of a coarse variant.
#include "phantom/phantom.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "phantom/body_mesh.hpp"

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3, cm3 = 1e-6;

TEST(AThorax, FindsThePlaceOfEveryPointBeforeAndBehindIt) {
  const Thorax thorax(0.19);
  for (const double s : {-0.185, -0.09, -0.01, 0.003, 0.06, 0.15}) {
    for (const double t : {-0.015, 0.0, 0.08}) {
      const ChestPlace found = thorax.locate(thorax.point({s, 0.03, t}));
      EXPECT_NEAR(found.s, s, 1e-5);
      EXPECT_NEAR(found.t, t, 1e-5);
    }
  }
}

TEST(AnAnatomy, HasTheVolumeThatWasAskedFor) {
  for (const double volume : {150.0, 600.0, 1500.0}) {
    const Anatomy anatomy(volume * cm3, 3);
    const BodyMesh body = mesh_body(anatomy, 8 * mm);
    const auto volumes = cell_volumes(body.mesh, body.mesh.points);
    EXPECT_GT(*std::ranges::min_element(volumes), 0.0);
    double right = 0.0, left = 0.0;
    for (std::size_t c = 0; c < volumes.size(); ++c) {
      ChestPlace middle{};
      for (const int v : body.mesh.cells[c]) {
        const ChestPlace& p = body.places[static_cast<std::size_t>(v)];
        middle = {middle.s + 0.25 * p.s, middle.z + 0.25 * p.z, 0.0};
      }
      const Breast& breast = anatomy.breast_at(middle.s);
      if (anatomy.base_radius(breast, middle.s, middle.z) < 1.0) {
        (middle.s > 0.0 ? left : right) += volumes[c] / cm3;
      }
    }
    // 3 % of asymmetry by seed, 2 % for cells that the base's rim cuts.
    EXPECT_NEAR(right, volume, 0.05 * volume);
    EXPECT_NEAR(left, volume, 0.05 * volume);
    // Shapes the P2 element can bear.
    EXPECT_GT(std::ranges::min(min_dihedral_angles(body.mesh, body.mesh.points)), 4.0);
  }
}

TEST(ATissueMap, HoldsTheGlandOfItsDensityClass) {
  const std::map<Density, double> shares{{Density::Fatty, 0.12},
                                         {Density::Scattered, 0.20},
                                         {Density::Heterogeneous, 0.35},
                                         {Density::Dense, 0.55}};
  for (const double volume : {150.0, 900.0}) {
    const Anatomy anatomy(volume * cm3, 4);
    const BodyMesh body = mesh_body(anatomy, 26 * mm);
    const auto volumes = cell_volumes(body.mesh, body.mesh.points);
    for (const auto& [density, share] : shares) {
      const TissueMap tissue(anatomy, density, 4);
      const auto fraction = gland_fractions(body, anatomy, tissue);
      const double gland =
          std::inner_product(volumes.begin(), volumes.end(), fraction.begin(), 0.0);
      const double breasts = anatomy.breasts()[0].volume + anatomy.breasts()[1].volume;
      // 3 points: the cells' 64 samples resolve lobes of 10 mm, the tumour adds up to half a point.
      EXPECT_NEAR(gland / breasts, share, 0.03);
    }
  }
}

Phantom coarse(std::uint64_t seed) {
  Silent silent;
  return make_phantom({.seed = seed,
                       .volume_cm3 = 400.0,
                       .density = Density::Heterogeneous,
                       .edge_m = 26 * mm,
                       .voxel_mm = 2.0},
                      Context("phantom", silent));
}

const Phantom& first() {
  static const Phantom phantom = coarse(1);
  return phantom;
}

std::array<double, 11> volumes_cm3(const LabelImage& labels, int side) {
  std::array<double, 11> volume{};
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i) {
        if (side * labels.position_mm(i, j, k)[0] > 0.0) {
          volume.at(labels.at(i, j, k)) += labels.voxel_volume_mm3() * 1e-3;
        }
      }
    }
  }
  return volume;
}

TEST(APhantom, HasTissueSharesAndLabelsOfAPatient) {
  const Phantom& phantom = first();
  for (const int side : {-1, 1}) {
    const auto volume = volumes_cm3(phantom.labels, side);
    // 35 % of the breast's volume within 3 points; the tumour and the skin take little of it.
    EXPECT_NEAR(volume[2] / 400.0, 0.35, 0.03);
    EXPECT_GT(volume[1], 300.0);
    EXPECT_GT(volume[3], 50.0);
    EXPECT_GT(volume[4], 200.0);
    EXPECT_GT(volume[5], 50.0);
    EXPECT_GT(volume[6], 100.0);
    EXPECT_GT(volume[9], 0.1);
  }
  EXPECT_GT(volumes_cm3(phantom.labels, -1)[8] + volumes_cm3(phantom.labels, 1)[8], 0.3);
}

TEST(APhantom, KeepsItsVolumeAndHangsStandsAndFlattens) {
  const Phantom& phantom = first();
  const auto total = [&](std::span<const Vec3> points) {
    const auto volumes = cell_volumes(phantom.mesh, points);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
  };
  const double unloaded = total(phantom.mesh.points);
  const int nipple = phantom.mesh.named_points.at("nipple_L");
  const auto moved = [&](const std::vector<Vec3>& pose) {
    return pose[static_cast<std::size_t>(nipple)] -
           phantom.mesh.points[static_cast<std::size_t>(nipple)];
  };
  // Incompressible but for kappa, and for the chords of curved P2 edges.
  for (const auto* pose : {&phantom.prone, &phantom.supine, &phantom.upright}) {
    EXPECT_NEAR(total(*pose), unloaded, 0.01 * unloaded);
  }
  EXPECT_LT(moved(phantom.prone)[1], -3 * mm);
  EXPECT_GT(moved(phantom.supine)[1], 3 * mm);
  EXPECT_LT(moved(phantom.upright)[2], -3 * mm);
}

TEST(APhantom, IsChangedByItsSurgeryOnTheTreatedSideAlone) {
  const Phantom& phantom = first();
  const int side = nlohmann::json::parse(phantom.plan_json)["operated_side"] == "L" ? 1 : -1;
  ASSERT_EQ(phantom.skin.upright_after.triangles, phantom.skin.upright.triangles);
  double treated = 0.0, other = 0.0;
  for (std::size_t v = 0; v < phantom.skin.upright.points.size(); ++v) {
    const Vec3& p = phantom.skin.upright.points[v];
    double& largest = side * p[0] > 0 ? treated : other;
    largest = std::max(largest, norm(phantom.skin.upright_after.points[v] - p));
  }
  // 8 % of a wound of 20 to 50 cm3 is a few cm3: less than a centimetre anywhere on the skin.
  EXPECT_GT(phantom.excised_m3, 5 * cm3);
  EXPECT_GT(treated, 0.2 * mm);
  EXPECT_LT(treated, 10 * mm);
  EXPECT_LT(other, 0.3 * treated);
}

TEST(APhantom, HasAPlanThatPointsAtItsTumour) {
  const Phantom& phantom = first();
  const auto plan = nlohmann::json::parse(phantom.plan_json);
  const auto centre = plan["tumour"]["centre_lps_mm"].get<Vec3>();
  const Vec3 at = phantom.labels.continuous_index(centre);
  EXPECT_EQ(
      phantom.labels.at(static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                        static_cast<int>(std::lround(at[2]))),
      8);
  EXPECT_EQ(plan["operated_side"], centre[0] > 0.0 ? "L" : "R");
  EXPECT_THAT(plan["quadrant"].get<std::string>(), ::testing::HasSubstr("outer"));
  const auto axis = plan["resection"]["axis_towards_skin_lps"].get<Vec3>();
  EXPECT_NEAR(norm(axis), 1.0, 1e-3);
  EXPECT_LT(axis[1], 0.0);
  EXPECT_GT(plan["nipple_lps_mm"]["L"][0], 50.0);
  EXPECT_LT(plan["nipple_lps_mm"]["R"][0], -50.0);
}

TEST(APhantom, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const Phantom again = coarse(1), other = coarse(2);
  EXPECT_EQ(again.labels.voxels, first().labels.voxels);
  EXPECT_EQ(again.plan_json, first().plan_json);
  EXPECT_EQ(again.upright, first().upright);
  EXPECT_NE(other.plan_json, first().plan_json);
}

TEST(APhantom, OfUnknownDensityOrImpossibleSizeIsRefused) {
  EXPECT_EQ(parse_density("dense"), Density::Dense);
  EXPECT_THROW(parse_density("thick"), Error);
  Silent silent;
  EXPECT_THROW(make_phantom({.seed = 1, .volume_cm3 = 20.0}, Context("phantom", silent)), Error);
}

}  // namespace
}  // namespace sanatrix::phantom
