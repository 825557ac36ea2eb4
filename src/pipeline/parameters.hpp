// Everything a user may set on a case. One table serves validation, help and fingerprints.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace sanatrix::pipeline {

enum class Kind { Number, Integer, Choice, Text };

struct ParameterInfo {
  std::string key;  ///< "mesh.target_vertices"; the part before the dot says who reads it
  Kind kind;
  std::string standard;              ///< default value; empty: as the preset or the plan says
  double min = 0.0, max = 0.0;       ///< of numbers
  std::string unit;                  ///< of numbers, may be empty
  std::vector<std::string> choices;  ///< of choices
  std::string doc;
};
const std::vector<ParameterInfo>& parameter_table();

/// The values given for one case; all others have their default.
class Parameters {
 public:
  /// "key=value". Error{Usage} for an unknown key (naming near or all keys), Error{Input} for a
  /// value outside its range. An empty value returns to the default.
  void set(const std::string& assignment);
  void set(const std::string& key, const std::string& value);
  /// Forgets all values whose key starts with this.
  void reset(const std::string& prefix);

  /// Error naming what is wrong with values that only make sense together (model overrides).
  void check() const;

  /// The value in use; empty when neither given nor defaulted.
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;
  [[nodiscard]] int integer(const std::string& key) const;
  [[nodiscard]] bool has(const std::string& key) const { return !text(key).empty(); }
  /// Comma-separated text as a list.
  [[nodiscard]] std::vector<std::string> list(const std::string& key) const;
  [[nodiscard]] const std::map<std::string, std::string>& given() const { return given_; }

 private:
  std::map<std::string, std::string> given_;
};

}  // namespace sanatrix::pipeline
