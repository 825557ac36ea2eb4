// Request targets: percent-decoding, path and query.
#include "http.hpp"

namespace sanatrix::server {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') {
    return c - '0';
  }
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

std::string found(const std::map<std::string, std::string>& in, const std::string& name) {
  const auto at = in.find(name);
  return at == in.end() ? std::string() : at->second;
}

}  // namespace

std::string Request::header(const std::string& name) const {
  return found(headers, name);
}

std::string Request::parameter(const std::string& name) const {
  return found(query, name);
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) {
        return std::nullopt;
      }
      const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
      if (high < 0 || low < 0) {
        return std::nullopt;
      }
      c = static_cast<char>(high * 16 + low);
      i += 2;
    }
    if (c == '\0') {
      return std::nullopt;
    }
    plain += c;
  }
  return plain;
}

bool parse_target(std::string_view target, Request& into) {
  const std::size_t mark = std::min(target.find('?'), target.size());
  const auto path = percent_decoded(target.substr(0, mark));
  if (!path || path->empty() || path->front() != '/') {
    return false;
  }
  into.path = *path;
  std::string_view rest = mark < target.size() ? target.substr(mark + 1) : std::string_view();
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view pair = rest.substr(0, end);
    rest = end < rest.size() ? rest.substr(end + 1) : std::string_view();
    const std::size_t equals = std::min(pair.find('='), pair.size());
    const auto name = percent_decoded(pair.substr(0, equals));
    const auto value =
        percent_decoded(equals < pair.size() ? pair.substr(equals + 1) : std::string_view());
    if (!name || !value) {
      return false;
    }
    into.query[*name] = *value;
  }
  return true;
}

}  // namespace sanatrix::server
