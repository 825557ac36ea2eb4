#include "healing/values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/ranges.h>

#include "core/error.hpp"

namespace sanatrix::healing {

Values::Values(std::string preset, std::map<std::string, std::string> text,
               std::span<const std::string> overrides)
    : preset_(std::move(preset)), text_(std::move(text)) {
  for (const std::string& entry : overrides) {
    const auto equals = entry.find('=');
    require(equals != std::string::npos,
            "healing override '{}' has no '=': write key=value, for example D_eta=4e-13", entry);
    const auto found = text_.find(entry.substr(0, equals));
    if (found == text_.end()) {
      std::vector<std::string> keys;
      std::ranges::transform(text_, std::back_inserter(keys),
                             [](const auto& e) { return e.first; });
      throw Error(
          Fault::Input,
          fmt::format("healing preset {} has no value '{}'", preset_, entry.substr(0, equals)),
          fmt::format("known are {}", fmt::join(keys, ", ")));
    }
    found->second = entry.substr(equals + 1);
  }
}

const std::string& Values::read(const std::string& key) {
  const auto found = text_.find(key);
  ensure(found != text_.end(), "healing preset {} lacks the value '{}'", preset_, key);
  read_.insert(key);
  return found->second;
}

double Values::number(const std::string& key, double least, double most) {
  const std::string& text = read(key);
  double value = 0.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  require(fault == std::errc{} && end == text.data() + text.size() && std::isfinite(value),
          "healing preset {}: {} = '{}' is not a number", preset_, key, text);
  require(value >= least && value <= most,
          "healing preset {}: {} = {} is outside its range [{}, {}]", preset_, key, text, least,
          most);
  return value;
}

std::string Values::word(const std::string& key, std::initializer_list<std::string_view> allowed) {
  const std::string& text = read(key);
  require(std::ranges::find(allowed, text) != allowed.end(),
          "healing preset {}: {} = '{}' is not one of {}", preset_, key, text,
          fmt::join(allowed, ", "));
  return text;
}

void Values::expect_all_read() const {
  for (const auto& [key, text] : text_) {
    ensure(read_.contains(key), "healing preset {}: no model reads the value '{}'", preset_, key);
  }
}

}  // namespace sanatrix::healing
