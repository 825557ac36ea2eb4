// Labels of real and generated patients to mesh, without a setting that depends on the patient.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "geometry/image_filters.hpp"
#include "imaging/segmentation.hpp"
#include "meshing/breast_mesh.hpp"
#include "shared_data.hpp"

namespace {

using namespace sanatrix;
using imaging::LabelPreset;

struct Patient {
  const char* file;
  LabelPreset preset;
};

/// Labels that are tissue or hidden behind it, and the soft part of it in front of the chest wall.
struct LabelledBody {
  Mask body;
  double soft_cm3;  ///< between the two corners
};

LabelledBody labelled_body(const LabelImage& labels, const Vec3& low_mm, const Vec3& high_mm) {
  Mask wall = image_like<unsigned char>(labels);
  for (std::size_t v = 0; v < wall.voxels.size(); ++v) {
    wall.voxels[v] = is_wall(labels.voxels[v]) ? 1 : 0;
  }
  const Parts parts = connected_parts(wall);
  LabelledBody result{image_like<unsigned char>(labels), 0.0};
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = 0; i < labels.size[0]; ++i) {
      bool behind = false;
      for (int j = 0; j < labels.size[1]; ++j) {
        const std::size_t voxel = labels.index(i, j, k);
        behind = behind || parts.part[voxel] == 0;
        result.body.voxels[voxel] = labels.voxels[voxel] != 0 ? 1 : 0;
        if (behind || labels.voxels[voxel] == 0) {
          continue;
        }
        const Vec3 p = labels.position_mm(i, j, k);
        double part = 1.0;  // of the voxel inside the corners
        for (std::size_t a = 0; a < 3; ++a) {
          part *= std::clamp((p[a] - low_mm[a]) / labels.spacing_mm[a] + 0.5, 0.0, 1.0) *
                  std::clamp((high_mm[a] - p[a]) / labels.spacing_mm[a] + 0.5, 0.0, 1.0);
        }
        result.soft_cm3 += part * labels.voxel_volume_mm3() * 1e-3;
      }
    }
  }
  return result;
}

class PatientMesh : public ::testing::TestWithParam<Patient> {};

TEST_P(PatientMesh, is_sound_and_keeps_volume_and_skin) {
  SANATRIX_REQUIRE_SHARED(GetParam().file);
  Silent nobody;
  const Context ctx("mesh", nobody);
  const auto segmentation = imaging::segment_given_labels(shared_file, GetParam().preset, 1.5, ctx);
  const auto& nipple = segmentation.nipple_mm;
  const Vec3 tumour = 1e-3 * (nipple[1] + Vec3{10, 45, 15});
  const meshing::Focus focus{.a = tumour, .b = tumour + Vec3{0, 0.02, 0}, .radius = 0.016};
  meshing::MeshOptions options;
  options.focus = focus;
  const meshing::BreastModel model =
      meshing::mesh_breasts(segmentation.labels, segmentation.fibroglandular,
                            segmentation.midline_x_mm, nipple, options, ctx);
  const TetMesh& mesh = model.mesh;

  EXPECT_NEAR(static_cast<double>(mesh.points.size()), 10000.0, 1500.0);
  const auto quality = meshing::measure_quality(model, focus);
  EXPECT_GT(quality.min_dihedral_deg, 10.0);
  EXPECT_LT(quality.mean_edge_in_focus_m, 0.0031);
  // Edges of 8 mm on breasts of 45 mm radius turn by 10 degrees, more at folds and nipples.
  EXPECT_LT(quality.skin_roughness_deg, 22.0);

  ASSERT_EQ(boundary_of(mesh).size(), mesh.faces.size());
  std::set<std::pair<int, int>> edges;
  for (const BoundaryFace& face : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_TRUE(edges.insert({face.vertex[i], face.vertex[(i + 1) % 3]}).second);
    }
  }

  Vec3 low{1e9, 1e9, 1e9};
  Vec3 high{-1e9, -1e9, -1e9};
  for (const Vec3& p : mesh.points) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], 1e3 * p[a]);
      high[a] = std::max(high[a], 1e3 * p[a]);
    }
  }
  const LabelledBody labelled = labelled_body(segmentation.labels, low, high);
  const std::vector<double> volumes = cell_volumes(mesh, mesh.points);
  const double meshed_cm3 = 1e6 * std::accumulate(volumes.begin(), volumes.end(), 0.0);
  EXPECT_NEAR(meshed_cm3, labelled.soft_cm3, 0.02 * labelled.soft_cm3);

  const Image3<float> outside = signed_distance(labelled.body, {true, true, true}, 10.0);
  const std::vector<int> skin = vertices_on(mesh, "skin");
  double sum = 0.0;
  for (const int v : skin) {
    sum += std::abs(sample(outside, 1e3 * mesh.points[static_cast<std::size_t>(v)]));
  }
  EXPECT_LT(sum / static_cast<double>(skin.size()), 0.7);

  std::array<double, 2> breast_cm3{};
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    breast_cm3[model.side[c] > 0 ? 1 : 0] += model.in_breast[c] ? 1e6 * volumes[c] : 0.0;
  }
  EXPECT_GT(std::min(breast_cm3[0], breast_cm3[1]), 300.0);
  EXPECT_LT(std::max(breast_cm3[0], breast_cm3[1]), 1500.0);
  EXPECT_LT(std::max(breast_cm3[0], breast_cm3[1]) / std::min(breast_cm3[0], breast_cm3[1]), 1.3);
  for (const std::size_t side : {0, 1}) {
    const Vec3& p = mesh.points[static_cast<std::size_t>(model.nipple_vertex[side])];
    EXPECT_LT(norm(1e3 * p - nipple[side]), 7.0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shared, PatientMesh,
    ::testing::Values(
        Patient{"data/dev01/labels_mri.nii.gz", LabelPreset::Sanatrix},
        Patient{"data/dev02/labels_mri.nrrd", LabelPreset::Sanatrix},
        Patient{"data/real_prone_labels/Exam_06_detailed.nii.gz", LabelPreset::Pelicano},
        Patient{"data/real_prone_labels/Exam_15_detailed.nii.gz", LabelPreset::Pelicano},
        Patient{"data/real_prone_labels/Exam_25_detailed.nii.gz", LabelPreset::Pelicano}));

}  // namespace
