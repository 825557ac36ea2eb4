#include "mechanics/material.hpp"

#include <nlohmann/json.hpp>

#include "core/embedded_models.hpp"
#include "core/error.hpp"

namespace sanatrix::mechanics {

namespace {

using Json = nlohmann::json;

double value(const Json& group, const char* key) {
  return group.at(key).at("value").get<double>();
}

Tissue tissue(const Json& group) {
  Tissue t;
  t.c1 = value(group, "c1");
  t.c2 = value(group, "c2");
  t.kappa = value(group, "kappa");
  t.density = value(group, "density");
  return t;
}

}  // namespace

TissuePreset tissue_preset(const std::string& name) {
  const auto& models = embedded_models();
  const auto found = models.find("tissue/" + name + ".json");
  if (found == models.end()) {
    std::string known;
    for (const auto& [file, text] : models) {
      if (file.starts_with("tissue/")) {
        known += (known.empty() ? "" : ", ") + file.substr(7, file.size() - 12);
      }
    }
    throw Error(Fault::Input, fmt::format("there is no tissue preset '{}'", name),
                "known presets: " + known);
  }
  const Json json = Json::parse(found->second);
  TissuePreset preset{name, tissue(json.at("adipose")), tissue(json.at("fibroglandular")), {}};
  const Json& skin = json.at("skin");
  preset.skin.alpha = value(skin, "alpha");
  preset.skin.beta = value(skin, "beta");
  preset.skin.c2 = value(skin, "c2");
  preset.skin.thickness = value(skin, "thickness");
  preset.skin.density = value(skin, "density");
  return preset;
}

Tissue mix(const Tissue& a, const Tissue& b, double fraction_of_b) {
  const double s = fraction_of_b;
  const auto mean = [s](double x, double y) {
    return (1.0 - s) * x + s * y;
  };
  return {mean(a.c1, b.c1),
          mean(a.c2, b.c2),
          1.0 / mean(1.0 / a.kappa, 1.0 / b.kappa),
          mean(a.density, b.density),
          mean(a.integrity, b.integrity),
          mean(a.active_stress, b.active_stress),
          mean(a.shrinkage, b.shrinkage),
          mean(a.guard, b.guard)};
}

}  // namespace sanatrix::mechanics
