#include "pipeline/recipe.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/files.hpp"

namespace sanatrix::pipeline {
namespace {

std::string describe(const FocusRule& rule) {
  const auto words = [](const std::optional<Vec3>& v) {
    return v ? fmt::format("{} {} {}", (*v)[0], (*v)[1], (*v)[2]) : std::string("from labels");
  };
  return fmt::format("centre {}, axis {}, side {}, radius {}", words(rule.centre), words(rule.axis),
                     rule.side == surgery::Side::Left ? "L" : "R", rule.radius);
}

}  // namespace

std::string Recipe::fingerprint() const {
  std::string text;
  for (const auto& [name, value] : entries) {
    text.append(name).append("\n").append(value).append("\n");
  }
  return sha256_of_text(text);
}

Recipe recipe(const Case& patient, Stage stage) {
  const StageInfo& about = info(stage);
  Recipe made;
  made.entries["stage"] = about.name;
  made.entries["code version"] = std::to_string(about.version);
  for (const ParameterInfo& parameter : parameter_table()) {
    const bool used = std::ranges::any_of(about.prefixes, [&](const std::string& prefix) {
      return parameter.key.starts_with(prefix);
    });
    if (used) {
      made.entries["parameter " + parameter.key] = patient.parameters.text(parameter.key);
    }
  }
  for (const Stage upstream : about.upstream) {
    // Without a plan the upright pose before surgery is all there is.
    if (upstream != Stage::Heal || patient.has_plan() || stage != Stage::Upright) {
      made.entries["stage " + info(upstream).name] = recipe(patient, upstream).fingerprint();
    }
  }
  const auto add_input = [&](const std::string& name) {
    if (const auto input = patient.inputs.find(name); input != patient.inputs.end()) {
      made.entries["input " + name] = input->second.sha256;
    }
  };
  if (stage == Stage::Image) {
    for (const std::string name : {"labels", "image", "image_facts", "scan_frame"}) {
      add_input(name);
    }
    if (patient.scan_only()) {  // beside an image, a scan only says how she looks standing
      add_input("scan");
    }
  } else if (stage == Stage::Segment) {
    made.entries["label preset"] = patient.label_preset;
    add_input("tumour");
  } else if (stage == Stage::Mesh && patient.focus) {
    made.entries["focus"] = describe(*patient.focus);
  } else if (stage == Stage::Surgery) {
    add_input("plan");
  } else if (stage == Stage::Outcome) {
    for (const auto& [name, input] : patient.inputs) {
      if (name.starts_with("scan") || name.starts_with("followup")) {
        add_input(name);
      }
    }
  }
  return made;
}

std::string difference(const Recipe& old, const Recipe& now) {
  std::string text;
  const auto add = [&](const std::string& what) {
    text += (text.empty() ? "" : "; ") + what;
  };
  for (const auto& [name, value] : now.entries) {
    const auto before = old.entries.find(name);
    if (before != old.entries.end() && before->second == value) {
      continue;
    }
    if (name.starts_with("stage ") || name.starts_with("input ") || name == "focus") {
      add(name + " changed");
    } else if (before == old.entries.end()) {
      add(name + " is new");
    } else {
      add(fmt::format("{}: {} -> {}", name, before->second, value));
    }
  }
  for (const auto& [name, value] : old.entries) {
    if (!now.entries.contains(name)) {
      add(name + " is gone");
    }
  }
  return text;
}

}  // namespace sanatrix::pipeline
