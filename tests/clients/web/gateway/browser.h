// What a browser does, by Boost.Beast's client side over a real socket: a WebSocket at /stream, and
// single HTTP requests. Blocking, with deadlines.
#pragma once

#include <doctest/doctest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "hapticd/v1/gateway.pb.h"

namespace hapticd::test {

/// Longest wait for anything: far more than it takes, so that only what never comes fails.
inline constexpr std::chrono::seconds kDeadline{20};

/// One page.
class Browser {
 public:
  /// Connects and shakes hands; status() tells what came of it.
  explicit Browser(std::uint16_t port, const std::string& subprotocol = "hapticd.v1",
                   const std::string& origin = "") {
    namespace websocket = boost::beast::websocket;
    const std::string host = "127.0.0.1:" + std::to_string(port);
    socket_.next_layer().connect(
        {boost::asio::ip::make_address("127.0.0.1"), static_cast<std::uint16_t>(port)});
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(boost::beast::http::field::sec_websocket_protocol, subprotocol);
      request.set(boost::beast::http::field::origin, origin.empty() ? "http://" + host : origin);
    }));
    socket_.binary(true);
    websocket::response_type response;
    boost::system::error_code error;
    socket_.handshake(response, host, "/stream", error);
    status_ = error ? refusal(port, host, subprotocol, origin) : response.result_int();
    protocol_ = std::string(response[boost::beast::http::field::sec_websocket_protocol]);
  }

  [[nodiscard]] unsigned status() const { return status_; }
  [[nodiscard]] const std::string& protocol() const { return protocol_; }

  /// The next event; fails the test when none comes in time, or the gateway closes.
  v1::PageEvent next() {
    v1::PageEvent event;
    REQUIRE(read(event));
    return event;
  }
  /// The first event that is wanted; what comes before it is left out.
  v1::PageEvent wait_for(const std::function<bool(const v1::PageEvent&)>& wanted) {
    const auto end = std::chrono::steady_clock::now() + kDeadline;
    while (std::chrono::steady_clock::now() < end) {
      v1::PageEvent event = next();
      if (wanted(event)) return event;
    }
    FAIL("it never came");
    return {};
  }
  /// Its words, after close_code().
  [[nodiscard]] std::string close_words() const {
    return {socket_.reason().reason.data(), socket_.reason().reason.size()};
  }
  /// Code of the goodbye, after whatever else still comes; 0: it broke off without one.
  unsigned close_code() {
    v1::PageEvent event;
    while (read(event)) {
    }
    return socket_.reason().code;
  }
  void send(const v1::PageRequest& request) {
    socket_.write(boost::asio::buffer(request.SerializeAsString()));
  }
  void send_bytes(const std::string& bytes) { socket_.write(boost::asio::buffer(bytes)); }
  /// Asks the daemon, and gives its answer.
  v1::Result call(const v1::Item& item) {
    v1::PageRequest request;
    *request.mutable_call() = item;
    return ask(request);
  }
  /// Asks gateway or daemon, and gives the answer; what comes before it is left out.
  v1::Result ask(v1::PageRequest request) {
    request.set_id(++id_);
    send(request);
    return wait_for([&](const v1::PageEvent& event) {
             return event.has_result() && event.result().item_id() == id_;
           })
        .result();
  }

 private:
  /// What a handshake that was refused is answered: Boost.Beast's client tells only that it was.
  static unsigned refusal(std::uint16_t port, const std::string& host,
                          const std::string& subprotocol, const std::string& origin) {
    namespace http = boost::beast::http;
    boost::asio::io_context context;
    boost::asio::ip::tcp::socket socket(context);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"), port});
    http::request<http::empty_body> request(http::verb::get, "/stream", 11);
    request.set(http::field::host, host);
    request.set(http::field::connection, "Upgrade");
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::sec_websocket_version, "13");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    request.set(http::field::sec_websocket_protocol, subprotocol);
    request.set(http::field::origin, origin.empty() ? "http://" + host : origin);
    http::write(socket, request);
    boost::beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    http::read_header(socket, buffer, parser);
    return parser.get().result_int();
  }

  bool read(v1::PageEvent& event) {
    boost::beast::flat_buffer buffer;
    boost::system::error_code result = boost::asio::error::would_block;
    socket_.async_read(
        buffer, [&](const boost::system::error_code& error, std::size_t) { result = error; });
    context_.restart();
    context_.run_for(kDeadline);
    if (result == boost::asio::error::would_block) {
      socket_.next_layer().close();
      context_.restart();
      context_.run();
    }
    if (result) return false;
    const auto bytes = buffer.cdata();
    REQUIRE(event.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
    return true;
  }

  boost::asio::io_context context_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> socket_{context_};
  unsigned status_ = 0;
  std::string protocol_;
  std::uint64_t id_ = 0;
};

using HttpResponse = boost::beast::http::response<boost::beast::http::string_body>;

/// One request, one answer.
inline HttpResponse fetch(std::uint16_t port, const std::string& target,
                          const std::string& host = "127.0.0.1",
                          boost::beast::http::verb verb = boost::beast::http::verb::get,
                          const std::map<std::string, std::string>& heads = {}) {
  namespace http = boost::beast::http;
  boost::asio::io_context context;
  boost::asio::ip::tcp::socket socket(context);
  socket.connect({boost::asio::ip::make_address("127.0.0.1"), port});
  http::request<http::empty_body> request(verb, target, 11);
  request.set(http::field::host, host);
  request.set(http::field::connection, "close");
  for (const auto& [name, value] : heads) request.set(name, value);
  http::write(socket, request);
  boost::beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(1U << 30U);
  parser.skip(verb == http::verb::head);
  http::read(socket, buffer, parser);
  return parser.release();
}

}  // namespace hapticd::test
