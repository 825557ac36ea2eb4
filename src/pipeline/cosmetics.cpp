#include "pipeline/cosmetics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "outcome/scan_target.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;

struct FoldPlace {
  std::array<int, 2> vertex;  ///< of the skin
  bool known = true;
};

/// The lowest place where the skin leaves the breast below the nipple, found in prone, where the
/// fold is open. Where the model ends before the breast does, its end stands for the fold.
FoldPlace find_folds(const CaseResult& r, const Skin& skin) {
  const std::vector<bool> end = outcome::border_vertices(skin.before.mesh);
  std::vector<bool> leaves(skin.breast.size(), false);
  for (const auto& t : skin.before.mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
      leaves[a] = leaves[a] || skin.breast[a] != skin.breast[b];
      leaves[b] = leaves[b] || skin.breast[a] != skin.breast[b];
    }
  }
  FoldPlace fold{{0, 0}, true};
  for (std::size_t side = 0; side < 2; ++side) {
    const int wanted = side == 0 ? -1 : 1;
    const Vec3& nipple = r.model.mesh.points[static_cast<std::size_t>(r.model.nipple_vertex[side])];
    double best = 1e300;
    for (std::size_t v = 0; v < skin.breast.size(); ++v) {
      const Vec3& p = r.model.mesh.points[static_cast<std::size_t>(skin.before.vertex[v])];
      const double aside = std::abs(p[0] - nipple[0]);
      const bool candidate = skin.breast[v] == wanted && (leaves[v] || end[v]) && aside < 0.03;
      // Straight below the nipple if possible: a centimetre aside weighs like a centimetre up.
      if (candidate && p[2] < nipple[2] && p[2] + aside < best) {
        best = p[2] + aside;
        fold.vertex[side] = static_cast<int>(v);
      }
    }
    fold.known = fold.known && best < 1e299 && !end[static_cast<std::size_t>(fold.vertex[side])];
  }
  return fold;
}

/// The upper end of the skin at the middle, for patients whose sternal notch is not known.
Vec3 upper_middle(const CaseResult& r, const Skin& skin) {
  Vec3 best{0, 0, -1e300};
  double highest = -1e300;
  for (const Vec3& p : skin.before.mesh.points) {
    const double value = p[2] - std::abs(p[0] - r.model.midline_x_m);
    if (value > highest) {
      highest = value;
      best = p;
    }
  }
  best[0] = r.model.midline_x_m;
  return best;
}

outcome::Torso torso_of(const CaseResult& r, const Skin& skin, const TriMesh& surface,
                        std::span<const Vec3> pose, const Vec3& notch, const FoldPlace& fold) {
  outcome::Torso torso;
  torso.skin = surface;
  torso.breast = skin.breast;
  torso.notch = notch;
  for (std::size_t side = 0; side < 2; ++side) {
    torso.nipple[side] = pose[static_cast<std::size_t>(r.model.nipple_vertex[side])];
    torso.fold[side] = surface.points[static_cast<std::size_t>(fold.vertex[side])];
  }
  const std::vector<double> volumes = cell_volumes(r.model.mesh, pose);
  std::array<double, 2> above{};
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    if (r.model.in_breast[c]) {
      const std::size_t side = r.model.side[c] < 0 ? 0 : 1;
      double z = 0;
      for (const int vertex : r.model.mesh.cells[c]) {
        z += 0.25 * pose[static_cast<std::size_t>(vertex)][2];
      }
      torso.volume_m3[side] += volumes[c];
      above[side] += z > torso.nipple[side][2] ? volumes[c] : 0.0;
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    torso.upper_share[side] = above[side] / torso.volume_m3[side];
  }
  return torso;
}

/// Published and assumed ends of what a wound may do in three months: the paper's 8 % halved, and
/// the cavities of Kader et al. 2008 (V/V0 = 0.341 at 80.5 d and 0.146 at 135 d: 0.29 at 90 d).
std::vector<Contraction> contractions_of(double volume_ratio) {
  constexpr double least_loss = 0.005;  // below it, proportion has no meaning
  const double loss = 1 - volume_ratio;
  if (loss < least_loss) {
    return {};
  }
  std::vector<Contraction> all{
      {"little", "half of the loss of volume in Vavourakis 2016 (assumed)", 0.96, 0, {}},
      {"strong",
       "as the cavities after surgery of Kader 2008, doi:10.1016/j.ijrobp.2008.02.049",
       0.29,
       0,
       {}}};
  for (Contraction& contraction : all) {
    contraction.factor = (1 - contraction.volume_ratio) / loss;
  }
  return all;
}

std::vector<Vec3> exaggerated(std::span<const Vec3> before, std::span<const Vec3> after,
                              double factor) {
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < before.size(); ++v) {
    points.push_back(before[v] + factor * (after[v] - before[v]));
  }
  return points;
}

/// Smallest and largest change over the case and its contractions.
json change_range(const Cosmetics& c, std::size_t metric) {
  const outcome::Metric& own = c.metrics[metric];
  if (!own.change || c.contractions.empty()) {
    return nullptr;
  }
  double low = *own.change, high = *own.change;
  for (const Contraction& contraction : c.contractions) {
    low = std::min(low, contraction.metrics[metric].change.value_or(low));
    high = std::max(high, contraction.metrics[metric].change.value_or(high));
  }
  return {{"low", low}, {"high", high}};
}

json contractions_json(const Cosmetics& c) {
  json list = json::array();
  for (const Contraction& contraction : c.contractions) {
    list.push_back({{"key", contraction.key},
                    {"meaning", contraction.meaning},
                    {"volume_ratio", contraction.volume_ratio},
                    {"displacement_factor", contraction.factor}});
  }
  return list;
}

json optional(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}
json range(const std::optional<outcome::Range>& r) {
  return r ? json{{"sd", r->sd}, {"p05", r->p05}, {"p95", r->p95}} : json(nullptr);
}
std::string quoted(std::string text) {
  for (auto at = text.find('"'); at != std::string::npos; at = text.find('"', at + 2)) {
    text.insert(at, 1, '"');
  }
  return '"' + text + '"';
}

}  // namespace

Cosmetics cosmetics_of(const CaseResult& r, const Skin& skin) {
  const FoldPlace fold = find_folds(r, skin);
  const auto notch = r.landmarks.find("sternal_notch");
  const bool known = notch != r.landmarks.end();
  const Vec3 origin = known ? notch->second : upper_middle(r, skin);
  Cosmetics c;
  c.question.before = torso_of(r, skin, skin.before.mesh, r.points(r.before), origin, fold);
  c.question.after = torso_of(r, skin, skin.after, r.points(r.after), origin, fold);
  c.question.treated = r.side() > 0 ? 1 : 0;
  double breast_m3 = 0;
  const std::vector<double> volumes = cell_volumes(r.model.mesh, r.model.mesh.points);
  for (std::size_t cell = 0; cell < volumes.size(); ++cell) {
    breast_m3 += r.model.in_breast[cell] && r.model.side[cell] == r.side() ? volumes[cell] : 0.0;
  }
  c.question.excised_percent = 100 * r.wound.excised_m3 / breast_m3;
  c.question.notch_known = known;
  c.question.folds_known = fold.known;
  // The chest does not move: one frame serves both poses.
  c.frame = outcome::body_frame(c.question.before, {1, 0, 0});
  c.metrics = outcome::cosmetic_metrics(c.question, c.frame);
  c.contractions = contractions_of(r.history.back().volume_ratio);
  for (Contraction& contraction : c.contractions) {
    outcome::Question q = c.question;
    TriMesh surface = skin.before.mesh;
    surface.points = exaggerated(skin.before.mesh.points, skin.after.points, contraction.factor);
    q.after = torso_of(r, skin, surface,
                       exaggerated(r.points(r.before), r.points(r.after), contraction.factor),
                       origin, fold);
    contraction.metrics = outcome::cosmetic_metrics(q, c.frame);
  }
  c.chance_bra_above_26mm = outcome::chance_of_bra_above(c.question, c.frame, 26.0);
  const auto grade = [&](const outcome::Torso& torso) {
    auto values = outcome::landmark_indices(torso, c.frame, c.question.treated);
    return outcome::ptosis_grade(values["nipple_above_fold_treated_mm"],
                                 values["nipple_above_lowest_treated_mm"]);
  };
  c.ptosis_before = grade(c.question.before);
  c.ptosis_after = grade(c.question.after);
  c.ptosis_chances_before =
      outcome::chances_of_ptosis(c.question.before, c.frame, c.question.treated);
  c.ptosis_chances_after =
      outcome::chances_of_ptosis(c.question.after, c.frame, c.question.treated);
  return c;
}

json cosmetics_json(const Cosmetics& c) {
  json list = json::array();
  for (std::size_t i = 0; i < c.metrics.size(); ++i) {
    const outcome::Metric& m = c.metrics[i];
    list.push_back({{"key", m.key},
                    {"name", m.name},
                    {"unit", m.unit},
                    {"group", m.group},
                    {"before", optional(m.before)},
                    {"after", optional(m.after)},
                    {"change", optional(m.change)},
                    {"change_range", change_range(c, i)},
                    {"before_range", range(m.before_range)},
                    {"after_range", range(m.after_range)},
                    {"noise_floor", m.noise_floor},
                    {"noise_source", m.noise_source},
                    {"below_noise", m.is_noise},
                    {"reference", m.reference},
                    {"source", m.source}});
  }
  return {{"metrics", list},
          {"chance_bra_above_26mm", c.chance_bra_above_26mm},
          {"ptosis_treated",
           {{"before", c.ptosis_before},
            {"after", c.ptosis_after},
            {"chances_before", c.ptosis_chances_before},
            {"chances_after", c.ptosis_chances_after}}},
          {"contractions", contractions_json(c)},
          {"sternal_notch_known", c.question.notch_known},
          {"fold_known", c.question.folds_known},
          {"not_predicted", {"colour and scar indices of BCCT.core", "Harvard class"}}};
}

std::string cosmetics_csv(const Cosmetics& c) {
  std::string text =
      "key,name,unit,before,after,change,change_low,change_high,before_sd,after_sd,noise_floor,"
      "below_noise,reference,"
      "source\n";
  const auto number = [](const std::optional<double>& x) {
    return x ? fmt::format("{:.3f}", *x) : std::string();
  };
  for (std::size_t i = 0; i < c.metrics.size(); ++i) {
    const outcome::Metric& m = c.metrics[i];
    const json likely = change_range(c, i);
    const auto end = [&](const char* which) {
      return likely.is_null() ? std::string() : fmt::format("{:.3f}", likely[which].get<double>());
    };
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{},{},{:.3f},{},{},{}\n", m.key, quoted(m.name),
                    m.unit, number(m.before), number(m.after), number(m.change), end("low"),
                    end("high"), m.before_range ? fmt::format("{:.3f}", m.before_range->sd) : "",
                    m.after_range ? fmt::format("{:.3f}", m.after_range->sd) : "", m.noise_floor,
                    m.is_noise ? "yes" : "no", quoted(m.reference), quoted(m.source));
  }
  return text;
}

}  // namespace sanatrix::pipeline
