// What browsers connect to: the page, the files of the scene, the metrics, and the handshake of the
// stream, by HTTP/1.1 or HTTPS. Bounded everywhere: connections, viewers, the length of a head, the
// time it takes. One thread. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/web/gateway/hub.h"

namespace boost::asio {
class io_context;  // NOLINT(readability-identifier-naming): Boost's name
}

namespace hapticd::web {

/// What is served, to whom.
struct ServerOptions {
  std::string address = "127.0.0.1";  ///< numeric
  std::uint16_t port = 8080;          ///< 0: the system chooses
  std::filesystem::path certificate;  ///< PEM, with its chain; empty: no TLS
  std::filesystem::path private_key;  ///< PEM
  std::filesystem::path page;         ///< folder
  std::vector<std::string> names;     ///< of this machine, beside its addresses and localhost
  std::string token;                  ///< for control; empty: nobody may
  std::size_t most_viewers = 64;
  std::size_t most_connections = 256;
  /// The file of the scene with this hash; nothing: there is none.
  std::function<std::optional<std::string>(const std::string& hash)> asset;
  std::function<std::string()> metrics;
};

/// What happened so far.
struct ServerCounters {
  std::uint64_t requests = 0;
  std::uint64_t refused_origin = 0;  ///< handshakes
  std::uint64_t refused_full = 0;    ///< handshakes and connections
  std::uint64_t bad_tokens = 0;
};

class HttpServer {
 public:
  /// Binds the address. Throws std::runtime_error with what is wrong and what to do: address in
  /// use, certificate or key that cannot be read.
  HttpServer(boost::asio::io_context& context, ServerOptions options, Hub& hub);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// Begins to accept.
  void start();
  /// Accepts no more.
  void stop();

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const ServerCounters& counters() const;

  /// Options, counters and socket, shared with its connections.
  struct Shared;

 private:
  std::shared_ptr<Shared> shared_;
};

}  // namespace hapticd::web
