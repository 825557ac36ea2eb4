#include "outcome/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "geometry/geodesic.hpp"
#include "outcome/metric_table.hpp"
#include "outcome/scan_comparison.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

constexpr double mm = 1e3, cm2 = 1e4, cm3 = 1e6;
constexpr double landmark_sd_m = 0.0025;  // 2-3 mm between raters
constexpr int draws = 300;

using Values = std::map<std::string, double>;

double flat_distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a[0] - b[0], a[2] - b[2]);
}
double ratio(double a, double b) {
  return std::max(a, b) > 0 ? std::min(a, b) / std::max(a, b) : 1.0;
}

/// What the frontal photograph and the landmarks give; cheap, so that draws can repeat it.
struct Marks {
  std::array<Vec3, 2> nipple, fold, lowest, lateral;  ///< body frame, x away from the middle
};

Marks marks_of(const Torso& torso, const BodyFrame& frame, const std::array<Outline, 2>& outlines) {
  Marks m{};
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1.0 : 1.0;
    const auto put = [&](const Vec3& p) {
      Vec3 q = frame(p);
      q[0] *= sign;
      return q;
    };
    m.nipple[side] = put(torso.nipple[side]);
    m.fold[side] = put(torso.fold[side]);
    m.lowest[side] = outlines[side].lowest;
    m.lateral[side] = outlines[side].lateral;
  }
  return m;
}

void add_landmark_indices(const Marks& m, std::size_t treated, Values& v) {
  const std::size_t other = 1 - treated;
  const Vec3 &r = m.nipple[0], &l = m.nipple[1];
  // Pezner et al. 1985: breast retraction assessment, and its forms relative to the notch-nipple
  // distance of the untreated side (Van Limbergen et al. 1989; in 3-D Kawale et al. 2011).
  v["bra_mm"] = mm * std::hypot(l[0] - r[0], l[2] - r[2]);
  const double flat_reference = std::hypot(m.nipple[other][0], m.nipple[other][2]);
  v["pbra_pct"] = 100 * v["bra_mm"] / (mm * flat_reference);
  v["pbra3d_pct"] = 100 * norm(l - r) / norm(m.nipple[other]);
  v["unr_mm"] = mm * (m.nipple[treated][2] - m.nipple[other][2]);
  v["lbc_mm"] = mm * std::abs(m.lowest[0][2] - m.lowest[1][2]);
  v["bce_mm"] = mm * std::abs(flat_distance(l, m.lowest[1]) - flat_distance(r, m.lowest[0]));
  const double notch_nipple = 0.5 * (std::hypot(r[0], r[2]) + std::hypot(l[0], l[2]));
  v["plbc_pct"] = 100 * v["lbc_mm"] / (mm * notch_nipple);
  v["pbce_pct"] = 100 * v["bce_mm"] / (mm * notch_nipple);
  v["notch_nipple_pct"] = 100 * std::abs(norm(l) - norm(r)) / std::max(norm(l), norm(r));
  const double across = std::abs(l[0] + r[0]);  // both count from the middle
  v["m1"] = std::clamp(1 - std::abs(l[2] - r[2]) / std::max(across, 1e-9), 0.0, 1.0);
  v["m2"] = ratio(std::abs(l[2] - m.lowest[1][2]), std::abs(r[2] - m.lowest[0][2]));
  v["m3"] = ratio(std::abs(l[0]), std::abs(r[0]));
  v["m4"] = ratio(std::abs(m.lateral[1][0] - l[0]), std::abs(m.lateral[0][0] - r[0]));
  v["m5"] = ratio(std::abs(m.lowest[1][2]), std::abs(m.lowest[0][2]));
  v["m6"] = ratio(std::abs(m.lateral[1][0]), std::abs(m.lateral[0][0]));
  for (const auto& [side, name] : {std::pair{treated, "treated"}, {other, "other"}}) {
    v[std::string("nipple_above_fold_") + name + "_mm"] =
        mm * (m.nipple[side][2] - m.fold[side][2]);
    v[std::string("nipple_above_lowest_") + name + "_mm"] =
        mm * (m.nipple[side][2] - m.lowest[side][2]);
    v[std::string("notch_nipple_") + name + "_mm"] = mm * norm(m.nipple[side]);
    v[std::string("nipple_fold_") + name + "_mm"] = mm * norm(m.fold[side] - m.nipple[side]);
  }
  v["nipple_nipple_mm"] = mm * norm(Vec3{l[0] + r[0], l[1] - r[1], l[2] - r[2]});
}

/// What a tape along the skin shows; left out where the skin has no way between the marks.
void add_lengths_along_skin(const Torso& torso, std::size_t treated, Values& v) {
  const auto add = [&](const std::string& key, double length_m) {
    if (std::isfinite(length_m)) {
      v[key] = mm * length_m;
    }
  };
  // A model may end below the notch; then a tape has no skin to lie on.
  constexpr double on_skin_m = 0.01;
  const bool reaches = SurfaceTree(torso.skin).closest(torso.notch).distance < on_skin_m;
  const std::vector<double> notch =
      reaches ? lengths_along(torso.skin, torso.notch, torso.nipple)
              : std::vector<double>(2, std::numeric_limits<double>::quiet_NaN());
  for (const auto& [side, name] : {std::pair{treated, "treated"}, {1 - treated, "other"}}) {
    add(fmt::format("notch_nipple_{}_skin_mm", name), notch[side]);
    add(fmt::format("nipple_fold_{}_skin_mm", name),
        lengths_along(torso.skin, torso.nipple[side], std::span(&torso.fold[side], 1)).front());
  }
}

/// Landmarks are material points: a misplaced one is misplaced in both poses alike.
std::vector<Marks> misplaced(const Marks& marks, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto normal = [&] {  // Box-Muller: the same numbers with every standard library
    const double u = (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
    const double w = static_cast<double>(random() >> 11) * 0x1p-53;
    return landmark_sd_m * std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * w);
  };
  std::vector<Marks> all;
  for (int i = 0; i < draws; ++i) {
    Marks m = marks;
    const Vec3 notch{normal(), normal(), normal()};
    for (auto* group : {&m.nipple, &m.fold, &m.lowest, &m.lateral}) {
      for (std::size_t side = 0; side < 2; ++side) {
        Vec3& p = (*group)[side];
        const Vec3 shift{normal(), normal(), normal()};
        p += shift;
        p[0] -= side == 0 ? -notch[0] : notch[0];
        p[1] -= notch[1];
        p[2] -= notch[2];
      }
    }
    all.push_back(m);
  }
  return all;
}

std::array<Outline, 2> outlines_of(const Torso& torso, const BodyFrame& frame) {
  return {outline(torso, frame, 0), outline(torso, frame, 1)};
}

using Draws = std::map<std::string, std::vector<double>>;

Draws draw(const Torso& torso, const BodyFrame& frame, std::size_t treated) {
  Draws values;
  for (const Marks& m : misplaced(marks_of(torso, frame, outlines_of(torso, frame)), 1)) {
    Values v;
    add_landmark_indices(m, treated, v);
    for (const auto& [key, value] : v) {
      values[key].push_back(value);
    }
  }
  return values;
}

Range range_of(std::vector<double> values) {
  double mean = 0, squares = 0;
  for (const double value : values) {
    mean += value / static_cast<double>(values.size());
  }
  for (const double value : values) {
    squares += (value - mean) * (value - mean) / static_cast<double>(values.size());
  }
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  return {std::sqrt(squares), at(0.05), at(0.95)};
}

/// Mean of the vertex normals around the nipple, weighted by area.
Vec3 direction_of_nipple(const TriMesh& skin, const std::vector<std::size_t>& around) {
  const std::vector<Vec3> normals = vertex_normals(skin);
  const std::vector<double> areas = vertex_areas(skin);
  Vec3 sum{};
  for (const std::size_t v : around) {
    sum += areas[v] * normals[v];
  }
  return normalised(sum);
}

/// Inward displacement of the treated breast's skin along its normals before surgery.
void add_changes(const Question& q, const BodyFrame& frame, Values& v) {
  const TriMesh &before = q.before.skin, &after = q.after.skin;
  const int side = q.treated == 0 ? -1 : 1;
  const std::vector<Vec3> normals = vertex_normals(before);
  std::vector<double> inward;
  std::vector<bool> chosen;
  std::vector<std::size_t> around;
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    inward.push_back(-dot(normals[i], after.points[i] - before.points[i]));
    chosen.push_back(q.before.breast[i] == side);
    if (norm(before.points[i] - q.before.nipple[q.treated]) < 0.012) {
      around.push_back(i);
    }
  }
  const Retraction dent = retraction(before, inward, chosen);
  v["retraction_mm"] = mm * dent.depth_m;
  v["retraction_p95_mm"] = mm * dent.p95_m;
  v["retraction_area3_cm2"] = cm2 * dent.area_3mm_m2;
  v["retraction_area5_cm2"] = cm2 * dent.area_5mm_m2;
  const Vec3 moved = frame(q.after.nipple[q.treated]) - frame(q.before.nipple[q.treated]);
  v["nipple_moved_mm"] = mm * norm(moved);
  v["nipple_lateral_mm"] = mm * side * moved[0];
  v["nipple_forward_mm"] = mm * moved[1];
  v["nipple_up_mm"] = mm * moved[2];
  if (!around.empty()) {
    const double cosine =
        dot(direction_of_nipple(before, around), direction_of_nipple(after, around));
    v["nipple_turned_deg"] = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
  }
}

/// How deep the treated breast lies below the mirrored other one.
double below_mirrored(const Torso& torso, const BodyFrame& frame, std::size_t treated) {
  TriMesh mirrored = torso.skin;
  for (Vec3& p : mirrored.points) {
    p = frame.mirror(p);
  }
  for (auto& t : mirrored.triangles) {
    std::swap(t[1], t[2]);
  }
  const int other = treated == 0 ? 1 : -1;
  std::vector<double> inward = signed_distances(mirrored, torso.skin);
  std::vector<bool> chosen;
  for (std::size_t v = 0; v < inward.size(); ++v) {
    inward[v] = -inward[v];
    chosen.push_back(torso.breast[v] == other);
  }
  return mm * retraction(mirrored, inward, chosen).depth_m;
}

std::optional<double> value_of(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::map<std::string, double> shape_indices(const Torso& torso, const BodyFrame& frame,
                                            std::size_t treated) {
  const std::array<Outline, 2> outlines = outlines_of(torso, frame);
  Values v;
  add_landmark_indices(marks_of(torso, frame, outlines), treated, v);
  add_lengths_along_skin(torso, treated, v);
  const Outline &r = outlines[0], &l = outlines[1];
  v["bcd_mm"] = mm * std::abs(l.length_m - r.length_m);
  v["pbcd_pct"] = 100 * v["bcd_mm"] / (mm * 0.5 * (l.length_m + r.length_m));
  const double mean_area = 0.5 * (l.area_m2 + r.area_m2);
  v["bad_cm2"] = cm2 * std::abs(l.area_m2 - r.area_m2);
  v["pbad_pct"] = 100 * v["bad_cm2"] / (cm2 * mean_area);
  v["bod_cm2"] = cm2 * overlap_difference(torso, frame);
  v["pbod_pct"] = 100 * v["bod_cm2"] / (cm2 * mean_area);
  v["rms_asymmetry_mm"] = mm * rms_asymmetry(torso, frame);
  v["below_mirrored_mm"] = below_mirrored(torso, frame, treated);
  const double vr = torso.volume_m3[0], vl = torso.volume_m3[1];
  v["volume_treated_cm3"] = cm3 * torso.volume_m3[treated];
  v["volume_symmetry_pct"] = 100 * ratio(vl, vr);
  v["volume_asymmetry_pct"] = 100 * std::abs(vl - vr) / std::min(vl, vr);
  v["upper_pole_pct"] = 100 * torso.upper_share[treated];
  return v;
}

std::map<std::string, double> landmark_indices(const Torso& torso, const BodyFrame& frame,
                                               std::size_t treated) {
  Values v;
  add_landmark_indices(marks_of(torso, frame, outlines_of(torso, frame)), treated, v);
  return v;
}

std::vector<Metric> cosmetic_metrics(const Question& q, const BodyFrame& frame) {
  auto meanwhile =
      std::async(std::launch::async, [&] { return shape_indices(q.after, frame, q.treated); });
  const Values before = shape_indices(q.before, frame, q.treated);
  const Values after = meanwhile.get();
  Values changes{{"excised_pct", q.excised_percent}};
  add_changes(q, frame, changes);
  const Draws draws_before = draw(q.before, frame, q.treated);
  const Draws draws_after = draw(q.after, frame, q.treated);
  std::vector<Metric> metrics;
  for (const Definition& d : definitions) {
    Metric m{.key = d.key,
             .name = d.name,
             .unit = d.unit,
             .group = d.group,
             .before = value_of(before, d.key),
             .after = value_of(after, d.key),
             .change = value_of(changes, d.key),
             .before_range = {},
             .after_range = {},
             .noise_floor = d.floor,
             .noise_source = d.floor_source,
             .is_noise = false,
             .reference = d.reference,
             .source = d.source};
    if (m.before && m.after) {
      m.change = *m.after - *m.before;
    }
    if (const auto drawn = draws_before.find(d.key); drawn != draws_before.end()) {
      m.before_range = range_of(drawn->second);
      m.after_range = range_of(draws_after.at(d.key));
      std::vector<double> differences;
      for (std::size_t i = 0; i < drawn->second.size(); ++i) {
        differences.push_back(draws_after.at(d.key)[i] - drawn->second[i]);
      }
      m.noise_floor = std::max(m.noise_floor, 2 * range_of(std::move(differences)).sd);
    }
    m.is_noise = m.change && std::abs(*m.change) < m.noise_floor;
    if (!q.notch_known && (m.key.starts_with("notch") ||
                           ((m.key.starts_with("p") || m.key == "m5") && m.before_range))) {
      m.source += "; the sternal notch is not known: lengths count from the model's upper end";
    }
    if (q.notch_known && m.key.starts_with("notch") && m.key.ends_with("_skin_mm") && !m.before) {
      m.source += "; not given: the model ends below the notch";
    }
    if (!q.folds_known && m.key.find("_fold") != std::string::npos) {
      m.source += "; the fold is not in the model: its lower end stands for it";
    }
    metrics.push_back(std::move(m));
  }
  return metrics;
}

double chance_of_bra_above(const Question& q, const BodyFrame& frame, double limit_mm) {
  const std::vector<double> values = draw(q.after, frame, q.treated).at("bra_mm");
  return static_cast<double>(
             std::ranges::count_if(values, [&](double bra) { return bra > limit_mm; })) /
         static_cast<double>(values.size());
}

std::map<std::string, double> chances_of_ptosis(const Torso& torso, const BodyFrame& frame,
                                                std::size_t treated) {
  const Draws drawn = draw(torso, frame, treated);
  const std::vector<double>& fold = drawn.at("nipple_above_fold_treated_mm");
  const std::vector<double>& lowest = drawn.at("nipple_above_lowest_treated_mm");
  std::map<std::string, double> chance;
  for (std::size_t i = 0; i < fold.size(); ++i) {
    chance[ptosis_grade(fold[i], lowest[i])] += 1.0 / static_cast<double>(fold.size());
  }
  return chance;
}

std::string ptosis_grade(double nipple_above_fold_mm, double nipple_above_lowest_mm) {
  constexpr double at_level = 10.0, far_below = 30.0, at_bottom = 10.0;
  if (nipple_above_fold_mm > 0) {
    return nipple_above_lowest_mm > nipple_above_fold_mm + at_level ? "pseudoptosis" : "none";
  }
  if (nipple_above_fold_mm > -at_level) {
    return "I";
  }
  return nipple_above_fold_mm > -far_below && nipple_above_lowest_mm > at_bottom ? "II" : "III";
}

}  // namespace sanatrix::outcome
