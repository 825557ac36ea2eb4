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
  /// IP address to listen on. Another one than loopback needs all of the following.
  std::string address = "127.0.0.1";
  std::filesystem::path certificate, key;  ///< PEM files for TLS
  std::filesystem::path token;             ///< file with the secret that lets browsers in
  std::string host;                        ///< name in the address bar; default: the address
};

/// Error{Usage} when another address than loopback is asked for without certificate, key and token.
/// Serves until `stop` says so; `ready` hears the address to open.
void serve(const ServeOptions& options, const std::function<void(const std::string&)>& ready,
           const std::function<bool()>& stop);

}  // namespace sanatrix::server
