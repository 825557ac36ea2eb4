// The page and its scripts, compiled into the program: no path of an address ever reaches a disk.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sanatrix::server {

/// "/index.html", "/assets/index.js"; nothing for unknown names.
std::optional<std::string_view> client_file(const std::string& name);

}  // namespace sanatrix::server
