// What a peer of the stream may do with frames that no browser would: messages that never end, text
// that is none, frames before they are due.
#include <doctest/doctest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/fake_daemon.h"
#include "tests/clients/web/gateway/raw_peer.h"
#include "tests/clients/web/gateway/running_gateway.h"

namespace hapticd::test {
namespace {

/// With a mask of zeros, so that the payload is as it is read.
std::string frame(unsigned first_byte, const std::string& payload) {
  REQUIRE(payload.size() < 126);
  std::string bytes{static_cast<char>(first_byte), static_cast<char>(0x80U | payload.size())};
  return bytes + std::string(4, '\0') + payload;
}

constexpr unsigned kBinary = 0x82;
constexpr unsigned kText = 0x81;
constexpr unsigned kPing = 0x89;
constexpr unsigned kFirstOfMany = 0x02;
constexpr unsigned kOneOfMany = 0x00;

std::string ping() {
  v1::PageRequest request;
  request.mutable_ping()->set_sent_s(2.5);
  return request.SerializeAsString();
}

bool metric_is(std::uint16_t port, const std::string& name, std::size_t value) {
  return fetch(port, "/metrics").body().find('\n' + name + ' ' + std::to_string(value) + '\n') !=
         std::string::npos;
}

/// The gateway counts some ends only when it has noticed them.
bool metric_becomes(std::uint16_t port, const std::string& name, std::size_t value) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (std::chrono::steady_clock::now() < end) {
    if (metric_is(port, name, value)) return true;
  }
  return false;
}

std::unique_ptr<Peer> looker(std::uint16_t port) {
  auto peer = std::make_unique<Peer>(port);
  peer->say(handshake());
  CHECK(peer->head().starts_with("HTTP/1.1 101 "));
  return peer;
}

TEST_CASE(
    "who does not end a message in time is closed, told why and counted, whatever is missing") {
  FakeDaemon daemon;
  web::WebOptions options = options_for(daemon.port());
  options.server.message_time = std::chrono::nanoseconds{0};
  RunningGateway gateway(options);
  const std::vector<std::string> halves{
      std::string(1, static_cast<char>(kBinary)),
      frame(kBinary, "four").substr(0, 4),
      frame(kBinary, "four").substr(0, 6),
      frame(kBinary, "four").substr(0, 9),
      frame(kPing, "four").substr(0, 9),
      frame(kFirstOfMany, "four"),
      frame(kFirstOfMany, "") + frame(kOneOfMany, "") + frame(kPing, ""),
      frame(kBinary, ping()) + frame(kBinary, ping()).substr(0, 3)};
  for (std::size_t i = 0; i < halves.size(); ++i) {
    CAPTURE(i);
    const auto peer = looker(gateway.port());
    peer->say(halves[i]);
    CHECK(peer->goodbye() == 1008);
    CHECK(metric_is(gateway.port(), "haptic_web_viewers_closed_unfinished_total", i + 1));
  }
  const auto whole = std::make_unique<Browser>(gateway.port());
  v1::PageRequest request;
  request.mutable_ping();
  whole->send(request);
  whole->wait_for([](const v1::PageEvent& event) { return event.has_pong(); });
  CHECK(metric_is(gateway.port(), "haptic_web_viewers_closed_unfinished_total", halves.size()));
}

TEST_CASE("a message in pieces that ends in time is obeyed") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  const auto peer = looker(gateway.port());
  const std::string bytes = ping();
  const std::string pieces = frame(kFirstOfMany, bytes.substr(0, 3)) + frame(kPing, "") +
                             frame(0x80U | kOneOfMany, bytes.substr(3));
  for (const char byte : pieces) peer->say({byte});
  // Behind it one that is garbage: its goodbye comes after what was obeyed.
  peer->say(frame(kBinary, "\xff"));
  CHECK(peer->goodbye() == 1007);
  CHECK(metric_is(gateway.port(), "haptic_web_page_requests_total", 1));
}

TEST_CASE("frames that break the rules close who sends them, and are counted as garbage") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  const std::vector<std::pair<unsigned, std::string>> bad{
      {1007, frame(kText, "\xff\xfe")},     // text that is none
      {1002, std::string("\x82\x01x", 3)},  // not masked
      {1002, frame(0x83, "x")},             // of no kind
      {1002, frame(kPing & 0x7fU, "x")},    // a control frame of many
      {1002, frame(kOneOfMany, "x")},       // goes on with nothing
      {1002, frame(0xc2, "x")},             // an extension nobody spoke of
      {1009, std::string("\x82\xfe\x40\x01", 4) + std::string(4, '\0')},  // 16 KiB and a byte
  };
  for (std::size_t i = 0; i < bad.size(); ++i) {
    CAPTURE(i);
    auto peer = looker(gateway.port());
    peer->say(bad[i].second);
    CHECK(peer->goodbye() == bad[i].first);
    peer.reset();
    CHECK(metric_becomes(gateway.port(), "haptic_web_viewers_closed_garbage_total", i + 1));
  }
}

TEST_CASE("frames that come with the handshake are refused, and not lost") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Peer peer(gateway.port());
  peer.say(handshake() + frame(kBinary, ping()));
  CHECK(peer.head().starts_with("HTTP/1.1 400 "));
}

}  // namespace
}  // namespace hapticd::test
