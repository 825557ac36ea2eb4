#include "guard.hpp"

#include <array>
#include <fstream>

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <sys/stat.h>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::server {
namespace {

constexpr std::size_t name_length = 32;

Response refusal(int status, const std::string& what, const std::string& hint) {
  return {.status = status,
          .body = fmt::format(R"({{"fault":"refused","what":"{}","hint":"{}"}})", what, hint)};
}

bool equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool is_secret(const std::string& text) {
  return text.size() == name_length &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

std::string random_name() {
  std::array<unsigned char, name_length / 2> bytes{};
  ensure(RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) == 1, "no random numbers");
  std::string text;
  for (const unsigned char byte : bytes) {
    text += fmt::format("{:02x}", byte);
  }
  return text;
}

Guard::Guard(Place place, const std::filesystem::path& secrets) : place_(std::move(place)) {
  std::ifstream(secrets) >> token_ >> proof_;
  if (!is_secret(token_) || !is_secret(proof_)) {
    token_ = random_name();
    proof_ = random_name();
    const mode_t old = ::umask(0077);
    write_text(secrets, token_ + "\n" + proof_ + "\n");
    ::umask(old);
  }
  token_ = place_.token.empty() ? token_ : place_.token;
}

bool Guard::is_ours(const std::string& host) const {
  const std::string port = fmt::format(":{}", place_.port);
  const std::string name = place_.name.find(':') == std::string::npos
                               ? place_.name
                               : fmt::format("[{}]", place_.name);  // IPv6
  const bool at_home = name == "127.0.0.1" || name == "[::1]";
  // A browser leaves out the scheme's own port.
  return host == name + port || (place_.secret && place_.port == 443 && host == name) ||
         (at_home && (host == "localhost" + port || host == "127.0.0.1" + port));
}

std::string Guard::start_address() const {
  return fmt::format(
      "{}://{}:{}/start?key={}", place_.secret ? "https" : "http",
      place_.name.find(':') == std::string::npos ? place_.name : fmt::format("[{}]", place_.name),
      place_.port, token_);
}

bool Guard::has_cookie(const Request& request) const {
  // Cookies do not know ports; the name keeps two servers of one user apart.
  const std::string name = fmt::format("sanatrix_{}=", place_.port);
  const std::string cookies = request.header("cookie");
  for (std::size_t at = cookies.find(name); at != std::string::npos;
       at = cookies.find(name, at + 1)) {
    if (equal(cookies.substr(at + name.size(), token_.size()), token_)) {
      return true;
    }
  }
  return false;
}

std::optional<Response> Guard::refuse(const Request& request) const {
  if (!is_ours(request.header("host"))) {
    return refusal(421, "this server does not answer to that host name",
                   "open the address that sanatrix serve printed");
  }
  const std::string origin = request.header("origin"), site = request.header("sec-fetch-site");
  const std::string scheme = place_.secret ? "https://" : "http://";
  const bool foreign =
      (!origin.empty() && !(origin.starts_with(scheme) && is_ours(origin.substr(scheme.size())))) ||
      (!site.empty() && site != "same-origin" && site != "none");
  if (foreign && request.path != "/start") {
    return refusal(403, "this request comes from another site", "use the planner's own page");
  }
  if (request.path != "/" && !request.path.starts_with("/api/")) {
    return std::nullopt;  // the page's own files hold no data
  }
  if (request.path.starts_with("/api/") && !has_cookie(request)) {
    return refusal(401, "this browser has not been let in",
                   "open the address that sanatrix serve printed; it holds the key");
  }
  if (request.method != "GET" && !equal(request.header("x-sanatrix-proof"), proof_)) {
    return refusal(403, "this change does not come from the planner's page", "reload the page");
  }
  return std::nullopt;
}

Response Guard::enter(const Request& request) const {
  if (!equal(request.parameter("key"), token_)) {
    return refusal(401, "this key is not valid", "open the address that sanatrix serve printed");
  }
  return {.status = 303,
          .type = "text/plain",
          .body = "",
          .headers = {
              {"Location", "/"},
              {"Set-Cookie", fmt::format("sanatrix_{}={}; Path=/; HttpOnly; SameSite=Strict{}",
                                         place_.port, token_, place_.secret ? "; Secure" : "")}}};
}

std::vector<std::pair<std::string, std::string>> Guard::common_headers() {
  return {{"Content-Security-Policy",
           "default-src 'self'; object-src 'none'; frame-ancestors 'none'; base-uri 'none'; "
           "form-action 'none'"},
          {"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cross-Origin-Embedder-Policy", "require-corp"},
          {"Cache-Control", "no-store"}};
}

}  // namespace sanatrix::server
