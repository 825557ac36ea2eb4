#include "pipeline/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "core/error.hpp"
#include "healing/model.hpp"
#include "mechanics/material.hpp"
#include "mechanics/problem.hpp"

namespace sanatrix::pipeline {
namespace {

ParameterInfo number(std::string key, std::string standard, double min, double max,
                     std::string unit, std::string doc) {
  return {std::move(key),  Kind::Number, std::move(standard), min, max,
          std::move(unit), {},           std::move(doc)};
}
ParameterInfo integer(std::string key, std::string standard, double min, double max,
                      std::string doc) {
  return {std::move(key), Kind::Integer, std::move(standard), min, max, "", {}, std::move(doc)};
}
ParameterInfo choice(std::string key, std::vector<std::string> choices, std::string doc,
                     std::string standard) {
  return {std::move(key),     Kind::Choice,  std::move(standard), 0, 0, "",
          std::move(choices), std::move(doc)};
}
ParameterInfo text(std::string key, std::string standard, std::string doc) {
  return {std::move(key), Kind::Text, std::move(standard), 0, 0, "", {}, std::move(doc)};
}

void add_geometry(std::vector<ParameterInfo>& t) {
  t.push_back(number("segment.spacing_mm", "1", 0.5, 3, "mm",
                     "voxel size to which the labels are resampled"));
  t.push_back(choice("segment.density", {"a", "b", "c", "d"},
                     "density class of the breasts; for cases from a scan alone", "b"));
  t.push_back(number("segment.wall_depth_mm", "16", 4, 40, "mm",
                     "soft tissue over the chest wall beside the breasts; for cases from a scan "
                     "alone"));
  t.push_back(number("segment.wall_shift_mm", "0", -15, 15, "mm",
                     "moves the chest wall, deeper when positive: to see what its error does"));
  t.push_back(choice("mesh.preset", {"standard", "paper"},
                     "standard: about 10,000 vertices; paper: about 5,000 vertices", "standard"));
  t.push_back(integer("mesh.target_vertices", "", 500, 2e6,
                      "number of vertices to aim at (default: as the preset)"));
  t.push_back(number("mesh.near_edge_mm", "", 1, 20, "mm",
                     "longest edge in and around the planned resection (default: as the preset)"));
  t.push_back(number("mesh.far_edge_mm", "8", 2, 40, "mm",
                     "edge length far from it; scaled to meet the number of vertices"));
  t.push_back(number("mesh.slab_half_height_mm", "0", 0, 200, "mm",
                     "half height of the model; 0: chosen from the extent of the breasts"));
  t.push_back(number("mesh.time_limit_s", "300", 1, 1e5, "s", "gives up after this time"));
}

void add_body(std::vector<ParameterInfo>& t) {
  t.push_back(text("tissue.preset", "vavourakis2016", "tissue values (models/tissue)"));
  for (const std::string tissue : {"adipose", "fibroglandular"}) {
    const std::string of = " of " + tissue + " tissue (default: as the preset)";
    t.push_back(number("tissue." + tissue + "_c1_pa", "", 0, 1e7, "Pa", "Mooney-Rivlin c1" + of));
    t.push_back(number("tissue." + tissue + "_c2_pa", "", 0, 1e7, "Pa", "Mooney-Rivlin c2" + of));
    t.push_back(number("tissue." + tissue + "_kappa_pa", "", 1e2, 1e9, "Pa", "bulk modulus" + of));
    t.push_back(
        number("tissue." + tissue + "_density_kg_m3", "", 100, 3000, "kg/m3", "density" + of));
  }
  t.push_back(choice("skin.enabled", {"yes", "no"}, "is there a skin membrane?", "yes"));
  t.push_back(number("skin.thickness_mm", "", 0.1, 5, "mm", "skin thickness (default: preset)"));
  t.push_back(
      number("skin.alpha_pa", "", 0, 1e8, "Pa", "Veronda-Westmann alpha (default: preset)"));
  t.push_back(number("skin.beta", "", 0, 50, "", "Veronda-Westmann beta (default: preset)"));
  t.push_back(
      number("skin.c2_pa", "", -1e8, 1e8, "Pa",
             "Veronda-Westmann c2 (default: preset; -alpha beta / 2 is stress-free at rest)"));
  t.push_back(
      number("skin.density_kg_m3", "", 100, 3000, "kg/m3", "skin density (default: preset)"));
  t.push_back(choice("skin.tension_field", {"yes", "no"},
                     "relaxed energy: skin bears no compression", "yes"));
  t.push_back(choice("solver.element", mechanics::element_names(),
                     "p1p1: stabilised linear, fast; smoothed: the same with strains averaged "
                     "around edges; p2p1: Taylor-Hood, accurate",
                     "p1p1"));
  t.push_back(number("solver.relative_tolerance", "1e-9", 1e-13, 1e-3, "",
                     "Newton stops when residual / load is below this"));
}

void add_treatment(std::vector<ParameterInfo>& t) {
  t.push_back(number("surgery.margin_mm", "", 0, 40, "mm", "margin (default: as the plan says)"));
  t.push_back(number("surgery.radius_mm", "", 3, 100, "mm",
                     "cylinder radius (default: the plan's, or tumour radius + margin)"));
  t.push_back(number("surgery.clearance_mm", "", 1, 30, "mm",
                     "distance kept from skin and chest wall (default: as the plan says, 5)"));
  t.push_back(number("surgery.tumour_radius_mm", "", 0.5, 60, "mm",
                     "tumour radius (default: as the plan says)"));
  t.push_back(choice("heal.preset", healing::preset_names(), "healing model and its values",
                     "vavourakis2016"));
  t.push_back(text("heal.overrides", "",
                   "values of the healing model, comma-separated: D_eta=4e-13,kappa=1e4"));
  t.push_back(number("heal.days", "90", 0.5, 3650, "days", "how long healing is followed"));
  t.push_back(number("heal.mechanics_interval_days", "6", 0.1, 365, "days",
                     "least time between two mechanical equilibria"));
  t.push_back(number("heal.mechanics_density_change", "0.05", 0, 1, "",
                     "change of the wound's mean cell density (healthy: 1) that calls for the next "
                     "equilibrium; 0: one every mechanics_interval_days"));
  t.push_back(number("heal.record_interval_days", "0.5", 0.01, 365, "days",
                     "time between two rows of history.csv"));
  t.push_back(choice("heal.scheme", {"cvode", "explicit"},
                     "cvode: adaptive implicit; explicit: the paper's Euler steps", "cvode"));
  t.push_back(number("heal.dt_s", "17.28", 1e-3, 1e5, "s", "step of the explicit scheme"));
  t.push_back(number("heal.relative_tolerance", "1e-4", 1e-10, 1e-2, "", "of cvode"));
  t.push_back(choice("outcome.scan_unit", {"guess", "mm", "cm", "in", "m"},
                     "unit of length of the surface scans; guess: by their size", "guess"));
  t.push_back(choice("outcome.wall_range", {"no", "yes"},
                     "range of the outcome from the doubt about the chest wall: two more runs",
                     "no"));
  t.push_back(choice("outcome.pictures", {"yes", "no"}, "make PNG pictures", "yes"));
}

std::vector<ParameterInfo> make_table() {
  std::vector<ParameterInfo> table;
  add_geometry(table);
  add_body(table);
  add_treatment(table);
  return table;
}

const ParameterInfo& find(const std::string& key) {
  std::string known;
  for (const ParameterInfo& parameter : parameter_table()) {
    if (parameter.key == key) {
      return parameter;
    }
    known += (known.empty() ? "" : ", ") + parameter.key;
  }
  throw Error(Fault::Usage, fmt::format("there is no parameter '{}'", key),
              fmt::format("the known ones are: {}", known));
}

double parse_number(const ParameterInfo& parameter, const std::string& value) {
  double parsed = 0.0;
  const char* end = value.data() + value.size();
  const auto [stop, problem] = std::from_chars(value.data(), end, parsed);
  require(problem == std::errc{} && stop == end && std::isfinite(parsed),
          "parameter {}: '{}' is not a number", parameter.key, value);
  require(parsed >= parameter.min && parsed <= parameter.max,
          "parameter {}: {} is outside {} ... {} {}", parameter.key, value, parameter.min,
          parameter.max, parameter.unit);
  require(parameter.kind != Kind::Integer || parsed == std::floor(parsed),
          "parameter {}: {} is not a whole number", parameter.key, value);
  return parsed;
}

/// The one way in which this value is stored, so that equal values have equal fingerprints.
std::string canonical(const ParameterInfo& parameter, const std::string& value) {
  switch (parameter.kind) {
    case Kind::Number:
      return fmt::format("{}", parse_number(parameter, value));
    case Kind::Integer:
      return fmt::format("{:.0f}", parse_number(parameter, value));
    case Kind::Choice:
      require(std::ranges::find(parameter.choices, value) != parameter.choices.end(),
              "parameter {}: '{}' is not one of: {}", parameter.key, value,
              fmt::join(parameter.choices, ", "));
      return value;
    case Kind::Text:
      break;
  }
  return value;
}

}  // namespace

const std::vector<ParameterInfo>& parameter_table() {
  static const std::vector<ParameterInfo> table = make_table();
  return table;
}

void Parameters::set(const std::string& assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(Fault::Usage, fmt::format("'{}' is not of the form key=value", assignment),
                "for example --set mesh.target_vertices=5000; `sanatrix params` lists the keys");
  }
  set(assignment.substr(0, equals), assignment.substr(equals + 1));
}

void Parameters::set(const std::string& key, const std::string& value) {
  const ParameterInfo& parameter = find(key);
  if (value.empty()) {
    given_.erase(key);
  } else {
    given_[key] = canonical(parameter, value);
  }
}

void Parameters::reset(const std::string& prefix) {
  std::erase_if(given_, [&](const auto& entry) { return entry.first.starts_with(prefix); });
}

void Parameters::check() const {
  mechanics::tissue_preset(text("tissue.preset"));
  healing::make_model(text("heal.preset"), list("heal.overrides"));
}

std::vector<std::string> Parameters::list(const std::string& key) const {
  std::vector<std::string> parts;
  std::istringstream stream(text(key));
  for (std::string part; std::getline(stream, part, ',');) {
    parts.push_back(part);
  }
  return parts;
}

std::string Parameters::text(const std::string& key) const {
  const ParameterInfo& parameter = find(key);
  const auto entry = given_.find(key);
  return entry != given_.end() ? entry->second : parameter.standard;
}

double Parameters::number(const std::string& key) const {
  const std::string value = text(key);
  ensure(!value.empty(), "parameter {} has no value", key);
  return parse_number(find(key), value);
}

int Parameters::integer(const std::string& key) const {
  return static_cast<int>(number(key));
}

}  // namespace sanatrix::pipeline
