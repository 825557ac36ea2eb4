#include "phantom/scar.hpp"

#include "healing/model.hpp"
#include "recovery/recovery.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::phantom {

Scar scar_of(const std::string& plan_json, const TetMesh& body, std::span<const Vec3> prone,
             std::span<const mechanics::Tissue> healthy, const Context& ctx) {
  const surgery::Plan plan = surgery::read_plan(plan_json, "plan.json");
  constexpr double midline_x_m = 0.0;  // the phantom is designed about it
  const surgery::Wound wound = surgery::resect(plan, body, prone, midline_x_m, ctx);
  const std::vector<double> full(body.cells.size(), 1.0);  // eta/eta0 in the end
  const auto model = healing::make_model("vavourakis2016");
  return {recovery::healing_tissue(healthy, wound.fraction, full, model->mechanics()),
          wound.excised_m3};
}

}  // namespace sanatrix::phantom
