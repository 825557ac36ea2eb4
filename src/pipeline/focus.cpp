#include "pipeline/focus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace sanatrix::pipeline {
namespace {

constexpr double reach_out = 0.010;    // [m] beyond the fine zone where the mesh is still graded
constexpr double longest_axis = 0.15;  // [m] search for skin and chest wall along the axis
constexpr double half_length = 0.05;   // [m] of a typical resection: lever arm of a tilted axis

double planned_radius(const surgery::Plan& plan) {
  return plan.radius.value_or(plan.tumour_radius + plan.margin);
}

bool fits(const FocusRule& rule, const surgery::Plan& plan) {
  if (plan.frame == surgery::Frame::Supine || !rule.centre) {
    return plan.frame == surgery::Frame::Supine && !rule.centre && rule.side == plan.side &&
           planned_radius(plan) <= rule.radius + reach_out;
  }
  if (rule.axis.has_value() != plan.axis.has_value()) {
    return false;
  }
  Vec3 offset = plan.tumour_centre - *rule.centre;
  double tilt = 0.0;
  if (rule.axis) {
    const Vec3 axis = normalised(*rule.axis);
    offset = offset - dot(offset, axis) * axis;
    const double cosine = dot(axis, normalised(*plan.axis));
    tilt = cosine > 0 ? half_length * std::sqrt(std::max(0.0, 1 - cosine * cosine)) : longest_axis;
  }
  return norm(offset) + tilt + planned_radius(plan) <= rule.radius + reach_out;
}

unsigned char label_at(const LabelImage& labels, const Vec3& p_mm) {
  const Vec3 c = labels.continuous_index(p_mm);
  std::array<int, 3> voxel{};
  for (std::size_t k = 0; k < 3; ++k) {
    voxel[k] = static_cast<int>(std::lround(c[k]));
    if (voxel[k] < 0 || voxel[k] >= labels.size[k]) {
      return static_cast<unsigned char>(Label::Air);
    }
  }
  return labels.at(voxel[0], voxel[1], voxel[2]);
}

template <class F>
void for_each_voxel(const LabelImage& labels, int stride, F&& visit) {
  for (int k = 0; k < labels.size[2]; k += stride) {
    for (int j = 0; j < labels.size[1]; j += stride) {
      for (int i = 0; i < labels.size[0]; i += stride) {
        visit(labels.at(i, j, k), labels.position_mm(i, j, k));
      }
    }
  }
}

std::optional<Vec3> labelled_tumour_mm(const LabelImage& labels, surgery::Side side,
                                       double midline_x_mm) {
  Vec3 sum{};
  int count = 0;
  for_each_voxel(labels, 1, [&](unsigned char label, const Vec3& p) {
    if (label == static_cast<unsigned char>(Label::Tumour) &&
        (p[0] > midline_x_mm) == (side == surgery::Side::Left)) {
      sum += p;
      ++count;
    }
  });
  return count > 0 ? std::optional((1.0 / count) * sum) : std::nullopt;
}

/// Direction from the nearest chest wall to p; the wall's normal there.
Vec3 away_from_wall(const LabelImage& labels, const Vec3& p_mm) {
  double nearest = std::numeric_limits<double>::max();
  Vec3 direction{0, -1, 0};
  for_each_voxel(labels, 2, [&](unsigned char label, const Vec3& q) {
    const double d = norm(p_mm - q);
    if (is_wall(label) && d > 0 && d < nearest) {
      nearest = d;
      direction = normalised(p_mm - q);
    }
  });
  return direction;
}

/// Last point before `stop` is met on the way from p along the direction.
template <class F>
Vec3 march(const LabelImage& labels, const Vec3& p_mm, const Vec3& direction, F&& stop) {
  Vec3 p = p_mm;
  for (double s = 0.0; s < longest_axis * 1e3; s += 1.0) {
    const Vec3 next = p_mm + s * direction;
    if (stop(label_at(labels, next))) {
      break;
    }
    p = next;
  }
  return p;
}

const char* name_of(surgery::Side side) {
  return side == surgery::Side::Left ? "LEFT" : "RIGHT";
}

/// Plan, tumour and image must speak of one breast.
void check_side(const FocusRule& rule, const LabelImage& labels, double midline_x_mm) {
  const auto other = rule.side == surgery::Side::Left ? surgery::Side::Right : surgery::Side::Left;
  constexpr const char* action = "check side and frame of the plan, and the patient's orientation";
  if (rule.centre) {
    const double x = 1e3 * (*rule.centre)[0];
    if ((x > midline_x_mm) != (rule.side == surgery::Side::Left)) {
      throw Error(Fault::Input,
                  fmt::format("the plan operates on the {} breast, but its tumour at x = {:.0f} mm "
                              "lies in the {} half of the image (midline at x = {:.0f} mm)",
                              name_of(rule.side), x, name_of(other), midline_x_mm),
                  action);
    }
  }
  if (!labelled_tumour_mm(labels, rule.side, midline_x_mm) &&
      labelled_tumour_mm(labels, other, midline_x_mm)) {
    throw Error(Fault::Input,
                fmt::format("the plan operates on the {} breast, but the only tumour that is "
                            "segmented lies in the {} one",
                            name_of(rule.side), name_of(other)),
                action);
  }
}

}  // namespace

FocusRule follow(const std::optional<FocusRule>& old, const surgery::Plan& plan) {
  if (old && fits(*old, plan)) {
    return *old;
  }
  // The fine zone ends 1..6 mm outside the resection, on a multiple of 5 mm.
  const double radius = 0.005 * std::ceil((planned_radius(plan) + 0.001) / 0.005);
  FocusRule rule{.centre = {}, .axis = {}, .side = plan.side, .radius = radius};
  if (plan.frame != surgery::Frame::Supine) {
    rule.centre = plan.tumour_centre;
    rule.axis = plan.axis;
  }
  return rule;
}

std::optional<meshing::Focus> place(const FocusRule& rule, const LabelImage& labels,
                                    double midline_x_mm) {
  check_side(rule, labels, midline_x_mm);
  const std::optional<Vec3> centre = rule.centre
                                         ? std::optional(1e3 * *rule.centre)
                                         : labelled_tumour_mm(labels, rule.side, midline_x_mm);
  if (!centre) {
    return std::nullopt;
  }
  const Vec3 axis = rule.axis ? normalised(*rule.axis) : away_from_wall(labels, *centre);
  const Vec3 chest = march(labels, *centre, -1.0 * axis, is_wall);
  const Vec3 skin = march(labels, *centre, axis, [](unsigned char label) {
    return label == static_cast<unsigned char>(Label::Air);
  });
  return meshing::Focus{1e-3 * chest, 1e-3 * skin, rule.radius};
}

}  // namespace sanatrix::pipeline
