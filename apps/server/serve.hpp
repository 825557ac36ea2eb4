// The planner's server as the command line starts it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

namespace sanatrix::server {

struct ServeOptions {
  std::filesystem::path cases = "cases";
  std::uint16_t port = 8470;
  bool open = false;  ///< start the browser
};

/// Serves until `stop` says so; `ready` hears the address to open.
void serve(const ServeOptions& options, const std::function<void(const std::string&)>& ready,
           const std::function<bool()>& stop);

}  // namespace sanatrix::server
