// The socket of the server: where it listens, and that datagrams go both ways.
#include "server/network/udp_transport.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <thread>

#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

std::string refusal(const std::string& listen) {
  try {
    const UdpTransport transport(listen);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("addresses that are none are refused with what is wrong") {
  CHECK(refusal("127.0.0.1").find("no port") != std::string::npos);
  CHECK(refusal("localhost:47800").find("'localhost' is not an address") != std::string::npos);
  CHECK(refusal("127.0.0.1:port").find("'port' is not a port") != std::string::npos);
  CHECK(refusal("127.0.0.1:65536").find("is not a port") != std::string::npos);
  CHECK(refusal("127.0.0.1:").find("is not a port") != std::string::npos);
  CHECK(refusal("127.0.0.1:1x").find("is not a port") != std::string::npos);
}

TEST_CASE("every address but loopback is refused, with the remedy") {
  for (const char* listen : {"0.0.0.0:0", "192.0.2.1:0", "[::]:0", "[2001:db8::1]:0"}) {
    CAPTURE(listen);
    CHECK(refusal(listen).find("listen on 127.0.0.1") != std::string::npos);
    CHECK(refusal(listen).find("--keys") != std::string::npos);
  }
}

TEST_CASE("a server with keys listens on any address") {
  const UdpTransport transport("0.0.0.0:0", true);
  CHECK(transport.local_address().starts_with("0.0.0.0:"));
  CHECK(transport.port() != 0);
}

TEST_CASE("a port that is taken is refused, with the remedy") {
  const UdpTransport first("127.0.0.1:0");
  CHECK(refusal(first.local_address()).find("choose another port") != std::string::npos);
}

/// A UDP socket connected to `port` of loopback that waits 5 s at most.
int socket_to(std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  REQUIRE(fd >= 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  const timeval patience{5, 0};
  REQUIRE(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0);
  return fd;
}

TEST_CASE("a Packet to the socket is answered, and stop() ends run()") {
  UdpTransport transport("127.0.0.1:0");
  ServerHost host;
  host.greeting = [] { return std::vector<v1::Item>(2); };
  host.request = [](const RequestId&, const v1::Item&) {};
  host.abandoned = [](const RequestId&) {};
  host.fill_state = [](const Subscription&, v1::State&) {};
  host.lease_lost = [](LeaseEnd) {};
  ProtocolServer server(
      {.boot_id = 9}, host,
      [&](const Address& to, std::span<const std::uint8_t> bytes) { transport.send(to, bytes); });
  std::thread thread([&] { transport.run(server, [](std::int64_t) { return false; }); });
  const int fd = socket_to(transport.port());
  v1::Packet packet;
  packet.set_first(1);
  *packet.add_items() = ping_item();
  const auto bytes = plain_datagram(5, 0, packet);
  CHECK(::send(fd, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  std::array<std::uint8_t, 2048> buffer{};
  const ssize_t got = ::recv(fd, buffer.data(), buffer.size(), 0);
  transport.stop();
  thread.join();
  ::close(fd);
  REQUIRE(got > 16);
  v1::Packet answer;
  REQUIRE(answer.ParseFromArray(buffer.data() + 16, static_cast<int>(got) - 16));
  CHECK(answer.ack() == 1);
  CHECK(answer.boot_id() == 9);
  CHECK(transport.unsent() == 0);
}

}  // namespace
}  // namespace hapticd::test
