// The UDP socket of the Stop road: bound once, read many datagrams at a time, each answered from
// the address it was sent to. Its memory is its own from the start. Linux. Not RT.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "proto/stop/stop_datagram.h"
#include "server/stop_road/stop_judge.h"

namespace hapticd {

/// Throws std::invalid_argument where `host` is no numeric address, perhaps with a scope.
void check_stop_address(const std::string& host);

class StopSocket {
 public:
  /// Datagrams read by one call.
  static constexpr std::size_t kBatch = 32;

  /// Binds `host`, a numeric address, perhaps with a scope, and `port`; 0: any. Throws
  /// std::system_error where the system refuses, std::invalid_argument where it is no address.
  StopSocket(const std::string& host, std::uint16_t port);
  ~StopSocket();
  StopSocket(const StopSocket&) = delete;
  StopSocket& operator=(const StopSocket&) = delete;

  /// Waits until a datagram is there or `timeout_ns` has passed. System call: ppoll.
  void wait(std::int64_t timeout_ns) noexcept;
  /// Reads what is there, without waiting; returns how many, kBatch at most. System call: recvmmsg.
  std::size_t read() noexcept;
  /// The `k`th that was read; one that is longer than all is given a byte too long.
  [[nodiscard]] std::span<const std::uint8_t> datagram(std::size_t k) const noexcept;
  [[nodiscard]] StopPeer peer(std::size_t k) const noexcept;
  /// Answers the `k`th; false when the system does not take it. System call: sendmsg.
  bool answer(std::size_t k, const stop::Datagram& datagram) noexcept;

  /// The address that is bound, as people write it: 127.0.0.1:47801.
  [[nodiscard]] std::string local_address() const;
  [[nodiscard]] std::uint16_t port() const noexcept;
  /// Whether only this machine reaches it.
  [[nodiscard]] bool loopback() const noexcept;

 private:
  /// One datagram with where it came from and what it was sent to.
  struct Slot {
    std::array<std::uint8_t, stop::kDatagramBytes + 1> bytes;
    sockaddr_storage from;
    alignas(cmsghdr) std::array<std::uint8_t, 64> control;
    iovec part;
  };

  void refresh() noexcept;

  int socket_ = -1;
  sockaddr_storage local_{};
  std::array<Slot, kBatch> slots_{};
  std::array<mmsghdr, kBatch> headers_{};
};

}  // namespace hapticd
