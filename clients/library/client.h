// A connection to hapticd over UDP: ClientCore with a socket and the monotonic clock. No thread: it
// lives while poll() or a blocking call runs, and the server drops a session after 10 s of silence.
// One thread per Client. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/library/client_core.h"

namespace hapticd::client {

/// Port hapticd listens on unless told otherwise.
inline constexpr std::uint16_t kDefaultPort = 47800;
/// How long blocking calls wait unless told otherwise. Loading a large scene takes longer.
inline constexpr std::chrono::milliseconds kDefaultTimeout{5000};

/// The own clock of every instant here: CLOCK_MONOTONIC, ns.
[[nodiscard]] std::int64_t monotonic_now_ns();

/// A session with one server, started again whenever the server forgets it.
class Client {
 public:
  /// Opens a socket to `host` (name or address) and `port`; a server need not be there yet. The
  /// handlers are called from inside the functions below. Throws std::runtime_error when the
  /// address cannot be resolved or no socket opened. `key`, from read_client_key(): for a server
  /// with keys.
  explicit Client(const std::string& host = "127.0.0.1", std::uint16_t port = kDefaultPort,
                  ClientHandlers handlers = {}, std::optional<ClientKey> key = std::nullopt);
  /// Says Bye once, without waiting.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends what is due and takes what has arrived. Returns after a datagram came, at the latest
  /// after `wait`.
  void poll(std::chrono::nanoseconds wait = std::chrono::milliseconds(10));
  /// Polls until `done()` is true, `timeout` at most; whether it is.
  template <typename Done>
  bool poll_until(const Done& done, std::chrono::nanoseconds timeout = kDefaultTimeout) {
    const std::int64_t end_ns = monotonic_now_ns() + timeout.count();
    while (!done()) {
      if (monotonic_now_ns() >= end_ns) return false;
      poll();
    }
    return true;
  }

  /// Until the server has sent SceneInfo; false: it has not within `timeout`.
  bool connect(std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// Sends a request and awaits its Result. code() is RESULT_CODE_UNSPECIFIED when none came: the
  /// message says whether time ran out or the session ended.
  v1::Result call(const v1::Item& request, std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// Sends a request; `done` is called with its Result, or with null when the session ended. Its
  /// id, or 0 if the session is ending.
  std::uint64_t request(const v1::Item& request, ResultHandler done = {});
  /// Asks for the State of every divisor-th tick.
  v1::Result subscribe(std::uint32_t divisor, const std::vector<v1::Section>& sections = {});
  /// Ends the session and waits until the server knows, 1 s at most.
  void leave();

  /// The newest State; empty before the first.
  [[nodiscard]] const std::optional<v1::State>& state() const noexcept { return state_; }
  /// The scene being played; empty before the server has sent it.
  [[nodiscard]] const std::optional<v1::SceneInfo>& scene() const noexcept { return scene_; }
  /// Who controls.
  [[nodiscard]] const v1::LeaseInfo& lease() const noexcept { return lease_; }
  /// The server's clock: t_ns of its events minus the offset at now is this side's clock.
  [[nodiscard]] const wire::ClockEstimate& clock() const noexcept { return core_->clock(); }
  /// The protocol below.
  [[nodiscard]] const ClientCore& core() const noexcept { return *core_; }
  /// Where the server is meant to be, as given.
  [[nodiscard]] const std::string& server() const noexcept { return server_; }

 private:
  ClientHandlers wrapped(ClientHandlers handlers);

  std::string server_;
  int socket_ = -1;
  std::optional<v1::State> state_;
  std::optional<v1::SceneInfo> scene_;
  v1::LeaseInfo lease_;
  std::unique_ptr<ClientCore> core_;
};

}  // namespace hapticd::client
