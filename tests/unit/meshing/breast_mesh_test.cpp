// Labels to mesh on a torso whose surfaces are known: shape, names, angles, tissue, refusals.
#include "meshing/breast_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "meshing/anatomy.hpp"
#include "meshing/domain_surface.hpp"
#include "synthetic_torso.hpp"

namespace {

using namespace sanatrix;
using meshing::BreastModel;
using meshing::MeshOptions;
using sanatrix::testing::SyntheticTorso;
using ::testing::HasSubstr;

Image3<float> gland_of(const LabelImage& labels) {
  Image3<float> fraction{.size = labels.size,
                         .spacing_mm = labels.spacing_mm,
                         .origin_mm = labels.origin_mm,
                         .direction = labels.direction,
                         .voxels = {}};
  for (const unsigned char l : labels.voxels) {
    fraction.voxels.push_back(l == 2 ? 1.0F : 0.0F);
  }
  return fraction;
}

BreastModel mesh_of(const LabelImage& labels, const SyntheticTorso& torso,
                    const MeshOptions& options) {
  Silent nobody;
  return meshing::mesh_breasts(labels, gland_of(labels), 0.0, {torso.tip(-1), torso.tip(1)},
                               options, Context("mesh", nobody));
}

meshing::Focus focus_in_left_breast() {
  return {.a = {0.062, -0.06, 0.0}, .b = {0.062, -0.03, 0.0}, .radius = 0.012};
}

/// Meshed once for all checks.
class SyntheticMesh : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    labels_ = new LabelImage(torso_.isotropic(1.5));
    model_ = new BreastModel(mesh_of(*labels_, torso_, options()));
  }
  static void TearDownTestSuite() {
    delete labels_;
    delete model_;
  }
  static MeshOptions options() {
    MeshOptions options;
    options.target_vertices = 5000;
    options.focus = focus_in_left_breast();
    return options;
  }
  static const TetMesh& mesh() { return model_->mesh; }

  static inline SyntheticTorso torso_;
  static inline const LabelImage* labels_ = nullptr;
  static inline const BreastModel* model_ = nullptr;
};

TEST_F(SyntheticMesh, meets_size_angles_and_grading) {
  EXPECT_TRUE(model_->warnings.empty());
  EXPECT_NEAR(static_cast<double>(mesh().points.size()), 5000.0, 750.0);
  const auto quality = meshing::measure_quality(*model_, focus_in_left_breast());
  EXPECT_GT(quality.min_dihedral_deg, 10.0);
  EXPECT_GT(quality.min_edge_m, 0.0005);
  EXPECT_LT(quality.mean_edge_in_focus_m, 0.003);
  EXPECT_LT(quality.max_edge_m, 0.025);
  // An 8 mm edge on a breast of 46 mm radius turns by 10 degrees; the creases where the ellipsoids
  // meet the torso turn by 60 degrees within a few edges.
  EXPECT_LT(quality.skin_roughness_deg, 25.0);
}

TEST_F(SyntheticMesh, has_one_closed_boundary_with_one_name_per_face) {
  const auto boundary = boundary_of(mesh());
  ASSERT_EQ(boundary.size(), mesh().faces.size());
  std::set<std::array<int, 3>> named;
  std::map<std::pair<int, int>, int> edges;
  for (const BoundaryFace& face : mesh().faces) {
    auto v = face.vertex;
    for (std::size_t i = 0; i < 3; ++i) {
      ++edges[{v[i], v[(i + 1) % 3]}];
    }
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    named.insert(v);
  }
  for (auto v : boundary) {
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    EXPECT_TRUE(named.contains(v));
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
  // Euler: a closed surface of one piece without handles.
  std::set<int> vertices;
  for (const BoundaryFace& face : mesh().faces) {
    vertices.insert(face.vertex.begin(), face.vertex.end());
  }
  EXPECT_EQ(vertices.size() + mesh().faces.size() - edges.size() / 2, 2U);
}

TEST_F(SyntheticMesh, skin_and_chest_lie_where_the_labels_say) {
  double sum = 0.0;
  const auto skin = vertices_on(mesh(), "skin");
  for (const int v : skin) {
    sum += std::abs(torso_.outside(1e3 * mesh().points[static_cast<std::size_t>(v)]));
  }
  EXPECT_LT(sum / static_cast<double>(skin.size()), 0.5);
  sum = 0.0;
  const auto chest = vertices_on(mesh(), "chest");
  for (const int v : chest) {
    const Vec3 p = 1e3 * mesh().points[static_cast<std::size_t>(v)];
    sum += std::abs(p[1] - torso_.chest_front(p[0]));
  }
  EXPECT_LT(sum / static_cast<double>(chest.size()), 0.7);
}

TEST_F(SyntheticMesh, clip_planes_are_flat_and_face_outwards) {
  const std::map<std::string, std::pair<std::size_t, double>> flat{{"superior", {2, 1.0}},
                                                                   {"inferior", {2, -1.0}}};
  for (const auto& [name, side] : flat) {
    const auto [axis, sign] = side;
    const auto vertices = vertices_on(mesh(), name);
    ASSERT_FALSE(vertices.empty()) << name;
    for (const int v : vertices) {
      EXPECT_EQ(mesh().points[static_cast<std::size_t>(v)][axis],
                mesh().points[static_cast<std::size_t>(vertices[0])][axis])
          << name;
    }
    for (const BoundaryFace& face : mesh().faces) {
      if (mesh().boundary_names[static_cast<std::size_t>(face.name)] == name) {
        const auto& p = mesh().points;
        const Vec3 a = p[static_cast<std::size_t>(face.vertex[0])];
        const Vec3 n = cross(p[static_cast<std::size_t>(face.vertex[1])] - a,
                             p[static_cast<std::size_t>(face.vertex[2])] - a);
        EXPECT_GT(sign * n[axis], 0.0);
      }
    }
  }
}

TEST_F(SyntheticMesh, knows_tissue_sides_and_breasts) {
  const std::vector<double> volumes = cell_volumes(mesh(), mesh().points);
  double gland = 0.0;
  double volume = 0.0;
  std::array<double, 2> breast{};
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    volume += volumes[c];
    gland += volumes[c] * model_->fibroglandular[c];
    const double x = 0.25 * (mesh().points[static_cast<std::size_t>(mesh().cells[c][0])][0] +
                             mesh().points[static_cast<std::size_t>(mesh().cells[c][1])][0] +
                             mesh().points[static_cast<std::size_t>(mesh().cells[c][2])][0] +
                             mesh().points[static_cast<std::size_t>(mesh().cells[c][3])][0]);
    EXPECT_EQ(model_->side[c], x > 0.0 ? 1 : -1);
    if (model_->in_breast[c]) {
      breast[x > 0.0 ? 1 : 0] += volumes[c];
    }
  }
  const double voxel = 1e-9 * labels_->voxel_volume_mm3();
  const double labelled =
      voxel * static_cast<double>(std::count(labels_->voxels.begin(), labels_->voxels.end(), 2));
  EXPECT_NEAR(gland, labelled, 0.02 * labelled);
  EXPECT_GT(volume, gland);
  // The free half of an ellipsoid is 299 cm3; the layer below its footprint of 66 cm2 adds 93 cm3.
  EXPECT_NEAR(1e6 * breast[0], 390.0, 50.0);
  EXPECT_NEAR(breast[0], breast[1], 0.03 * breast[1]);
  for (const int side : {0, 1}) {
    const int v = model_->nipple_vertex[static_cast<std::size_t>(side)];
    EXPECT_LT(norm(1e3 * mesh().points[static_cast<std::size_t>(v)] - torso_.tip(2 * side - 1)),
              6.0);
  }
}

TEST_F(SyntheticMesh, is_the_same_when_made_again) {
  const BreastModel again = mesh_of(*labels_, torso_, options());
  EXPECT_EQ(again.mesh.points, mesh().points);
  EXPECT_EQ(again.mesh.cells, mesh().cells);
}

class Refusal : public ::testing::Test {
 protected:
  static std::string of(const LabelImage& labels, Fault fault = Fault::Input,
                        double time_limit_s = 60.0) {
    try {
      MeshOptions options;
      options.target_vertices = 2000;
      options.time_limit_s = time_limit_s;
      mesh_of(labels, SyntheticTorso{}, options);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), fault);
      EXPECT_FALSE(e.hint().empty());
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(Refusal, names_the_cause) {
  const SyntheticTorso torso;
  const LabelImage good = torso.isotropic(2.0);
  LabelImage no_wall = good;
  for (unsigned char& l : no_wall.voxels) {
    l = is_wall(l) ? 0 : l;
  }
  EXPECT_THAT(of(no_wall), HasSubstr("no chest wall"));

  SyntheticTorso one = torso;
  one.left_breast = false;
  EXPECT_THAT(of(one.isotropic(2.0)), HasSubstr("no breast on the patient's left"));

  EXPECT_THAT(of(good, Fault::Resource, 0.01), HasSubstr("longer than 0.01 s"));
}

TEST(Deadline, stops_the_search_for_a_surface_that_can_be_meshed) {
  const SyntheticTorso torso;
  Silent nobody;
  const std::array<Vec3, 2> nipples{torso.tip(-1), torso.tip(1)};
  const meshing::Anatomy anatomy = meshing::find_anatomy(
      torso.isotropic(2.0), {.midline_x_mm = 0.0, .nipple_mm = nipples}, Context("mesh", nobody));
  try {
    meshing::extract_domain(anatomy, nipples, meshing::Deadline(0.0));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Resource);
    EXPECT_THAT(e.hint(), HasSubstr("mesh.time_limit_s"));
  }
}

}  // namespace
