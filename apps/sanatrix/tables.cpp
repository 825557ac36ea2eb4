#include "tables.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/stage_store.hpp"

namespace sanatrix::app {

using nlohmann::json;

std::string stage_names() {
  std::string names;
  for (const pipeline::StageInfo& stage : pipeline::all_stages()) {
    names += (names.empty() ? "" : ", ") + stage.name;
  }
  return names;
}

json stages_json(const pipeline::Case& patient) {
  json stages = json::array();
  for (const pipeline::StageInfo& stage : pipeline::all_stages()) {
    const pipeline::StageStatus s = pipeline::status(patient, stage.id);
    stages.push_back({{"name", stage.name},
                      {"letter", stage.letter},
                      {"state", pipeline::name_of(s.state)},
                      {"reason", s.reason},
                      {"seconds", s.seconds},
                      {"warnings", s.warnings}});
  }
  return stages;
}

std::string parameters_text() {
  std::string text;
  for (const pipeline::ParameterInfo& p : pipeline::parameter_table()) {
    std::string value = p.standard.empty() ? "" : p.standard;
    if (!p.unit.empty() && !value.empty()) {
      value += " " + p.unit;
    }
    text += fmt::format("  {:<36} {:<16} {}", p.key, value, p.doc);
    if (!p.choices.empty()) {
      text += fmt::format(" ({})", fmt::join(p.choices, "|"));
    }
    text += "\n";
  }
  return text;
}

json parameters_json() {
  json list = json::array();
  for (const pipeline::ParameterInfo& p : pipeline::parameter_table()) {
    json j{{"key", p.key}, {"default", p.standard}, {"unit", p.unit}, {"doc", p.doc}};
    if (!p.choices.empty()) {
      j["choices"] = p.choices;
    } else if (p.kind != pipeline::Kind::Text) {
      j["min"] = p.min;
      j["max"] = p.max;
    }
    list.push_back(std::move(j));
  }
  return list;
}

namespace {

/// What an error of the chest wall does to the numbers above it.
std::string wall_range_text(const json& o) {
  const json range = o.value("wall_range", json());
  if (range.is_null()) {
    return {};
  }
  const auto between = [&](const char* key, int digits) {
    const json& r = range.at(json::json_pointer(key));
    const std::string low = fmt::format("{:.{}f}", r.at("low").get<double>(), digits);
    const std::string high = fmt::format("{:.{}f}", r.at("high").get<double>(), digits);
    return low == high ? low : low + "-" + high;
  };
  std::string text = fmt::format(
      "chest wall +-{:g} mm       skin moves max {} mm, mean {} mm; breast L {}, R {} cm3\n",
      range.at("moved_mm").get<double>(), between("/max_displacement_upright_mm", 1),
      between("/mean_displacement_upright_mm", 2), between("/breast_volume_cm3/L", 0),
      between("/breast_volume_cm3/R", 0));
  for (const auto& [variant, error] : range.at("failed").items()) {
    text +=
        fmt::format("chest wall {}        not computed: {}\n", variant, error.get<std::string>());
  }
  return text;
}

}  // namespace

std::string outcome_text(const json& o) {
  const auto number = [&](const char* key) {
    return o.at(key).get<double>();
  };
  std::string text = fmt::format(
      "operated side            {}\n"
      "breast volume            L {:.0f} cm3, R {:.0f} cm3\n"
      "excised                  {:.1f} cm3 ({:.1f} % of the breast)\n"
      "operated region, final   {:.3f} of its volume\n"
      "skin moves (upright)     max {:.1f} mm, mean {:.2f} mm (mesh error about {:.1f} %)\n"
      "smallest det F           {:.3f}\n"
      "mesh                     {} vertices, {} cells\n",
      o.at("operated_side") == "L" ? "patient's LEFT" : "patient's RIGHT",
      o.at("breast_volume_cm3").at("L").get<double>(),
      o.at("breast_volume_cm3").at("R").get<double>(), number("excised_cm3"),
      number("excised_percent"), number("wound_volume_ratio_final"),
      number("max_displacement_upright_mm"), number("mean_displacement_upright_mm"),
      100.0 * o.at("discretisation_error").at("relative").get<double>(), number("min_jacobian"),
      o.at("mesh").at("vertices").get<int>(), o.at("mesh").at("cells").get<int>());
  text += wall_range_text(o);
  double total = 0.0;
  text += "seconds                 ";
  for (const pipeline::StageInfo& stage : pipeline::all_stages()) {
    const double s = o.at("seconds").value(stage.name, 0.0);
    text += fmt::format(" {} {:.1f}", stage.name, s);
    total += s;
  }
  text += fmt::format(", total {:.1f}\n", total);
  for (const json& warning : o.at("warnings")) {
    text += fmt::format("warning: {}\n", warning.get<std::string>());
  }
  return text + "Research use only. Not a medical device.\n";
}

}  // namespace sanatrix::app
