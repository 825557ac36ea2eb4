#include "bundle.hpp"

#include <cstring>
#include <vector>

namespace sanatrix::server {
namespace {

constexpr std::size_t alignment = 8;

void pad(std::string& text, char with) {
  text.append((alignment - text.size() % alignment) % alignment, with);
}

}  // namespace

void Bundle::append(const std::string& name, const char* type, const void* data, std::size_t count,
                    std::size_t size) {
  pad(data_, '\0');
  arrays_[name] = {{"type", type}, {"offset", data_.size()}, {"count", count}};
  data_.append(static_cast<const char*>(data), count * size);
}

void Bundle::add(const std::string& name, std::span<const float> values) {
  append(name, "f32", values.data(), values.size(), sizeof(float));
}

void Bundle::add(const std::string& name, std::span<const std::uint32_t> values) {
  append(name, "u32", values.data(), values.size(), sizeof(std::uint32_t));
}

void Bundle::add(const std::string& name, std::span<const std::uint8_t> values) {
  append(name, "u8", values.data(), values.size(), 1);
}

void Bundle::add_mm(const std::string& name, std::span<const Vec3> points) {
  std::vector<float> flat;
  flat.reserve(points.size() * 3);
  for (const Vec3& p : points) {
    for (const double x : p) {
      flat.push_back(static_cast<float>(1e3 * x));
    }
  }
  add(name, flat);
}

std::string Bundle::bytes() const {
  nlohmann::json complete = head;
  complete["arrays"] = arrays_;
  std::string text = complete.dump();
  pad(text, ' ');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string all = "SNX1";
  all.append(reinterpret_cast<const char*>(&length), sizeof(length));
  return all + text + data_;
}

}  // namespace sanatrix::server
