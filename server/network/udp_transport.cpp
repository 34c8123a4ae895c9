// See udp_transport.h.
#include "server/network/udp_transport.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <asio/ip/udp.hpp>
#include <asio/post.hpp>
#include <atomic>
#include <charconv>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "core/rt/memory_boundary.h"
#include "core/rt/monotonic_clock.h"
#include "proto/wire/datagram.h"
#include "server/network/arrived_datagrams.h"

namespace hapticd {
namespace {

using asio::ip::udp;

/// Longest time between two polls of the server.
constexpr std::chrono::microseconds kPollPeriod{500};
/// The system's buffer for what arrives between two polls, bytes; it may grant less.
constexpr int kSocketBytes = 1 << 20;

[[noreturn]] void refuse(const std::string& listen, const std::string& what) {
  throw std::runtime_error("cannot listen on '" + listen + "': " + what);
}

udp::endpoint endpoint_of(const std::string& listen) {
  const std::size_t colon = listen.rfind(':');
  const std::string form = "; --listen wants ADDR:PORT with a numeric address, 127.0.0.1:47800";
  if (colon == std::string::npos) refuse(listen, "no port" + form);
  std::string host = listen.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  std::error_code error;
  const asio::ip::address address = asio::ip::make_address(host, error);
  if (error) refuse(listen, "'" + host + "' is not an address" + form);
  std::uint16_t port = 0;
  const char* const end = listen.data() + listen.size();
  const auto parsed = std::from_chars(listen.data() + colon + 1, end, port);
  if (parsed.ec != std::errc{} || parsed.ptr != end) {
    refuse(listen, "'" + listen.substr(colon + 1) + "' is not a port" + form);
  }
  return {address, port};
}

/// Refuses an address that others than this machine reach, without keys.
void check_reach(const udp::endpoint& endpoint, const std::string& listen, bool keyed) {
  if (keyed || endpoint.address().is_loopback()) return;
  refuse(listen,
         "without keys everyone who reaches it could drive the device; make keys with 'hapticctl "
         "keygen DIR' and start with --keys DIR, or listen on 127.0.0.1");
}

udp::endpoint endpoint_of(const Address& address, bool v4) {
  if (!v4) return {asio::ip::address_v6(address.ip), address.port};
  std::array<std::uint8_t, 4> ip{};
  std::copy(address.ip.begin() + 12, address.ip.end(), ip.begin());
  return {asio::ip::address_v4(ip), address.port};
}

bool is_hello(std::span<const std::uint8_t> datagram) {
  return datagram.size() > 2 &&
         datagram[2] == static_cast<std::uint8_t>(wire::DatagramKind::kHello);
}

}  // namespace

void check_listen(const std::string& listen, bool keyed) {
  check_reach(endpoint_of(listen), listen, keyed);
}

struct UdpTransport::Implementation {
  asio::io_context context{1};
  udp::socket socket{context};
  bool v4 = true;
  bool waits = false;  ///< a wait for the socket is under way
  std::atomic<bool> stopped{false};
  std::uint64_t unsent = 0;
  ArrivedDatagrams arrived;

  void prepare() {
    socket.non_blocking(true);
    // Less is not a fault: what does not fit is repeated.
    std::error_code error;
    socket.set_option(asio::socket_base::receive_buffer_size(kSocketBytes), error);
    socket.set_option(asio::socket_base::send_buffer_size(kSocketBytes), error);
    const int on = 1;
    ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  }

  /// Sessions first: what their clients say does not wait for the HELLOs of strangers.
  void drain(ProtocolServer& server) {
    arrived.take(socket.native_handle());
    for (const bool hellos : {false, true}) {
      for (std::size_t i = 0; i < arrived.count(); ++i) {
        const std::span<const std::uint8_t> datagram = arrived.datagram(i);
        if (is_hello(datagram) != hellos) continue;
        server.receive(arrived.from(i), datagram, monotonic_now_ns());
      }
    }
    server.note_losses(unsent, arrived.overflowed());
  }

  /// Until a datagram comes, but not longer than until the next poll.
  void wait() {
    if (!waits) {
      socket.async_wait(udp::socket::wait_read,
                        [this](const std::error_code& /*error*/) { waits = false; });
      waits = true;
    }
    context.restart();
    context.run_one_for(kPollPeriod);
  }
};

UdpTransport::UdpTransport(const std::string& listen, bool keyed)
    : implementation_(std::make_unique<Implementation>()) {
  const udp::endpoint endpoint = endpoint_of(listen);
  check_reach(endpoint, listen, keyed);
  Implementation& self = *implementation_;
  self.v4 = endpoint.address().is_v4();
  std::error_code error;
  self.socket.open(endpoint.protocol(), error);
  if (!error) self.socket.bind(endpoint, error);
  if (error) {
    refuse(listen, error.message() +
                       "; if another hapticd runs, end it or choose another port with --listen");
  }
  self.prepare();
}

UdpTransport::UdpTransport(BoundSocket bound, bool keyed)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  sockaddr_storage name{};
  socklen_t bytes = sizeof(name);
  const bool named =
      ::getsockname(bound.descriptor, reinterpret_cast<sockaddr*>(&name), &bytes) == 0;
  if (!named || (name.ss_family != AF_INET && name.ss_family != AF_INET6)) {
    refuse("the passed socket", "it is not bound to an IPv4 or IPv6 address");
  }
  self.v4 = name.ss_family == AF_INET;
  std::error_code error;
  self.socket.assign(self.v4 ? udp::v4() : udp::v6(), bound.descriptor, error);
  if (error) refuse("the passed socket", error.message());
  check_reach(self.socket.local_endpoint(), local_address(), keyed);
  self.prepare();
}

UdpTransport::~UdpTransport() = default;

std::string UdpTransport::local_address() const {
  const udp::endpoint local = implementation_->socket.local_endpoint();
  const std::string host = local.address().to_string();
  return (local.address().is_v4() ? host : "[" + host + "]") + ":" + std::to_string(local.port());
}

bool UdpTransport::wildcard() const {
  return implementation_->socket.local_endpoint().address().is_unspecified();
}

bool UdpTransport::ipv4_only() const noexcept { return implementation_->v4; }

std::uint16_t UdpTransport::port() const { return implementation_->socket.local_endpoint().port(); }

void UdpTransport::send(const Address& to, std::span<const std::uint8_t> datagram) {
  Implementation& self = *implementation_;
  std::error_code error;
  self.socket.send_to(asio::buffer(datagram.data(), datagram.size()), endpoint_of(to, self.v4), 0,
                      error);
  if (error) ++self.unsent;
}

std::uint64_t UdpTransport::unsent() const { return implementation_->unsent; }

void UdpTransport::run(ProtocolServer& server, const Work& work) {
  Implementation& self = *implementation_;
  while (!self.stopped.load()) {
    self.drain(server);
    bool more = false;
    within_memory([&] { more = work(monotonic_now_ns()); });
    within_memory([&] { server.poll(monotonic_now_ns()); });
    if (!more && !within_memory([&] { self.wait(); })) std::this_thread::sleep_for(kPollPeriod);
  }
}

void UdpTransport::stop() {
  implementation_->stopped.store(true);
  asio::post(implementation_->context, [] {});
}

}  // namespace hapticd
