// Who may talk to the server: only the browser that was given the start-up address, from this
// machine, and only from our own page (UX.md 6.4; DNS rebinding, cross-site requests).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "http.hpp"

namespace sanatrix::server {

/// How the server is called from outside.
struct Place {
  std::uint16_t port = 0;
  std::string name = "127.0.0.1";  ///< as it stands in the address bar
  bool secret = false;             ///< TLS
  std::string token = {};          ///< lets browsers in; empty: one of our own
};

class Guard {
 public:
  /// The secrets live in a file readable by the user alone, so that open pages survive a restart.
  Guard(Place place, const std::filesystem::path& secrets);

  /// The address to open; the secret in it becomes a cookie and leaves the address bar.
  [[nodiscard]] std::string start_address() const;
  /// Why a request is refused, if it is: 421 foreign host, 403 foreign origin or missing proof, 401
  /// no cookie. Public paths (the page itself, without data) need no cookie.
  [[nodiscard]] std::optional<Response> refuse(const Request& request) const;
  /// The answer to the start-up address.
  [[nodiscard]] Response enter(const Request& request) const;
  /// What a state-changing request must repeat in X-Sanatrix-Proof; told to our page only.
  [[nodiscard]] const std::string& proof() const { return proof_; }
  [[nodiscard]] static std::vector<std::pair<std::string, std::string>> common_headers();

 private:
  [[nodiscard]] bool has_cookie(const Request& request) const;
  [[nodiscard]] bool is_ours(const std::string& host) const;
  Place place_;
  std::string token_, proof_;
};

/// Unguessable text of 128 bits in hexadecimal.
std::string random_name();

}  // namespace sanatrix::server
