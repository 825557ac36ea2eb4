// The only file that sees Boost.Beast: one thread of asynchronous connections, a pool for answers.
#include "http.hpp"

#include <array>
#include <list>

// Boost 1.74's awaitable uses std::exchange without including it.
#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>

#include "channel.hpp"
#include "core/error.hpp"
#include "sink.hpp"

namespace sanatrix::server {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = net::ip::tcp;
using boost::system::error_code;
using namespace std::chrono_literals;

constexpr std::size_t pool_threads = 4;
constexpr auto feed_pause = 250ms;
constexpr auto feed_heartbeat = 15s;

/// One connection; those that wait for a request may be closed to make room.
struct Connection {
  Connection(tcp::socket socket, net::ssl::context* tls) : stream(std::move(socket), tls) {}
  Channel stream;
  beast::flat_buffer buffer;
  bool waiting = true;
  bool fresh = true;  ///< has not had a request yet
};

auto with_error(error_code& ec) {
  return net::redirect_error(net::use_awaitable, ec);
}

Response plain(int status, std::string sentence) {
  return {.status = status, .type = "text/plain; charset=utf-8", .body = std::move(sentence)};
}

using Parser = http::request_parser<http::buffer_body>;

std::optional<Request> head_of(const Parser& parser) {
  const auto& message = parser.get();
  Request request;
  request.method = std::string(message.method_string());
  for (const auto& field : message) {
    std::string name(field.name_string());
    for (char& c : name) {
      c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if (name == "host" && request.headers.contains(name)) {
      return std::nullopt;  // two hosts: somebody wants to confuse a guard
    }
    request.headers[name] = std::string(field.value());
  }
  const auto target = message.target();
  if (!parse_target({target.data(), target.size()}, request)) {
    return std::nullopt;
  }
  return request;
}

}  // namespace

struct HttpServer::Impl {
  Handler& handler;
  Limits limits;
  net::io_context io{1};
  net::thread_pool pool{pool_threads};
  tcp::acceptor acceptor{io};
  std::list<std::shared_ptr<Connection>> connections;  // oldest first; only the io thread looks
  std::size_t feeds = 0;
  std::optional<net::ssl::context> tls;

  Impl(Handler& h, Limits l) : handler(h), limits(l) {}

  void listen(const Listen& where) {
    error_code ec;
    const auto address = net::ip::make_address(where.address, ec);
    require(!ec, "--address {} is not an IP address", where.address);
    require(address.is_loopback() || where.secret(),
            "the planner is offered beyond this machine only with a certificate and a key");
    if (where.secret()) {
      use_certificate(where);
    }
    const tcp::endpoint here(address, where.port);
    acceptor.open(here.protocol());
    acceptor.set_option(net::socket_base::reuse_address(true));
    acceptor.bind(here, ec);
    if (ec) {
      throw Error(
          Fault::Resource,
          fmt::format("port {} of {} cannot be used: {}", where.port, where.address, ec.message()),
          "give another one with --port, or --port 0 for any free one");
    }
    acceptor.listen(256);
  }

  void use_certificate(const Listen& where) {
    tls.emplace(net::ssl::context::tls_server);
    // TLS 1.2 and later; Debian's OpenSSL leaves out what is weak.
    tls->set_options(net::ssl::context::default_workarounds | net::ssl::context::no_tlsv1 |
                     net::ssl::context::no_tlsv1_1);
    error_code ec;
    tls->use_certificate_chain_file(where.certificate.string(), ec);
    require(!ec, "the file of --certificate is not a certificate in PEM form: {}", ec.message());
    tls->use_private_key_file(where.key.string(), net::ssl::context::pem, ec);
    require(!ec, "the file of --key is not the certificate's private key in PEM form: {}",
            ec.message());
  }

  net::awaitable<void> accept() {
    for (;;) {
      error_code ec;
      tcp::socket socket = co_await acceptor.async_accept(with_error(ec));
      if (ec == net::error::operation_aborted) {
        co_return;
      }
      if (ec) {  // out of descriptors: wait for some to close
        net::steady_timer pause(io, 100ms);
        co_await pause.async_wait(with_error(ec));
        continue;
      }
      if (connections.size() >= limits.connections && !make_room()) {
        socket.close(ec);
        continue;
      }
      socket.set_option(tcp::no_delay(true), ec);
      const auto connection =
          std::make_shared<Connection>(std::move(socket), tls ? &*tls : nullptr);
      connections.push_back(connection);
      net::co_spawn(
          io, [this, connection] { return serve(connection); },
          [this, connection](const std::exception_ptr&) { connections.remove(connection); });
    }
  }

  /// Closes the connection that has been waiting for a request for the longest time.
  bool make_room() {
    for (auto at = connections.begin(); at != connections.end(); ++at) {
      if ((*at)->waiting) {
        (*at)->stream.tcp().close();
        connections.erase(at);
        return true;
      }
    }
    return false;
  }

  net::awaitable<void> serve(std::shared_ptr<Connection> c) {
    bool goes_on = true;
    if (c->stream.is_secret()) {
      error_code ec;
      c->stream.tcp().expires_after(limits.header_time);
      co_await c->stream.async_handshake(with_error(ec));
      goes_on = !ec;
    }
    while (goes_on) {
      goes_on = co_await serve_one(*c);
      c->fresh = false;
    }
    error_code ec;
    c->stream.tcp().socket().shutdown(tcp::socket::shutdown_send, ec);
    // Reading what is left for a moment keeps the answer from being lost in a reset.
    c->stream.tcp().expires_after(1s);
    std::array<char, 4096> rest{};
    for (int i = 0; i < 64 && !ec; ++i) {
      co_await c->stream.tcp().async_read_some(net::buffer(rest), with_error(ec));
    }
    c->stream.tcp().close();
  }

  /// One request and its answer; true when the connection can be used again.
  net::awaitable<bool> serve_one(Connection& c) {
    Parser parser;
    parser.header_limit(limits.header_bytes);
    parser.body_limit(limits.upload_bytes);
    error_code ec;
    c.stream.tcp().expires_after(c.fresh ? limits.header_time : limits.idle_time);
    c.waiting = true;
    co_await http::async_read_header(c.stream, c.buffer, parser, with_error(ec));
    c.waiting = false;
    if (ec == http::error::header_limit) {
      co_return co_await send(c, plain(431, "The request's header is too large.\n"), false);
    }
    if (ec == http::error::body_limit) {
      co_return co_await send(c, plain(413, "The request is too large.\n"), false);
    }
    if (ec.category() == http::make_error_code(http::error::bad_method).category() &&
        ec != http::error::end_of_stream && ec != http::error::partial_message) {
      co_return co_await send(c, plain(400, "This is not an HTTP request.\n"), false);
    }
    if (ec) {
      co_return false;
    }
    std::optional<Request> request = head_of(parser);
    if (!request) {
      co_return co_await send(c, plain(400, "The address cannot be understood.\n"), false);
    }
    if (auto refusal = handler.refuse(*request)) {
      co_return co_await send(c, std::move(*refusal), false);
    }
    auto problem = co_await read_body(c, parser, *request);
    if (problem) {
      co_return co_await send(c, std::move(*problem), false);
    }
    Response response = co_await answer(*request);
    if (response.feed) {
      co_await stream_feed(c, response);
      co_return false;
    }
    co_return co_await send(c, std::move(response), parser.get().keep_alive());
  }

  net::awaitable<std::optional<Response>> read_body(Connection& c, Parser& parser,
                                                    Request& request) {
    const auto target = handler.upload_target(request);
    const std::uint64_t limit = target ? limits.upload_bytes : limits.body_bytes;
    const auto too_large = [&] {
      return plain(413, fmt::format("The request is larger than {} MB.\n", limit >> 20U));
    };
    if (parser.content_length() && *parser.content_length() > limit) {
      co_return too_large();
    }
    Sink sink(target, request.body);
    error_code ec;
    c.stream.tcp().expires_after(limits.body_time);
    if (request.header("expect") == "100-continue") {
      static const std::string go_on = "HTTP/1.1 100 Continue\r\n\r\n";
      co_await net::async_write(c.stream, net::buffer(go_on), with_error(ec));
    }
    std::uint64_t received = 0;
    std::vector<char> piece(64 * 1024);
    while (!parser.is_done() && !sink.failed()) {
      parser.get().body().data = piece.data();
      parser.get().body().size = piece.size();
      co_await http::async_read_some(c.stream, c.buffer, parser, with_error(ec));
      if (ec && ec != http::error::need_buffer) {
        co_return ec == http::error::body_limit ? too_large()
                                                : plain(400, "The request ended too early.\n");
      }
      const std::size_t size = piece.size() - parser.get().body().size;
      received += size;
      if (received > limit) {
        co_return too_large();
      }
      sink.add(piece.data(), size);
    }
    if (sink.failed()) {
      co_return plain(507, "The file cannot be stored: check the free disk space.\n");
    }
    if (target) {
      request.upload = *target;
    }
    co_return std::nullopt;
  }

  net::awaitable<Response> compute(const Request* request) { co_return handler.answer(*request); }
  net::awaitable<Response> answer(const Request& request) {
    co_return co_await net::co_spawn(pool, compute(&request), net::use_awaitable);
  }

  template <class Message>
  void fill_header(Message& message, const Response& response, bool keep_alive) {
    message.version(11);
    message.result(static_cast<unsigned>(response.status));
    message.keep_alive(keep_alive);
    message.set(http::field::content_type, response.type);
    for (const auto& headers : {handler.common_headers(), response.headers}) {
      for (const auto& [name, value] : headers) {
        message.set(name, value);
      }
    }
  }

  net::awaitable<bool> send(Connection& c, Response response, bool keep_alive) {
    error_code ec;
    c.stream.tcp().expires_after(limits.answer_time);
    if (response.file) {
      http::response<http::file_body> message;
      message.body().open(response.file->c_str(), beast::file_mode::scan, ec);
      if (!ec) {
        fill_header(message, response, keep_alive);
        message.prepare_payload();
        co_await http::async_write(c.stream, message, with_error(ec));
        co_return !ec && keep_alive;
      }
      response = plain(404, "This file is not there any more.\n");
    }
    http::response<http::string_body> message;
    fill_header(message, response, keep_alive);
    message.body() = std::move(response.body);
    message.prepare_payload();
    co_await http::async_write(c.stream, message, with_error(ec));
    co_return !ec && keep_alive;
  }

  net::awaitable<void> stream_feed(Connection& c, const Response& response) {
    if (feeds >= limits.feeds) {
      co_await send(c, plain(503, "Too many pages are open.\n"), false);
      co_return;
    }
    ++feeds;
    http::response<http::empty_body> head;
    fill_header(head, response, false);
    head.set(http::field::content_type, "text/event-stream");
    http::response_serializer<http::empty_body> serializer(head);
    error_code ec;
    c.stream.tcp().expires_after(limits.idle_time);
    co_await http::async_write_header(c.stream, serializer, with_error(ec));
    auto last = std::chrono::steady_clock::now();
    net::steady_timer timer(io);
    while (!ec) {
      std::string text = response.feed();
      const auto now = std::chrono::steady_clock::now();
      if (text.empty() && now - last >= feed_heartbeat) {
        text = ": still here\n\n";
      }
      if (!text.empty()) {
        last = now;
        c.stream.tcp().expires_after(limits.idle_time);
        co_await net::async_write(c.stream, net::buffer(text), with_error(ec));
      }
      if (!ec) {
        timer.expires_after(feed_pause);
        co_await timer.async_wait(with_error(ec));
      }
    }
    --feeds;
  }

  net::awaitable<void> watch(const std::function<bool()>& stop) {
    net::steady_timer timer(io);
    while (!stop()) {
      error_code ec;
      timer.expires_after(100ms);
      co_await timer.async_wait(with_error(ec));
    }
    io.stop();
  }
};

HttpServer::HttpServer(const Listen& where, Handler& handler, Limits limits)
    : impl_(std::make_unique<Impl>(handler, limits)) {
  impl_->listen(where);
}

HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const {
  return impl_->acceptor.local_endpoint().port();
}

void HttpServer::run(const std::function<bool()>& stop) {
  net::co_spawn(impl_->io, impl_->accept(), net::detached);
  net::co_spawn(impl_->io, impl_->watch(stop), net::detached);
  impl_->io.run();
  impl_->pool.join();
}

}  // namespace sanatrix::server
