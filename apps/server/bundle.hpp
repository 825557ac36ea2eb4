// Typed arrays with a JSON head in one answer: the browser reads them without parsing or copying.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "geometry/vec3.hpp"

namespace sanatrix::server {

/// "SNX1", length of the head (u32), the head, then the arrays, each aligned to 8 bytes. The head's
/// "arrays" tells type ("f32", "u32", "u8"), byte offset after the head, and number of values.
class Bundle {
 public:
  nlohmann::json head = nlohmann::json::object();

  void add(const std::string& name, std::span<const float> values);
  void add(const std::string& name, std::span<const std::uint32_t> values);
  void add(const std::string& name, std::span<const std::uint8_t> values);
  /// Positions, from metres to millimetres.
  void add_mm(const std::string& name, std::span<const Vec3> points);
  [[nodiscard]] std::string bytes() const;

 private:
  void append(const std::string& name, const char* type, const void* data, std::size_t count,
              std::size_t size);
  nlohmann::json arrays_ = nlohmann::json::object();
  std::string data_;
};

}  // namespace sanatrix::server
