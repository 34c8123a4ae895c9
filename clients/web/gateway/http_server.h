// What browsers connect to: the page, the files of the scene, the metrics, and the handshake of the
// stream, by HTTP/1.1 or HTTPS. Bounded everywhere: connections, viewers, the length of a head, the
// time it takes. One thread. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clients/web/gateway/door.h"
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
  std::vector<std::filesystem::path> assets;  ///< folders
  std::string token;                          ///< for control; empty: nobody may
  bool control = true;                 ///< with the token; else there is only a recording to steer
  std::size_t most_viewers = 64;       ///< a quarter of them have the token
  std::size_t most_connections = 256;  ///< a quarter of them are this machine's
  std::size_t most_of_address = 16;    ///< connections of one address that is not this machine's
  /// Silence after which a viewer without the token gives way to another one; a page says something
  /// each second.
  std::chrono::nanoseconds quiet = std::chrono::seconds{20};
  /// Time from the first byte of a message of a viewer to its last; one that takes longer is
  /// closed.
  std::chrono::nanoseconds message_time = std::chrono::seconds{10};
  std::function<std::string()> metrics;
};

/// What happened so far.
struct ServerCounters {
  std::uint64_t requests = 0;
  std::uint64_t refused_origin = 0;  ///< handshakes
  std::uint64_t refused_full = 0;    ///< handshakes
  std::uint64_t bad_tokens = 0;
  DoorCounters door;  ///< of connections
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
  [[nodiscard]] ServerCounters counters() const;

  /// Options, counters and socket, shared with its connections.
  struct Shared;

 private:
  std::shared_ptr<Shared> shared_;
};

}  // namespace hapticd::web
