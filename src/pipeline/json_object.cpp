#include "pipeline/json_object.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"

namespace sanatrix::pipeline {

using nlohmann::json;

JsonObject::JsonObject(const json& j, std::string where) : json_(j), where_(std::move(where)) {
  require(j.is_object(), "{}: an object {{...}} is needed here",
          where_.empty() ? "the file" : where_);
}

std::string JsonObject::name(const std::string& key) const {
  return where_.empty() ? key : where_ + "." + key;
}

void JsonObject::allow(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, unused] : json_.items()) {
    require(std::ranges::find(keys, key) != keys.end(), "{}: this key is not known; known are: {}",
            name(key), fmt::join(keys, ", "));
  }
}

const json& JsonObject::value(const std::string& key) const {
  require(json_.contains(key), "{}: this key is missing", name(key));
  return json_[key];
}

JsonObject JsonObject::object(const std::string& key) const {
  return {value(key), name(key)};
}

std::string JsonObject::text(const std::string& key) const {
  const json& j = value(key);
  require(j.is_string(), "{}: a text is needed, not {}", name(key), j.dump());
  return j.get<std::string>();
}

std::string JsonObject::choice(const std::string& key,
                               const std::vector<std::string>& choices) const {
  std::string given = text(key);
  require(std::ranges::find(choices, given) != choices.end(), "{}: '{}' is not one of: {}",
          name(key), given, fmt::join(choices, ", "));
  return given;
}

double JsonObject::number(const std::string& key, double min, double max) const {
  const json& j = value(key);
  require(j.is_number(), "{}: a number is needed, not {}", name(key), j.dump());
  const auto x = j.get<double>();
  require(std::isfinite(x) && x >= min && x <= max, "{}: {} is outside {} ... {}", name(key), x,
          min, max);
  return x;
}

double JsonObject::number_or(const std::string& key, double min, double max,
                             double otherwise) const {
  return has(key) ? number(key, min, max) : otherwise;
}

bool JsonObject::flag_or(const std::string& key, bool otherwise) const {
  require(!has(key) || json_[key].is_boolean(), "{}: true or false is needed", name(key));
  return has(key) ? json_[key].get<bool>() : otherwise;
}

std::vector<double> JsonObject::numbers(const std::string& key, std::size_t count) const {
  const json& j = value(key);
  const bool good = j.is_array() && j.size() == count &&
                    std::ranges::all_of(j, [](const json& x) { return x.is_number(); });
  require(good, "{}: a list of {} numbers is needed, not {}", name(key), count, j.dump());
  return j.get<std::vector<double>>();
}

std::vector<std::string> JsonObject::texts(const std::string& key) const {
  const json& j = value(key);
  const bool good =
      j.is_array() && std::ranges::all_of(j, [](const json& x) { return x.is_string(); });
  require(good, "{}: a list of names is needed, not {}", name(key), j.dump());
  return j.get<std::vector<std::string>>();
}

}  // namespace sanatrix::pipeline
