// Strict reading of JSON objects: every refusal names the key and what would be right.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace sanatrix::pipeline {

class JsonObject {
 public:
  /// `where` names the object in messages: "regions.breast". Error{Input} when j is no object.
  JsonObject(const nlohmann::json& j, std::string where);

  /// Error{Input} for any other key, listing the known ones.
  void allow(std::initializer_list<std::string_view> keys) const;
  [[nodiscard]] bool has(const std::string& key) const { return json_.contains(key); }
  [[nodiscard]] const nlohmann::json& value(const std::string& key) const;
  [[nodiscard]] JsonObject object(const std::string& key) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  std::string choice(const std::string& key, const std::vector<std::string>& choices) const;
  /// Finite and within min ... max.
  [[nodiscard]] double number(const std::string& key, double min, double max) const;
  [[nodiscard]] double number_or(const std::string& key, double min, double max,
                                 double otherwise) const;
  [[nodiscard]] bool flag_or(const std::string& key, bool otherwise) const;
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const;
  [[nodiscard]] std::vector<std::string> texts(const std::string& key) const;
  [[nodiscard]] std::string name(const std::string& key) const;  ///< "regions.breast.c1"
  [[nodiscard]] const nlohmann::json& raw() const { return json_; }

 private:
  const nlohmann::json& json_;
  std::string where_;
};

}  // namespace sanatrix::pipeline
