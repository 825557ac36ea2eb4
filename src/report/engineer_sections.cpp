// What engineer and reviewer read: validation, model facts, provenance, limits.
#include <algorithm>

#include <fmt/format.h>

#include "core/embedded_models.hpp"
#include "outcome/scan_comparison.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"

namespace sanatrix::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Stage;

std::string distance_row(const std::string& name, const json& d) {
  if (d.is_null()) {
    return fmt::format("<tr><td>{}</td><td colspan=\"6\">not covered by the scan</td></tr>", name);
  }
  std::string row = "<tr><td>" + name + "</td>";
  for (const char* key : {"mean_mm", "std_mm", "p50_mm", "p90_mm", "p95_mm", "max_mm"}) {
    row += "<td class=\"n\">" + shown(d.at(key)) + "</td>";
  }
  return row + "</tr>\n";
}

std::string distance_rows(const std::string& what, const json& table) {
  return distance_row(what + ", whole", table.at("whole")) +
         distance_row(what + ", both breasts", table.at("both_breasts")) +
         distance_row(what + ", operated breast", table.at("operated_breast"));
}

/// Rows of a preset's values: {"value", "unit", "status", "source"}, perhaps one level deeper.
std::string value_rows(const std::string& prefix, const json& values) {
  std::string rows;
  for (const auto& [key, entry] : values.items()) {
    if (!entry.is_object()) {
      continue;
    }
    if (!entry.contains("value")) {
      rows += value_rows(prefix + key + " ", entry);
      continue;
    }
    const json& value = entry.at("value");
    rows += fmt::format("<tr><td>{}{}</td><td class=\"n\">{} {}</td><td>{}</td><td>{}</td></tr>\n",
                        escaped(prefix), escaped(key),
                        escaped(value.is_string() ? value.get<std::string>() : value.dump()),
                        escaped(entry.value("unit", "")), escaped(entry.value("status", "")),
                        escaped(entry.value("source", "")));
  }
  return rows;
}

std::string preset_rows(const std::string& kind, const std::string& name) {
  const auto found = embedded_models().find(kind + "/" + name + ".json");
  if (found == embedded_models().end()) {
    return {};
  }
  const json preset = json::parse(found->second);
  const json& values = preset.contains("values") ? preset.at("values") : preset;
  return fmt::format("<tr class=\"group\"><th colspan=\"4\">{}: {}</th></tr>", kind,
                     escaped(name)) +
         value_rows("", values);
}

std::string stage_rows(const Findings& f) {
  std::string rows;
  for (const auto& stage : pipeline::all_stages()) {
    const auto record = pipeline::read_record(f.patient, stage.id);
    std::string numbers;
    for (const auto& [name, value] : record->numbers) {
      numbers += fmt::format("{}{} {:.5g}", numbers.empty() ? "" : ", ", name, value);
    }
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"n\">{:.1f}</td><td>{}</td></tr>\n",
                        stage.letter, stage.title, record->seconds, escaped(numbers));
  }
  return rows;
}

double volume_change_percent(const Findings& f, std::span<const Vec3> pose) {
  double before = 0, after = 0;
  const auto unloaded = cell_volumes(f.result.model.mesh, f.result.points(f.result.unloaded));
  const auto posed = cell_volumes(f.result.model.mesh, pose);
  for (std::size_t c = 0; c < posed.size(); ++c) {
    before += unloaded[c];
    after += posed[c];
  }
  return 100 * (after - before) / before;
}

}  // namespace

std::string validation_section(const Findings& f, const fs::path& pictures) {
  if (!f.scans.followup) {
    return {};
  }
  const json& scans = f.outcome.at("scans");
  std::string html =
      "<h2 class=\"page\">Against the follow-up scan</h2><div "
      "class=\"wide\"><table><thead><tr><th>distance "
      "[mm]</th><th class=\"n\">mean</th><th class=\"n\">std</th><th class=\"n\">50 %</th><th "
      "class=\"n\">90 %</th><th class=\"n\">95 %</th><th class=\"n\">max</th></tr></thead><tbody>";
  html += distance_rows("prediction, best rigid fit", scans.at("followup").at("table1"));
  html += distance_rows("prediction, chest kept in place",
                        scans.at("followup").at("table1_chest_fixed"));
  if (f.scans.preop) {
    html += distance_rows("model before surgery, chest kept in place",
                          scans.at("preop").at("model_error"));
  }
  html +=
      "<tr><td class=\"quiet\">Vavourakis 2016, four patients, best fit</td><td class=\"n "
      "quiet\">2.8-4.1</td><td class=\"n quiet\">2.4-3.3</td><td class=\"n quiet\">2.0-3.5</td><td "
      "class=\"n quiet\">5.7-8.7</td><td class=\"n quiet\">7.6-10.6</td><td></td></tr>"
      "</tbody></table></div>";
  if (f.scans.observed) {
    const json& seen = scans.at("observed_retraction").at("operated_breast");
    html += fmt::format(
        "<p>Between the two scans themselves, the operated breast has gone in by {} mm at the "
        "deepest place (along the skin's normal, mean over 3 mm; {} mm straight towards the back); "
        "{} "
        "cm&sup2; by more than 3 mm.</p>",
        shown(seen.at("depth_mm")), shown(seen.at("depth_straight_back_mm")),
        shown(seen.at("area_over_3mm_cm2")));
  }
  if (fs::exists(pictures / "distance.png")) {
    html += fmt::format(
        "<figure>{}<figcaption>The scan, the distance of the prediction from it, and what has "
        "changed "
        "between the scans. Grey: no counterpart.</figcaption></figure>",
        embedded_picture(pictures / "distance.png", "Distances in colours"));
  }
  const std::vector<bool> all(f.skin.after.points.size(), true);
  constexpr double bin_mm = 0.5;
  return html + "<figure>" +
         bar_chart(
             outcome::histogram(f.skin.after, f.scans.followup->distance, all, 1e-3 * bin_mm, 32),
             bin_mm, "distance [mm]; the last bar holds everything beyond", "share of the skin") +
         "<figcaption>Histogram of the distances after the best rigid fit.</figcaption></figure>";
}

std::string model_section(const Findings& f, const fs::path& outcome) {
  const auto& parameters = f.patient.parameters;
  std::string html = fmt::format(
      "<h2 class=\"page\">The model</h2><p>{} vertices, {} tetrahedra, element {}. Smallest det F "
      "in any pose {:.3f}. Volume against the unloaded shape: supine {:+.2f} %, upright before "
      "{:+.2f} %, upright after {:+.2f} % (the operated region shrinks by design).</p>",
      f.result.model.mesh.points.size(), f.result.model.mesh.cells.size(),
      parameters.text("solver.element"), f.outcome.at("min_jacobian").get<double>(),
      volume_change_percent(f, f.result.points(f.result.supine)),
      volume_change_percent(f, f.result.points(f.result.before)),
      volume_change_percent(f, f.result.points(f.result.after)));
  html +=
      "<div class=\"wide\"><table><thead><tr><th>step</th><th>what</th><th "
      "class=\"n\">seconds</th><th>convergence and sizes</th></tr></thead><tbody>" +
      stage_rows(f) + "</tbody></table></div>";
  if (fs::exists(outcome / "fig5_species.png")) {
    html += fmt::format(
        "<figure>{}<figcaption>Healing inside the operated region, lying on the "
        "back.</figcaption></figure>",
        embedded_picture(outcome / "fig5_species.png", "Species on a cut"));
  }
  html +=
      "<details><summary>Values with their status and source</summary><div "
      "class=\"wide\"><table><thead><tr><th>value</th><th></th><th>status</th><th>source</th>"
      "</tr></thead><tbody>" +
      preset_rows("tissue", parameters.text("tissue.preset")) +
      preset_rows("healing", parameters.text("heal.preset")) + "</tbody></table></div></details>";
  std::string given;
  for (const auto& [key, value] : parameters.given()) {
    given += fmt::format("<li><code>{} = {}</code></li>", escaped(key), escaped(value));
  }
  return html + (given.empty() ? "<p>No parameter differs from its default.</p>"
                               : "<p>Set for this case:</p><ul>" + given + "</ul>");
}

std::string provenance_section(const Findings& f, const Program& program) {
  std::string rows;
  const auto row = [&](const std::string& what, const std::string& value) {
    rows +=
        fmt::format("<tr><td>{}</td><td><code>{}</code></td></tr>", escaped(what), escaped(value));
  };
  row("case", f.patient.pseudonym);
  for (const auto& [name, input] : f.patient.inputs) {
    row("input " + name + ", SHA-256", input.sha256);
  }
  row("result, fingerprint", pipeline::recipe(f.patient, Stage::Outcome).fingerprint());
  row("program", program.version);
  row("libraries", program.libraries);
  row("command", program.command);
  for (const auto* scan : {f.scans.preop ? &f.scans.preop->placed : nullptr,
                           f.scans.followup ? &f.scans.followup->placed : nullptr}) {
    if (scan != nullptr) {
      row(f.scans.preop && scan == &f.scans.preop->placed ? "scan before surgery"
                                                          : "follow-up scan",
          fmt::format("{} triangles, unit {}, laid on with {:.2f} mm (median), {:.0f} % overlap",
                      scan->surface.mesh.triangles.size(), scan->unit, 1e3 * scan->pose.median_m,
                      100 * scan->pose.overlap));
      for (const std::string& note : scan->notes) {
        row("- note", note);
      }
    }
  }
  return "<h2>Provenance</h2><div class=\"wide\"><table><tbody>" + rows + "</tbody></table></div>";
}

std::string limits_section() {
  return "<h2>Limits</h2><ul><li>Most tissue values are taken from publications or assumed; none "
         "is "
         "measured in this patient. The table of values says which.</li><li>Removed tissue is "
         "modelled as weakened tissue that regains strength, not as a cavity or seroma.</li>"
         "<li>Radiotherapy, infection, drains, tissue displacement and changes of weight are not "
         "modelled.</li><li>Skin that touches skin (the inframammary fold) is not kept from "
         "passing "
         "through itself.</li><li>The prediction has been compared with synthetic truth and the "
         "paper's numbers, not with a cohort of operated patients.</li></ul>" +
         notice();
}

}  // namespace sanatrix::report
