// Several cases, or several plans of one patient, beside each other.
#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "report/views.hpp"

namespace sanatrix::report {
namespace {

using nlohmann::json;

std::string header(const std::vector<Findings>& cases) {
  std::string html = "<thead><tr><th></th>";
  for (const Findings& f : cases) {
    html += fmt::format("<th class=\"n\">{}</th>", escaped(f.folder));
  }
  return html + "</tr></thead>";
}

template <class Value>
std::string row(const std::vector<Findings>& cases, const std::string& what, Value&& value) {
  std::string html = "<tr><td>" + what + "</td>";
  for (const Findings& f : cases) {
    html += "<td class=\"n\">" + value(f) + "</td>";
  }
  return html + "</tr>\n";
}

std::string plans(const std::vector<Findings>& cases) {
  std::string html = "<h2>Plans</h2><div class=\"wide\"><table>" + header(cases) + "<tbody>";
  const auto add = [&](const std::string& what, auto&& value) {
    html += row(cases, what, [&](const Findings& f) { return value(in_words(f)); });
  };
  add("breast", [](const PlanInWords& p) { return "patient's " + p.side; });
  add("place", [](const PlanInWords& p) { return p.place.quadrant; });
  add("from the nipple [mm]",
      [](const PlanInWords& p) { return shown(p.place.from_nipple_mm, 0); });
  add("radius [mm]", [](const PlanInWords& p) { return shown(p.radius_mm); });
  add("margin [mm]", [](const PlanInWords& p) { return shown(p.margin_mm); });
  add("removed [cm&sup3;]", [](const PlanInWords& p) { return shown(p.excised_cm3); });
  add("removed [g]", [](const PlanInWords& p) { return shown(p.excised_g, 0); });
  add("removed [% of the breast]", [](const PlanInWords& p) { return shown(p.excised_percent); });
  return html + "</tbody></table></div>";
}

std::string results(const std::vector<Findings>& cases) {
  std::string html = "<h2>Predicted</h2><div class=\"wide\"><table>" + header(cases) + "<tbody>";
  html += row(cases, "skin moves, mean [mm]", [](const Findings& f) {
    return shown(f.outcome.at("mean_displacement_upright_mm"));
  });
  html += row(cases, "skin moves, at most [mm]",
              [](const Findings& f) { return shown(f.outcome.at("max_displacement_upright_mm")); });
  html += row(cases, "operated region, final volume [%]", [](const Findings& f) {
    return shown(100 * f.outcome.at("wound_volume_ratio_final").get<double>());
  });
  const json& first = cases.front().outcome.at("cosmetics").at("metrics");
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::string unit = first[i].at("unit");
    const int digits = unit.empty() ? 2 : 1;
    html += row(cases,
                escaped(first[i].at("name").get<std::string>()) +
                    (unit.empty() ? "" : " [" + escaped(unit) + "]") + ", change",
                [&](const Findings& f) {
                  const json& m = f.outcome.at("cosmetics").at("metrics").at(i);
                  const std::string text = shown(m.at("change"), digits);
                  return m.at("below_noise").get<bool>()
                             ? "<span class=\"quiet\">" + text + " (noise)</span>"
                             : text;
                });
  }
  return html + "</tbody></table></div>";
}

std::string curves(const std::vector<Findings>& cases) {
  std::vector<Line> lines;
  for (const Findings& f : cases) {
    lines.push_back({f.folder, {}, {}});
    for (const auto& step : f.result.history) {
      lines.back().x.push_back(step.species.t_day);
      lines.back().y.push_back(100 * step.volume_ratio);
    }
  }
  return "<h2>Healing</h2><figure>" +
         line_chart(lines, "days after surgery", "volume of the operated region [%]") + "</figure>";
}

}  // namespace

void write_comparison(const std::vector<pipeline::Case>& cases, const Program& program,
                      const std::filesystem::path& file, const Context& ctx) {
  if (cases.size() < 2) {
    throw Error(Fault::Usage, "a comparison needs two cases or more",
                "name them one after the other");
  }
  std::vector<Findings> all;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    ctx.at(0.5 * static_cast<double>(i) / static_cast<double>(cases.size()), "reading the cases");
    all.push_back(find(cases[i], ctx));
  }
  ctx.at(0.5, "pictures");
  std::filesystem::path png = file;
  png += ".png";
  std::optional<std::string> reason;
  try {
    reason = draw_comparison(all, png, ctx);
  } catch (const Cancelled&) {
    std::error_code ignored;
    std::filesystem::remove(png, ignored);
    throw;
  }
  std::string pictures = reason ? "<p>No pictures: " + escaped(*reason) + "</p>"
                                : "<figure>" + embedded_picture(png, "Cases side by side") +
                                      "<figcaption>Same scale and colours for all; obliques show "
                                      "the operated side.</figcaption></figure>";
  std::error_code ignored;
  std::filesystem::remove(png, ignored);
  write_text(file, page("Sanatrix comparison",
                        "<h1>Plans side by side</h1>" + notice() + plans(all) + pictures +
                            results(all) + curves(all) + limits_section() + "<p class=\"quiet\">" +
                            escaped(program.version) + "</p>"));
}

}  // namespace sanatrix::report
