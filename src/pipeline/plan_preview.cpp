#include "pipeline/plan_preview.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "pipeline/body.hpp"
#include "pipeline/level_set.hpp"
#include "surgery/incision.hpp"

namespace sanatrix::pipeline {
namespace {

constexpr double mm = 1e-3;

double excised_mass_g(const surgery::Wound& wound, const meshing::BreastModel& model,
                      std::span<const Vec3> points, const mechanics::TissuePreset& tissue) {
  double kg = 0.0;
  for (std::size_t c = 0; c < wound.fraction.size(); ++c) {
    if (wound.fraction[c] > 0.0) {
      const auto& [i, j, k, l] = model.mesh.cells[c];
      const double gland = model.fibroglandular[c];
      const double density =
          gland * tissue.fibroglandular.density + (1.0 - gland) * tissue.adipose.density;
      kg += wound.fraction[c] * density * volume(points[i], points[j], points[k], points[l]);
    }
  }
  return 1e3 * kg;
}

surgery::Place place_as_imaged(const surgery::Plan& plan, const CaseView& view) {
  const Vec3 centre =
      view.carry(std::array<Vec3, 1>{plan.tumour_centre}, pose_of(plan.frame), "prone")[0];
  const int nipple = view.model().nipple_vertex[plan.side == surgery::Side::Left ? 1 : 0];
  return surgery::place_of(centre, view.pose("prone")[static_cast<std::size_t>(nipple)], plan.side);
}

}  // namespace

std::vector<Vec3> usual_incision(const std::string& kind, const surgery::Plan& plan,
                                 const CaseView& view) {
  constexpr double areola_radius = 20.0 * mm, fold_width = 60.0 * mm;
  const meshing::BreastModel& model = view.model();
  const std::vector<Vec3>& points = view.pose(pose_of(plan.frame));
  const bool left = plan.side == surgery::Side::Left;
  const Vec3 nipple = points[static_cast<std::size_t>(model.nipple_vertex[left ? 1 : 0])];
  const surgery::Resection resection(plan, view.anatomy(pose_of(plan.frame)),
                                     surgery::Detail::Live);
  const Vec3 entry = resection.skin_point();
  if (kind == "circumareolar") {
    return surgery::circumareolar_incision(nipple, entry, areola_radius);
  }
  if (kind == "radial") {
    return surgery::radial_incision(nipple, entry, areola_radius);
  }
  require(kind == "inframammary", "there is no incision \"{}\"", kind);
  std::vector<bool> of_breast(points.size(), false);
  for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
    if (model.in_breast[c] && (model.side[c] > 0) == left) {
      for (const int v : model.mesh.cells[c]) {
        of_breast[static_cast<std::size_t>(v)] = true;
      }
    }
  }
  std::vector<Vec3> skin;
  for (const int v : vertices_on(model.mesh, "skin")) {
    if (of_breast[static_cast<std::size_t>(v)]) {
      skin.push_back(points[static_cast<std::size_t>(v)]);
    }
  }
  return surgery::inframammary_incision(skin, entry, fold_width);
}

PlanPreview preview(const surgery::Plan& plan, const CaseView& view, const Parameters& parameters,
                    surgery::Detail detail) {
  const meshing::BreastModel& model = view.model();
  const std::vector<Vec3>& points = view.pose(pose_of(plan.frame));
  Silent silent;
  PlanPreview answer;
  answer.wound =
      surgery::resect(plan, view.anatomy(pose_of(plan.frame)), Context("preview", silent), detail);
  answer.excised_g = excised_mass_g(answer.wound, model, points, tissue_values(parameters));
  answer.breast_cm3 = view.breast_cm3()[plan.side == surgery::Side::Left ? 1 : 0];
  answer.place = place_as_imaged(plan, view);
  answer.surface =
      level_set(model.mesh, points, to_vertices(model.mesh, points, answer.wound.fraction), 0.5);
  for (const std::vector<int>& line : answer.wound.incision_vertices) {
    answer.incisions.emplace_back();
    for (const int vertex : line) {
      answer.incisions.back().push_back(points[static_cast<std::size_t>(vertex)]);
    }
  }
  return answer;
}

}  // namespace sanatrix::pipeline
