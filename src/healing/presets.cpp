// The built-in parameter sets, and the one list of models they can name.
#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/embedded_models.hpp"
#include "core/error.hpp"
#include "healing/adapter.hpp"
#include "healing/five_species.hpp"
#include "healing/model.hpp"
#include "healing/values.hpp"

namespace sanatrix::healing {
namespace {

const std::string folder = "healing/";
const std::string ending = ".json";

using Make = std::function<std::unique_ptr<Model>(std::string name, std::string citation, Values&)>;

template <class M>
Make maker() {
  return [](std::string name, std::string citation, Values& values) {
    return adapt(std::move(name), std::move(citation), M::from(values));
  };
}

/// "model" of a preset's file -> the struct with its equations. A new model adds one line.
const std::map<std::string, Make>& registry() {
  static const std::map<std::string, Make> models{
      {"five_species", maker<FiveSpecies>()},
  };
  return models;
}

/// A preset's file with the entries of the one it is based on filled in.
nlohmann::json resolved(const std::string& preset) {
  const auto& files = embedded_models();
  const auto file = files.find(folder + preset + ending);
  if (file == files.end()) {
    throw Error(Fault::Input, fmt::format("there is no healing preset '{}'", preset),
                fmt::format("known are {}", fmt::join(preset_names(), ", ")));
  }
  auto own = nlohmann::json::parse(file->second);
  if (!own.contains("based_on")) {
    return own;
  }
  auto merged = resolved(own.at("based_on").get<std::string>());
  merged.merge_patch(own);
  return merged;
}

std::map<std::string, std::string> texts(const nlohmann::json& values) {
  std::map<std::string, std::string> result;
  for (const auto& [key, entry] : values.items()) {
    const auto& value = entry.at("value");
    result[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return result;
}

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const auto& [path, text] : embedded_models()) {
    if (path.starts_with(folder)) {
      names.push_back(path.substr(folder.size(), path.size() - folder.size() - ending.size()));
    }
  }
  return names;
}

std::unique_ptr<Model> make_model(const std::string& preset,
                                  std::span<const std::string> overrides) {
  const auto file = resolved(preset);
  Values values(preset, texts(file.at("values")), overrides);
  auto model = registry().at(file.at("model").get<std::string>())(
      preset, file.at("citation").get<std::string>(), values);
  values.expect_all_read();
  model->check_steady_state();
  return model;
}

}  // namespace sanatrix::healing
