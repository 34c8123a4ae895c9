// The gateway and a daemon that is not there, that has keys, that ends and comes again, that speaks
// another version: what its pages are told. Real sockets of loopback.
#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <atomic>
#include <boost/asio/ip/udp.hpp>
#include <thread>

#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/fake_daemon.h"
#include "tests/clients/web/gateway/running_gateway.h"

namespace hapticd::test {
namespace {

auto in_state(v1::PageLinkState state) {
  return [state](const v1::PageEvent& event) { return event.link().state() == state; };
}

noise::SecretKey even_key(std::uint8_t byte) {
  return noise::SecretKey::filled([byte](noise::Key& key) { key.fill(byte); });
}

noise::ServerKeys two_keys() { return noise::server_keys(even_key(3), even_key(1), even_key(2)); }

client::ClientKey key_of(wire::Role role, std::uint8_t byte) {
  return {role, even_key(byte), two_keys().server};
}

/// A port of loopback where nothing listens.
std::uint16_t free_port() {
  boost::asio::io_context context;
  boost::asio::ip::udp::socket socket(context, {boost::asio::ip::make_address("127.0.0.1"), 0});
  return socket.local_endpoint().port();
}

TEST_CASE("a page is told that no daemon runs, and shows it as soon as one starts") {
  const std::uint16_t port = free_port();
  RunningGateway gateway(options_for(port));
  Browser page(gateway.port(), gateway.control());
  const auto gone = page.wait_for(in_state(v1::PAGE_LINK_STATE_DAEMON_GONE));
  CHECK(gone.link().message().find("Start hapticd") != std::string::npos);
  v1::Item ping;
  ping.mutable_ping();
  CHECK(page.call(ping).code() == v1::RESULT_CODE_FAILED);
  FakeDaemon daemon(port);
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  page.wait_for([](const auto& event) { return event.has_state(); });
}

TEST_CASE("a daemon that ends and comes again is shown again, its scene told anew") {
  auto daemon = std::make_unique<FakeDaemon>(0, 11);
  const std::uint16_t port = daemon->port();
  RunningGateway gateway(options_for(port));
  Browser page(gateway.port());
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  daemon->say_bye = true;
  const auto gone = page.wait_for(in_state(v1::PAGE_LINK_STATE_DAEMON_GONE));
  CHECK(gone.link().message().find("the end") != std::string::npos);
  daemon.reset();
  daemon = std::make_unique<FakeDaemon>(port, 12);
  page.wait_for([](const auto& event) { return event.item().has_scene_info(); });
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  page.wait_for([](const auto& event) { return event.has_state(); });
}

TEST_CASE("a daemon that was killed is gone, and one in its place is found without being asked") {
  auto daemon = std::make_unique<FakeDaemon>(0, 11);
  const std::uint16_t port = daemon->port();
  RunningGateway gateway(options_for(port));
  Browser page(gateway.port());
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  daemon.reset();
  page.wait_for(in_state(v1::PAGE_LINK_STATE_DAEMON_GONE));
  daemon = std::make_unique<FakeDaemon>(port, 12);
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
}

TEST_CASE("with the view key pages see everything and none may control, token or not") {
  FakeDaemon daemon(0, 11, two_keys());
  web::WebOptions options = options_for(daemon.port());
  options.link.key = key_of(wire::Role::kView, 1);
  RunningGateway gateway(options);
  CHECK(gateway.token().empty());
  Browser page(gateway.port(), "hapticd.v1.");
  CHECK_FALSE(page.next().welcome().control());
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  page.wait_for([](const auto& event) { return event.has_state(); });
  daemon.play(1);
  page.wait_for([](const auto& event) { return event.item().has_tone(); });
  v1::Item stop;
  stop.mutable_stop();
  CHECK(page.call(stop).code() == v1::RESULT_CODE_NOT_PERMITTED);
}

TEST_CASE("with the control key a page with the token controls a daemon with keys") {
  FakeDaemon daemon(0, 11, two_keys());
  web::WebOptions options = options_for(daemon.port());
  options.link.key = key_of(wire::Role::kControl, 2);
  RunningGateway gateway(options);
  Browser page(gateway.port(), gateway.control());
  page.wait_for(in_state(v1::PAGE_LINK_STATE_LIVE));
  v1::Item acquire;
  acquire.mutable_acquire();
  CHECK(page.call(acquire).code() == v1::RESULT_CODE_OK);
}

TEST_CASE("a wrong key, and none where one is wanted, are told apart from a daemon that is gone") {
  FakeDaemon daemon(0, 11, two_keys());
  web::WebOptions wrong = options_for(daemon.port());
  wrong.link.key = key_of(wire::Role::kView, 0);
  RunningGateway with_wrong(wrong);
  RunningGateway with_none(options_for(daemon.port()));
  Browser one(with_wrong.port());
  Browser two(with_none.port());
  const auto no = one.wait_for(in_state(v1::PAGE_LINK_STATE_WRONG_KEY));
  CHECK(no.link().message().find("does not answer this key") != std::string::npos);
  const auto none = two.wait_for(in_state(v1::PAGE_LINK_STATE_WRONG_KEY));
  CHECK(none.link().message().find("does not answer without a key") != std::string::npos);
}

TEST_CASE("an address that the system has no way to is told as such") {
  web::WebOptions options = options_for(47800);
  // Broadcast, which a socket has to ask for: the system refuses it as it refuses a missing route.
  options.link.host = "255.255.255.255";
  RunningGateway gateway(options);
  Browser page(gateway.port());
  const auto told = page.wait_for(in_state(v1::PAGE_LINK_STATE_NO_ROUTE));
  CHECK(told.link().message().find("no route to 255.255.255.255") != std::string::npos);
}

TEST_CASE("a daemon of another wire major is told apart") {
  boost::asio::io_context context;
  boost::asio::ip::udp::socket socket(context, {boost::asio::ip::make_address("127.0.0.1"), 0});
  RunningGateway gateway(options_for(socket.local_endpoint().port()));
  std::atomic<bool> done{false};
  std::thread other([&] {
    std::array<char, 2048> buffer{};
    // Looks up now and then whether it shall go on.
    const timeval patience{0, 50'000};
    setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    while (!done) {
      boost::asio::ip::udp::endpoint from;
      boost::system::error_code none;
      const std::size_t bytes = socket.receive_from(boost::asio::buffer(buffer), from, 0, none);
      if (none || bytes < 2) continue;
      buffer[1] = 2;
      socket.send_to(boost::asio::buffer(buffer.data(), bytes), from, 0, none);
    }
  });
  Browser page(gateway.port());
  const auto told = page.wait_for(in_state(v1::PAGE_LINK_STATE_VERSION_MISMATCH));
  done = true;
  other.join();
  CHECK(told.link().message().find("wire major 2") != std::string::npos);
}

}  // namespace
}  // namespace hapticd::test
