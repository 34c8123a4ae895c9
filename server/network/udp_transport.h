// The socket of the server: receives datagrams for a ProtocolServer, polls it, sends what it sends.
// One thread, the one that calls run(). Standalone Asio behind it. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "server/network/protocol_server.h"

namespace hapticd {

/// A UDP socket that somebody else has bound.
struct BoundSocket {
  int descriptor = -1;
};

/// Throws what UdpTransport(listen, keyed) throws, as far as it can be told without a socket.
void check_listen(const std::string& listen, bool keyed);

/// A bound UDP socket and the loop that serves it.
class UdpTransport {
 public:
  /// What the daemon does between two polls: takes events and ticks from the loop and hands them to
  /// the server. Returns true to be called again at once (after the socket was looked at), as a Run
  /// of steps needs; false to be called again after 500 us or when a datagram came.
  using Work = std::function<bool(std::int64_t now_ns)>;

  /// Binds `listen`, ADDR:PORT or [ADDR]:PORT with a numeric address; port 0 lets the system
  /// choose. Unless the server is `keyed` PLAIN is what is spoken, and every address but loopback
  /// is refused. Throws std::runtime_error that says what is wrong and what to do.
  explicit UdpTransport(const std::string& listen, bool keyed = false);
  /// Serves a socket that is bound to an IPv4 or IPv6 address, and owns it from here on. The same
  /// refusals.
  explicit UdpTransport(BoundSocket bound, bool keyed = false);
  ~UdpTransport();
  UdpTransport(const UdpTransport&) = delete;
  UdpTransport& operator=(const UdpTransport&) = delete;

  /// Address and port bound, as text for people: 127.0.0.1:47800.
  [[nodiscard]] std::string local_address() const;
  /// Whether every address of this machine reaches it.
  [[nodiscard]] bool wildcard() const;
  /// Whether nobody reaches it by IPv6.
  [[nodiscard]] bool ipv4_only() const noexcept;
  /// Port bound.
  [[nodiscard]] std::uint16_t port() const;

  /// Sends one datagram; one that the system does not take is lost and counted. From the thread of
  /// run() only.
  void send(const Address& to, std::span<const std::uint8_t> datagram);
  /// Datagrams that the system did not take.
  [[nodiscard]] std::uint64_t unsent() const;

  /// Serves until stop(). Work is called before each poll of the server.
  void run(ProtocolServer& server, const Work& work);
  /// Ends run() soon; from any thread, or from Work.
  void stop();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace hapticd
