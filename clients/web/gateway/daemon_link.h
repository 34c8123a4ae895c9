// The gateway's session with one daemon, inside an io_context: ClientCore of the client library
// with a socket whose errors are listened to, since they distinguish a missing daemon from a
// missing route. It opens another socket when nothing comes for long, so that it finds a daemon
// whose address changed, or its own. One thread. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "clients/library/client_core.h"
#include "clients/web/gateway/link_meter.h"
#include "clients/web/gateway/link_verdict.h"

namespace boost::asio {
class io_context;  // NOLINT(readability-identifier-naming): Boost's name
}

namespace hapticd::web {

/// Where the daemon is, and what to ask of it.
struct LinkOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 47800;
  std::optional<client::ClientKey> key;
  double state_rate_hz = 250.0;
};

/// What comes from it.
struct LinkHandlers {
  std::function<void(const v1::State&)> state;
  std::function<void(const v1::Item&)> item;
  std::function<void()> ended;  ///< a session ended; another begins by itself
};

class DaemonLink {
 public:
  DaemonLink(boost::asio::io_context& context, LinkOptions options, LinkHandlers handlers);
  ~DaemonLink();
  DaemonLink(const DaemonLink&) = delete;
  DaemonLink& operator=(const DaemonLink&) = delete;

  /// Opens the socket and asks for States.
  void start();
  /// Says Bye and sends no more.
  void stop();
  /// Sends a request while the daemon is there; `done` is called with its Result, or null.
  bool request(const v1::Item& item, client::ResultHandler done);

  /// Its state.
  [[nodiscard]] LinkVerdict verdict() const;
  /// The same with all its numbers; restarts the counts of loss and bytes, so call it once a
  /// second.
  [[nodiscard]] v1::PageLink report();
  /// The daemon's clock now, ns; 0 = not known.
  [[nodiscard]] std::int64_t daemon_now_ns() const;
  /// Bytes that came so far.
  [[nodiscard]] std::uint64_t received_bytes() const;
  /// Sessions that ended so far.
  [[nodiscard]] std::uint64_t sessions_ended() const;

 private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace hapticd::web
