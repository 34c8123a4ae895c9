// See stop_socket.h.
#include "server/stop_road/stop_socket.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <system_error>

namespace hapticd {
namespace {

socklen_t length_of(const sockaddr_storage& address) noexcept {
  return address.ss_family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
}

sockaddr_storage numeric_address(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) {
    throw std::invalid_argument("'" + host + "' is not an address");
  }
  sockaddr_storage address{};
  std::memcpy(&address, found->ai_addr, found->ai_addrlen);
  ::freeaddrinfo(found);
  return address;
}

StopPeer peer_of(const sockaddr_storage& address) noexcept {
  StopPeer peer;
  if (address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof(v4));
    peer.ip[10] = peer.ip[11] = 0xff;
    std::memcpy(peer.ip.data() + 12, &v4.sin_addr, 4);
    peer.port = ntohs(v4.sin_port);
  } else {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address, sizeof(v6));
    std::memcpy(peer.ip.data(), &v6.sin6_addr, 16);
    peer.port = ntohs(v6.sin6_port);
  }
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  constexpr std::array<std::uint8_t, 16> kLoopback6{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  const bool v4 = std::equal(kMapped.begin(), kMapped.end(), peer.ip.begin());
  peer.loopback = v4 ? peer.ip[12] == 127 : peer.ip == kLoopback6;
  return peer;
}

}  // namespace

void check_stop_address(const std::string& host) {
  static_cast<void>(numeric_address(host, stop::kDefaultPort));
}

StopSocket::StopSocket(const std::string& host, std::uint16_t port)
    : local_(numeric_address(host, port)) {
  const bool v4 = local_.ss_family == AF_INET;
  socket_ = ::socket(local_.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  socklen_t bytes = sizeof(local_);
  const bool bound =
      socket_ >= 0 &&
      ::setsockopt(socket_, v4 ? IPPROTO_IP : IPPROTO_IPV6, v4 ? IP_PKTINFO : IPV6_RECVPKTINFO, &on,
                   sizeof(on)) == 0 &&
      ::bind(socket_, reinterpret_cast<const sockaddr*>(&local_), length_of(local_)) == 0 &&
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&local_), &bytes) == 0;
  if (!bound) {
    const int reason = errno;
    if (socket_ >= 0) ::close(socket_);
    throw std::system_error(reason, std::generic_category());
  }
  for (std::size_t k = 0; k < kBatch; ++k) {
    slots_[k].part = {slots_[k].bytes.data(), slots_[k].bytes.size()};
    headers_[k].msg_hdr.msg_name = &slots_[k].from;
    headers_[k].msg_hdr.msg_iov = &slots_[k].part;
    headers_[k].msg_hdr.msg_iovlen = 1;
    headers_[k].msg_hdr.msg_control = slots_[k].control.data();
  }
}

StopSocket::~StopSocket() { ::close(socket_); }

void StopSocket::wait(std::int64_t timeout_ns) noexcept {
  pollfd watched{socket_, POLLIN, 0};
  timespec timeout{};
  timeout.tv_sec = static_cast<time_t>(timeout_ns / 1'000'000'000);
  timeout.tv_nsec = static_cast<long>(timeout_ns % 1'000'000'000);
  // Interrupted, it is called again by the next turn of the thread.
  static_cast<void>(::ppoll(&watched, 1, &timeout, nullptr));
}

/// What a call has filled in is room again.
void StopSocket::refresh() noexcept {
  for (std::size_t k = 0; k < kBatch; ++k) {
    headers_[k].msg_hdr.msg_namelen = sizeof(slots_[k].from);
    headers_[k].msg_hdr.msg_controllen = slots_[k].control.size();
    headers_[k].msg_hdr.msg_flags = 0;
    headers_[k].msg_len = 0;
  }
}

std::size_t StopSocket::read() noexcept {
  refresh();
  const int read = ::recvmmsg(socket_, headers_.data(), kBatch, MSG_DONTWAIT, nullptr);
  return read > 0 ? static_cast<std::size_t>(read) : 0;
}

std::span<const std::uint8_t> StopSocket::datagram(std::size_t k) const noexcept {
  return {slots_[k].bytes.data(), headers_[k].msg_len};
}

StopPeer StopSocket::peer(std::size_t k) const noexcept { return peer_of(slots_[k].from); }

// The control data says which of this machine's addresses the datagram was sent to, and is said
// back: a client listens to no other.
bool StopSocket::answer(std::size_t k, const stop::Datagram& datagram) noexcept {
  stop::Datagram copy = datagram;
  iovec part{copy.data(), copy.size()};
  msghdr header = headers_[k].msg_hdr;
  header.msg_iov = &part;
  header.msg_flags = 0;
  return ::sendmsg(socket_, &header, MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(copy.size());
}

std::string StopSocket::local_address() const {
  std::array<char, NI_MAXHOST> host{};
  const int failed = ::getnameinfo(reinterpret_cast<const sockaddr*>(&local_), length_of(local_),
                                   host.data(), host.size(), nullptr, 0, NI_NUMERICHOST);
  const std::string name = failed == 0 ? host.data() : "?";
  return (local_.ss_family == AF_INET ? name : "[" + name + "]") + ":" + std::to_string(port());
}

std::uint16_t StopSocket::port() const noexcept { return peer_of(local_).port; }

bool StopSocket::loopback() const noexcept { return peer_of(local_).loopback; }

}  // namespace hapticd
