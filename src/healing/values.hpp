// The numbers and words of one preset after the user's overrides, read by key with their range.
#pragma once

#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace sanatrix::healing {

class Values {
 public:
  /// text: key -> value as written. Overrides are "key=value"; Error{Input} when a key is unknown.
  Values(std::string preset, std::map<std::string, std::string> text,
         std::span<const std::string> overrides);

  /// Error{Input} naming key, value and range when outside [least, most] or not a number.
  double number(const std::string& key, double least,
                double most = std::numeric_limits<double>::max());
  double positive(const std::string& key) {
    return number(key, std::numeric_limits<double>::min());
  }
  /// One of the allowed words.
  std::string word(const std::string& key, std::initializer_list<std::string_view> allowed);
  /// Call after the last read: an entry that nobody read is a defect of the preset's file.
  void expect_all_read() const;

 private:
  const std::string& read(const std::string& key);

  std::string preset_;
  std::map<std::string, std::string> text_;
  std::set<std::string> read_;
};

}  // namespace sanatrix::healing
