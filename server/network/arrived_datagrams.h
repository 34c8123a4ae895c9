// What has come to a UDP socket, many datagrams by one system call, with whom they came from and
// how many the system had no room for. Linux. Not RT.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "proto/wire/datagram.h"
#include "server/network/address.h"

namespace hapticd {

/// Datagrams taken from the socket before the server is polled, so that a flood cannot keep it from
/// sending.
inline constexpr std::size_t kMaxPerTurn = 256;
/// Longer than any datagram of the protocol, so that one too long is seen to be.
inline constexpr std::size_t kBufferBytes = 1216;
static_assert(kBufferBytes > wire::kDatagramBytes);
/// The datagrams of a turn, taken with one system call.
class ArrivedDatagrams {
 public:
  ArrivedDatagrams() {
    for (std::size_t i = 0; i < kMaxPerTurn; ++i) {
      places_[i] = {bytes_[i].data(), kBufferBytes};
      msghdr& head = heads_[i].msg_hdr;
      head.msg_iov = &places_[i];
      head.msg_iovlen = 1;
      head.msg_name = &from_[i];
      head.msg_control = controls_[i].data();
    }
  }
  ArrivedDatagrams(const ArrivedDatagrams&) = delete;
  ArrivedDatagrams& operator=(const ArrivedDatagrams&) = delete;

  /// Takes what has come to `socket`, kMaxPerTurn at most, without waiting.
  void take(int socket) {
    for (mmsghdr& head : heads_) {
      head.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
      head.msg_hdr.msg_controllen = kControlBytes;
    }
    const int taken = ::recvmmsg(socket, heads_.data(), kMaxPerTurn, MSG_DONTWAIT, nullptr);
    count_ = taken > 0 ? static_cast<std::size_t>(taken) : 0;
    for (std::size_t i = 0; i < count_; ++i) note_overflow(heads_[i].msg_hdr);
  }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::span<const std::uint8_t> datagram(std::size_t i) const {
    return {bytes_[i].data(), heads_[i].msg_len};
  }
  [[nodiscard]] Address from(std::size_t i) const {
    Address address;
    if (from_[i].ss_family == AF_INET) {
      sockaddr_in name{};
      std::memcpy(&name, &from_[i], sizeof name);
      std::array<std::uint8_t, 4> ip{};
      std::memcpy(ip.data(), &name.sin_addr, ip.size());
      return ipv4_address(ip, ntohs(name.sin_port));
    }
    sockaddr_in6 name{};
    std::memcpy(&name, &from_[i], sizeof name);
    std::memcpy(address.ip.data(), &name.sin6_addr, address.ip.size());
    address.port = ntohs(name.sin6_port);
    return address;
  }
  /// Datagrams that found the socket's buffer full, so far.
  [[nodiscard]] std::uint64_t overflowed() const noexcept { return overflowed_; }

 private:
  static constexpr std::size_t kControlBytes = CMSG_SPACE(sizeof(std::uint32_t));

  // The system counts in 32 bits, and says the count beside each datagram once it is not 0.
  void note_overflow(msghdr& head) {
    const cmsghdr* said = CMSG_FIRSTHDR(&head);
    if (said == nullptr || said->cmsg_level != SOL_SOCKET || said->cmsg_type != SO_RXQ_OVFL) return;
    std::uint32_t count = 0;
    std::memcpy(&count, CMSG_DATA(said), sizeof count);
    overflowed_ += count - static_cast<std::uint32_t>(overflowed_);
  }

  std::size_t count_ = 0;
  std::uint64_t overflowed_ = 0;
  std::array<mmsghdr, kMaxPerTurn> heads_{};
  std::array<iovec, kMaxPerTurn> places_{};
  std::array<sockaddr_storage, kMaxPerTurn> from_{};
  alignas(cmsghdr) std::array<std::array<char, kControlBytes>, kMaxPerTurn> controls_{};
  std::array<std::array<std::uint8_t, kBufferBytes>, kMaxPerTurn> bytes_{};
};

}  // namespace hapticd
