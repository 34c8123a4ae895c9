// The whole gateway between a real ProtocolServer and real WebSockets of loopback. What a page must
// get is in clients/web/gateway/README.md.
#include "clients/web/gateway/gateway.h"

#include <doctest/doctest.h>

#include "clients/library/client.h"
#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/fake_daemon.h"
#include "tests/clients/web/gateway/running_gateway.h"

namespace hapticd::test {
namespace {

bool is_live(const v1::PageEvent& event) {
  return event.link().state() == v1::PAGE_LINK_STATE_LIVE;
}

bool is_state(const v1::PageEvent& event) { return event.has_state(); }

v1::Item acquire() {
  v1::Item item;
  item.mutable_acquire()->set_holder("page");
  return item;
}

TEST_CASE("a page is welcomed, gets the scene, and States that go forward") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser page(gateway.port());
  REQUIRE(page.status() == 101);
  const auto first = page.next();
  REQUIRE(first.has_welcome());
  CHECK(first.sequence() == 1);
  CHECK_FALSE(first.welcome().control());
  const auto scene = page.wait_for([](const auto& event) { return event.item().has_scene_info(); });
  CHECK(scene.item().scene_info().hash() == std::string(32, 's'));
  // The first may be that of tick 0.
  std::uint64_t next_tick = 0;
  for (int i = 0; i < 50; ++i) {
    const auto event = page.wait_for(is_state);
    CHECK(event.state().tick() >= next_tick);
    next_tick = event.state().tick() + 1;
  }
  CHECK(daemon.divisor == 4);
}

TEST_CASE("one subscription serves many pages, and each gets every event once and in order") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  std::vector<std::unique_ptr<Browser>> pages;
  for (int i = 0; i < 8; ++i) {
    pages.push_back(std::make_unique<Browser>(gateway.port()));
    pages.back()->wait_for(is_live);
  }
  daemon.play(100);
  for (const auto& page : pages) {
    std::uint64_t sequence = 0;
    for (std::uint32_t tone = 0; tone < 100;) {
      const auto event = page->next();
      CHECK(event.sequence() > sequence);
      sequence = event.sequence();
      if (event.item().has_tone()) REQUIRE(event.item().tone().string_index() == tone++);
    }
  }
  const std::string metrics = fetch(gateway.port(), "/metrics").body();
  CHECK(metrics.find("\nhaptic_web_viewers 8\n") != std::string::npos);
  CHECK(metrics.find("\nhaptic_web_link_state 2\n") != std::string::npos);
  CHECK(metrics.find("\nhaptic_web_link_sessions_ended_total 0\n") != std::string::npos);
}

TEST_CASE("the token permits control from this machine; without it, or a wrong one, a page looks") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser holder(gateway.port(), gateway.control());
  CHECK(holder.protocol() == gateway.control());
  CHECK(holder.next().welcome().control());
  holder.wait_for(is_live);
  CHECK(holder.call(acquire()).code() == v1::RESULT_CODE_OK);
  v1::Item engage;
  engage.mutable_engage();
  CHECK(holder.call(engage).code() == v1::RESULT_CODE_OK);
  REQUIRE(daemon.requests().size() == 1);
  CHECK(daemon.requests()[0].has_engage());
  Browser guesser(gateway.port(), "hapticd.v1." + std::string(32, '0'));
  CHECK(guesser.status() == 101);
  CHECK_FALSE(guesser.next().welcome().control());
  CHECK(guesser.call(engage).code() == v1::RESULT_CODE_NOT_PERMITTED);
  CHECK(daemon.requests().size() == 1);
  CHECK(fetch(gateway.port(), "/metrics").body().find("haptic_web_bad_tokens_total 1") !=
        std::string::npos);
}

TEST_CASE("the lease goes back when its page closes, and another takes it") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser second(gateway.port(), gateway.control());
  {
    Browser first(gateway.port(), gateway.control());
    first.wait_for(is_live);
    CHECK(first.call(acquire()).code() == v1::RESULT_CODE_OK);
    CHECK(second.call(acquire()).code() == v1::RESULT_CODE_BUSY);
  }
  second.wait_for([](const auto& event) {
    return event.item().has_lease_info() && event.item().lease_info().fence() == 0;
  });
  CHECK(second.call(acquire()).code() == v1::RESULT_CODE_OK);
  const auto told =
      second.wait_for([](const auto& event) { return event.item().has_lease_info(); });
  CHECK(told.item().lease_info().yours());
}

TEST_CASE("pages of elsewhere are refused, and so is a name that is not this machine's") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  CHECK(Browser(gateway.port(), "hapticd.v1", "http://evil.example").status() == 403);
  CHECK(Browser(gateway.port(), gateway.control(), "null").status() == 403);
  CHECK(fetch(gateway.port(), "/metrics", "evil.example").result_int() == 421);
  CHECK(fetch(gateway.port(), "/metrics", "localhost:1").result_int() == 200);
}

TEST_CASE("a page learns the daemon's clock: the tick of now lies between two of its pings") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser page(gateway.port());
  page.wait_for(is_live);
  v1::PageRequest ping;
  ping.mutable_ping()->set_sent_s(3.5);
  const auto is_pong = [](const v1::PageEvent& event) { return event.has_pong(); };
  const std::int64_t before_ns = client::monotonic_now_ns();
  page.send(ping);
  const auto pong = page.wait_for(is_pong).pong();
  const std::int64_t after_ns = client::monotonic_now_ns();
  // Both clocks are this machine's here; the estimate may be off by what it says, some ms at most.
  constexpr std::int64_t kSlack_ns = 50'000'000;
  CHECK(pong.sent_s() == 3.5);
  CHECK(pong.daemon_t_ns() > before_ns - kSlack_ns);
  CHECK(pong.daemon_t_ns() < after_ns + kSlack_ns);
}

TEST_CASE("garbage, and a message beyond all measure, close their page and nobody else's") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser other(gateway.port());
  Browser garbage(gateway.port());
  garbage.next();
  garbage.send_bytes("\xff\xff\xff");
  CHECK(garbage.close_code() == 1007);
  Browser large(gateway.port());
  large.next();
  // Short enough for the socket to take it whole, however early the gateway stops to read.
  large.send_bytes(std::string((16U << 10U) + 1, 'x'));
  CHECK(large.close_code() == 1009);
  other.wait_for(is_live);
  other.wait_for(is_state);
}

TEST_CASE(
    "a page that may control sends longer messages than one that looks, and they are read whole") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser holder(gateway.port(), gateway.control());
  holder.next();
  holder.send_bytes(std::string(200U << 10U, '\xff'));
  CHECK(holder.close_code() == 1007);
}

TEST_CASE("as many viewers as permitted are served, one more is told why not") {
  FakeDaemon daemon;
  web::WebOptions options = options_for(daemon.port());
  options.server.most_viewers = 2;
  RunningGateway gateway(options);
  Browser one(gateway.port());
  auto two = std::make_unique<Browser>(gateway.port());
  two->next();
  CHECK(Browser(gateway.port()).status() == 503);
  two.reset();
  // Its place is free as soon as the gateway has noticed.
  unsigned status = 503;
  for (int i = 0; i < 1000 && status == 503; ++i) status = Browser(gateway.port()).status();
  CHECK(status == 101);
}

TEST_CASE("a gateway that ends says goodbye") {
  FakeDaemon daemon;
  RunningGateway gateway(options_for(daemon.port()));
  Browser page(gateway.port());
  page.next();
  gateway.stop();
  CHECK(page.close_code() == 1001);
}

TEST_CASE(
    "only GET and HEAD are answered; what is not there is 404, with the remedy for the page") {
  FakeDaemon daemon;
  web::WebOptions options = options_for(daemon.port());
  options.server.page = "/nowhere";
  RunningGateway gateway(options);
  namespace http = boost::beast::http;
  CHECK(fetch(gateway.port(), "/", "127.0.0.1", http::verb::post).result_int() == 405);
  const auto missing = fetch(gateway.port(), "/");
  CHECK(missing.result_int() == 404);
  CHECK(missing.body().find("--page") != std::string::npos);
  CHECK(fetch(gateway.port(), "/asset/" + std::string(64, '0')).result_int() == 404);
  const auto head = fetch(gateway.port(), "/metrics", "127.0.0.1", http::verb::head);
  CHECK(head.result_int() == 200);
  CHECK(head.body().empty());
  CHECK(std::stoul(std::string(head[http::field::content_length])) > 500);
}

}  // namespace
}  // namespace hapticd::test
