// What patient and surgeon read: the plan in words, the views, the indices, healing.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "report/html.hpp"
#include "report/sections.hpp"

namespace sanatrix::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string fact(const std::string& value, const std::string& what) {
  return fmt::format("<li><b>{}</b>{}</li>", value, what);
}

std::string picture(const fs::path& file, const std::string& alternative,
                    const std::string& caption) {
  if (!fs::exists(file)) {
    return "<p class=\"quiet\">No picture could be drawn here.</p>";
  }
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>",
                     embedded_picture(file, alternative), caption);
}

std::string hour(double clock) {
  const int whole = static_cast<int>(clock);
  return clock - whole > 0.25 ? fmt::format("half past {}", whole == 0 ? 12 : whole)
                              : fmt::format("{}", whole);
}

const json* metric(const Findings& f, const std::string& key) {
  for (const json& m : f.outcome.at("cosmetics").at("metrics")) {
    if (m.at("key") == key) {
      return &m;
    }
  }
  return nullptr;
}

/// Best and worst case instead of one pretty picture.
std::string range_in_words(const Findings& f) {
  const json& contractions = f.outcome.at("cosmetics").at("contractions");
  if (contractions.empty()) {
    return {};
  }
  const double most = f.outcome.at("max_displacement_upright_mm");
  std::string text = "How strongly a wound shrinks differs between women: ";
  for (std::size_t i = 0; i < contractions.size(); ++i) {
    const json& c = contractions[i];
    const double factor = c.at("displacement_factor");
    text += fmt::format(
        "{}{} (to {:.0f} % of its volume) would move the skin by at most {:.1f} mm{}",
        i == 0 ? "" : ", ", c.at("key") == "little" ? "little shrinking" : "strong shrinking",
        100 * c.at("volume_ratio").get<double>(), most * factor,
        factor > 2 ? " (an upper estimate)" : "");
  }
  return text + ". ";
}

/// What is not known of the chest wall, in millimetres of skin.
std::string wall_in_words(const Findings& f) {
  const json& range = f.outcome.at("wall_range");
  if (range.is_null()) {
    return f.patient.scan_only()
               ? "The chest wall is not seen in a scan; what that does to these numbers was not "
                 "computed (run --set outcome.wall_range=yes). "
               : "";
  }
  const auto between = [&](const char* key) {
    const std::string low = shown(range.at(key).at("low")), high = shown(range.at(key).at("high"));
    return low == high ? low : fmt::format("{} to {}", low, high);
  };
  std::string text = fmt::format(
      "With the chest wall {:g} mm nearer to the skin or deeper, the skin would move by {} mm on "
      "average and {} mm at most. ",
      range.at("moved_mm").get<double>(), between("mean_displacement_upright_mm"),
      between("max_displacement_upright_mm"));
  for (const auto& [variant, error] : range.at("failed").items()) {
    text += fmt::format("With the wall {} no prediction was possible: {}. ", variant,
                        escaped(error.get<std::string>()));
  }
  return text;
}

/// One sentence that does not promise more than the model knows.
std::string in_short(const Findings& f) {
  const double mean = f.outcome.at("mean_displacement_upright_mm");
  const double most = f.outcome.at("max_displacement_upright_mm");
  const json* nipple = metric(f, "nipple_moved_mm");
  std::string text = fmt::format(
      "Standing, {:.0f} days after surgery, the skin of the operated breast is predicted to have "
      "moved by {:.1f} mm on average and {:.1f} mm at most",
      f.result.history.back().species.t_day, mean, most);
  if (nipple != nullptr && !nipple->at("change").is_null()) {
    text += fmt::format(", the nipple by {} mm", shown(nipple->at("change")));
  }
  text += ". " + range_in_words(f) + wall_in_words(f);
  return text +
         "Small numbers can lie within what a photograph or a landmark repeats to; the table "
         "below greys them. Real outcomes vary: radiotherapy, infection, fluid in the wound and "
         "changes of weight are not part of this prediction.";
}

/// ", 466-613 by the doubt about the chest wall"
std::string breast_range(const Findings& f, const char* side) {
  double low = 0, high = 0;
  if (const json& range = f.outcome.at("wall_range"); !range.is_null()) {
    low = range.at("breast_volume_cm3").at(side).at("low");
    high = range.at("breast_volume_cm3").at(side).at("high");
  } else if (f.patient.scan_only()) {
    const double volume = f.outcome.at("breast_volume_cm3").at(side);
    const double doubt = f.outcome.at("scan_only").at("breast_volume_doubt_cm3").at(side);
    low = volume - doubt;
    high = volume + doubt;
  } else {
    return {};
  }
  return fmt::format(", {:.0f}-{:.0f} by the doubt about the chest wall", low, high);
}

const char* group_title(const std::string& group) {
  if (group == "size") {
    return "Size";
  }
  if (group == "shape") {
    return "Shape";
  }
  if (group == "nipple") {
    return "Nipple";
  }
  if (group == "length") {
    return "Lengths";
  }
  return group == "contour" ? "Contour" : "Symmetry numbers (1 = symmetric)";
}

std::string with_range(const json& m, const char* value, const char* range, int digits) {
  std::string text = shown(m.at(value), digits);
  if (!m.at(range).is_null()) {
    text += fmt::format(" <span class=\"quiet\">({}-{})</span>",
                        shown(m.at(range).at("p05"), digits), shown(m.at(range).at("p95"), digits));
  }
  return text;
}

/// "none 80 %, I 20 %"
std::string chances(const json& of_grades) {
  std::string text;
  for (const auto& [grade, chance] : of_grades.items()) {
    text +=
        fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", grade, 100 * chance.get<double>());
  }
  return text;
}

/// Reasons of noise floors, each once, with a letter to refer to it.
class Footnotes {
 public:
  std::string refer(const std::string& text) {
    const auto known = std::ranges::find(texts_, text);
    const auto number = known - texts_.begin();
    if (known == texts_.end()) {
      texts_.push_back(text);
    }
    return fmt::format("<sup>{}</sup>", static_cast<char>('a' + number));
  }
  [[nodiscard]] std::string list() const {
    std::string html;
    for (std::size_t i = 0; i < texts_.size(); ++i) {
      html += fmt::format("{}<sup>{}</sup>&nbsp;{}", i == 0 ? "" : "; ",
                          static_cast<char>('a' + static_cast<int>(i)), escaped(texts_[i]));
    }
    return html;
  }

 private:
  std::vector<std::string> texts_;
};

/// What the change may become if the wound shrinks less or more, or the chest wall lies elsewhere.
std::string ranges_of_change(const json& m, int digits) {
  std::string text;
  for (const auto& [key, why] : {std::pair{"change_range", ""}, {"wall_range", "wall: "}}) {
    const json& range = m.at(key);
    if (!range.is_null() && range.at("high") != range.at("low")) {
      text += fmt::format("<br><span class=\"quiet\">{}{} to {}</span>", why,
                          shown(range.at("low"), digits), shown(range.at("high"), digits));
    }
  }
  return text;
}

std::string metric_row(const json& m, Footnotes& footnotes) {
  const std::string unit = m.at("unit");
  const int digits = unit.empty() ? 2 : 1;
  std::string source = escaped(m.at("source").get<std::string>());
  if (m.at("noise_floor").get<double>() > 0) {
    source += fmt::format("; noise below {} {}{}", shown(m.at("noise_floor"), digits),
                          escaped(unit), footnotes.refer(m.at("noise_source")));
  }
  return fmt::format(
      "<tr{}><td>{}{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}{}</td>"
      "<td>{}<br><span class=\"quiet\">{}</span></td></tr>\n",
      m.at("below_noise").get<bool>() ? " class=\"noise\"" : "",
      escaped(m.at("name").get<std::string>()), unit.empty() ? "" : " [" + escaped(unit) + "]",
      with_range(m, "before", "before_range", digits),
      with_range(m, "after", "after_range", digits), shown(m.at("change"), digits),
      (m.at("below_noise").get<bool>() ? " (noise)" : "") + ranges_of_change(m, digits),
      escaped(m.at("reference").get<std::string>()), source);
}

}  // namespace

std::string shown(const json& value, int digits) {
  if (!value.is_number()) {
    return "&ndash;";
  }
  const double x = value.get<double>();
  const double unit = std::pow(10.0, -digits);
  const double rounded = std::round(x / unit) * unit;
  return fmt::format("{}{:.{}f}", rounded < 0 ? "&minus;" : "", std::abs(rounded), digits);
}

std::string notice() {
  return "<p class=\"notice\">Research use only. Not a medical device. Not for diagnosis or "
         "treatment decisions.</p>";
}

std::string plan_section(const Findings& f, const fs::path& outcome) {
  const PlanInWords p = in_words(f);
  std::string html = fmt::format(
      "<h2>The plan</h2><p>Patient's <strong>{}</strong> breast, <strong>{}</strong>{}, at "
      "{}&nbsp;o'clock, {:.0f}&nbsp;mm from the nipple (position of the image). A cylinder of "
      "{:.0f}&nbsp;mm radius from chest wall to skin, planned margin {:.0f}&nbsp;mm; it keeps "
      "{:.1f}&nbsp;mm from the skin and {:.1f}&nbsp;mm from the chest wall.</p>",
      p.side, p.place.quadrant, p.place.quadrant == "central" ? "" : " quadrant",
      hour(p.place.clock_hour), p.place.from_nipple_mm, p.radius_mm, p.margin_mm, p.skin_mm,
      p.chest_mm);
  if (!f.result.plan.quadrant.empty()) {
    html += fmt::format("<p class=\"quiet\">The plan itself says: {}.</p>",
                        escaped(f.result.plan.quadrant));
  }
  html +=
      "<ul class=\"facts\">" + fact(fmt::format("{:.1f} cm&sup3;", p.excised_cm3), "removed") +
      fact(fmt::format("{:.0f} g", p.excised_g), "its weight") +
      fact(fmt::format("{:.1f} %", p.excised_percent), "of the breast") +
      fact(fmt::format(
               "{:.0f} cm&sup3;",
               f.outcome.at("breast_volume_cm3").at(p.side == "LEFT" ? "L" : "R").get<double>()),
           "volume of the breast" + breast_range(f, p.side == "LEFT" ? "L" : "R")) +
      "</ul>";
  for (const json& warning : f.outcome.at("warnings")) {
    html += "<p><strong>Note:</strong> " + escaped(warning.get<std::string>()) + "</p>";
  }
  return html + picture(outcome / "fig4_plan.png", "The tissue to be removed inside the breast",
                        "What is removed (red), lying on the back.");
}

std::string views_section(const Findings& f, const fs::path& pictures) {
  std::string html = "<h2>Before and after</h2><p>" + in_short(f) + "</p>" +
                     picture(pictures / "views.png", "Five standard views before and after",
                             "The model standing, before surgery and after healing; same "
                             "cameras. Skin and areolae are drawn, not photographed.");
  if (fs::exists(pictures / "views_photo.png")) {
    html +=
        "<details><summary>Show the patient's own skin (photographs)</summary>" +
        picture(pictures / "views_photo.png", "Photographed skin before and after",
                "The surface scan before surgery, and the same with the predicted displacement. "
                "Holes are places the camera did not see.") +
        "</details>";
  }
  return html + picture(pictures.parent_path() / "90-outcome" / "fig7_displacement.png",
                        "Displacement of the skin as arrows and colours",
                        "How far the skin moves, standing.");
}

std::string metrics_section(const Findings& f) {
  const json& cosmetics = f.outcome.at("cosmetics");
  std::string html =
      "<h2 class=\"page\">Cosmetic indices</h2><p>Standing; before surgery, predicted after, and "
      "the "
      "change. In brackets 5-95 % when landmarks are placed 2.5 mm (sd) off. Grey: the change is "
      "smaller than what such a measurement repeats to, so it must not be read as real. Below the "
      "change: from a wound that shrinks little to one that shrinks strongly, and, where it was "
      "computed, with the chest wall nearer to the skin and deeper.</p>"
      "<div class=\"wide\"><table><thead><tr><th>index</th><th class=\"n\">before</th><th "
      "class=\"n\">after</th><th class=\"n\">change</th><th>what is usual, definition, "
      "noise</th></tr></thead><tbody>\n";
  std::string group;
  Footnotes footnotes;
  for (const json& m : cosmetics.at("metrics")) {
    if (m.at("group") != group) {
      group = m.at("group");
      html += fmt::format("<tr class=\"group\"><th colspan=\"5\">{}</th></tr>", group_title(group));
    }
    html += metric_row(m, footnotes);
  }
  html += "</tbody></table></div><p class=\"quiet\">Noise: " + footnotes.list() + ".</p>";
  const json& ptosis = cosmetics.at("ptosis_treated");
  return html + fmt::format(
                    "<p>Ptosis of the treated breast (Regnault 1976): {} before, {} after{}; by "
                    "landmark doubt, after: {}. "
                    "Chance that BRA "
                    "exceeds 26 mm (healthy mean + 2 sd, Pezner 1985): {:.0f} %, from landmark "
                    "doubt alone.</p>"
                    "<p class=\"quiet\">Not predicted: colour and scar indices of BCCT.core, and "
                    "the Harvard "
                    "class, which need a photograph and a trained classifier.</p>",
                    ptosis.at("before").get<std::string>(), ptosis.at("after").get<std::string>(),
                    cosmetics.at("fold_known").get<bool>()
                        ? ""
                        : " (the fold lies below the model, its lower end stands for it)",
                    chances(ptosis.at("chances_after")),
                    100 * cosmetics.at("chance_bra_above_26mm").get<double>());
}

std::string healing_section(const Findings& f) {
  Line volume{"operated region", {}, {}};
  std::vector<Line> means;
  for (const auto& species : f.result.species) {
    means.push_back({species.label, {}, {}});
  }
  for (const auto& row : f.result.history) {
    volume.x.push_back(row.species.t_day);
    volume.y.push_back(100 * row.volume_ratio);
    for (std::size_t s = 0; s < means.size(); ++s) {
      means[s].x.push_back(row.species.t_day);
      means[s].y.push_back(row.species.mean[s]);
    }
  }
  return "<h2>Healing</h2><figure>" +
         line_chart({volume}, "days after surgery", "volume of the operated region [%]") +
         "<figcaption>The operated region shrinks as new cells pull it together: slowly during "
         "inflammation, then quickly, then to a plateau.</figcaption></figure><figure>" +
         line_chart(means, "days after surgery", "mean in the wound [healthy = 1]") +
         "<figcaption>Cells, messengers, vessels and oxygen in the operated region.</figcaption>"
         "</figure>";
}

}  // namespace sanatrix::report
