// HTTP as the planner needs it: small requests, streamed uploads, answers from memory or file, and
// server-sent events. Everything that touches the network and its limits is behind this header.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace sanatrix::server {

struct Request {
  std::string method;                          ///< "GET"
  std::string path;                            ///< percent-decoded, without the query
  std::map<std::string, std::string> query;    ///< decoded
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;                            ///< empty when it was streamed to `upload`
  std::filesystem::path upload;                ///< where the body went, when it was streamed

  [[nodiscard]] std::string header(const std::string& name) const;
  [[nodiscard]] std::string parameter(const std::string& name) const;
};

/// Called a few times a second; what it returns is sent as it is (server-sent events).
using Feed = std::function<std::string()>;

struct Response {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::optional<std::filesystem::path> file = {};                 ///< instead of body
  Feed feed = {};                                                 ///< instead of both: never ends
  std::vector<std::pair<std::string, std::string>> headers = {};  ///< in addition
};

/// Figures of UX.md 6.4 rule 5.
struct Limits {
  std::uint32_t header_bytes = 16 * 1024;
  std::uint64_t body_bytes = 1024 * 1024;
  std::uint64_t upload_bytes = 2ULL * 1024 * 1024 * 1024;
  std::size_t connections = 64;
  std::size_t feeds = 16;
  std::chrono::seconds header_time{10}, idle_time{30}, body_time{600}, answer_time{600};
};

/// What the server is asked to do. `answer` may take its time: it runs on a pool of threads.
class Handler {
 public:
  virtual ~Handler() = default;
  /// Looked at before a byte of the body is read; an answer here ends the connection.
  virtual std::optional<Response> refuse(const Request& head) = 0;
  /// Where to stream the body, if not to memory. The file must not exist.
  virtual std::optional<std::filesystem::path> upload_target(const Request& head) = 0;
  /// Never throws.
  virtual Response answer(const Request& request) = 0;
  /// Headers that every answer has.
  virtual std::vector<std::pair<std::string, std::string>> common_headers() const = 0;
};

/// Where to listen.
struct Listen {
  std::string address = "127.0.0.1";       ///< IP; anything but loopback needs TLS
  std::uint16_t port = 0;                  ///< 0: any free one
  std::filesystem::path certificate, key;  ///< PEM; both or neither
  [[nodiscard]] bool secret() const { return !certificate.empty() && !key.empty(); }
};

class HttpServer {
 public:
  /// Error{Resource} when the port is taken; Error{Input} when the certificate cannot be used, or
  /// when there is none and the address is not this machine's own.
  HttpServer(const Listen& where, Handler& handler, Limits limits = {});
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// Serves until asked to stop.
  void run(const std::function<bool()>& stop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Percent-decoding; nothing when the text is not well formed or decodes to a NUL.
std::optional<std::string> percent_decoded(std::string_view text);
/// "/a/b?x=1&y=2" into the path and query of a request; false when it cannot be understood.
bool parse_target(std::string_view target, Request& into);

}  // namespace sanatrix::server
