// A connection to an MQTT broker, made again by itself when it breaks. libmosquitto behind it, with
// a separate thread. Not RT.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "clients/relay/relay.h"

namespace hapticd::relay {

/// Where the broker is, and who asks.
struct BrokerOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 1883;
  std::string user;                    ///< empty: no user
  std::string password;                ///< of the user
  std::filesystem::path certificates;  ///< that vouch for the broker, PEM; empty: no TLS
  Publication will;                    ///< what the broker says when this connection breaks
};

/// What is wrong with what all topics begin with; nothing: a broker takes it.
[[nodiscard]] std::string prefix_problem(const std::string& prefix);

class Broker {
 public:
  /// Begins to connect; the broker need not be there. Throws std::runtime_error for options that
  /// make no sense.
  explicit Broker(const BrokerOptions& options);
  /// Says goodbye. What was handed over has been written, or is lost with the connection.
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  /// Hands over a message; false while the broker is not there.
  bool publish(const Publication& publication);
  /// How often the broker was reached so far.
  [[nodiscard]] std::uint64_t connections() const noexcept { return connections_; }
  /// Why the broker, which is there, refused the connection, in its words; empty: it did not.
  [[nodiscard]] std::string refusal() const;

 private:
  struct Handle;
  struct Free {
    void operator()(Handle* handle) const;
  };
  /// Until the end: hears the broker, and goes to it again.
  void serve();

  std::unique_ptr<Handle, Free> handle_;
  std::atomic<std::uint64_t> connections_{0};
  std::atomic<int> refusal_{0};  ///< MQTT's return code; 0: none
  std::atomic<bool> connected_{false};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace hapticd::relay
