// Who comes in at the gateway's door, by made-up addresses: a fleet from elsewhere against the
// player's page on this machine.
#include "clients/web/gateway/door.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <deque>
#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "clients/web/gateway/http_connection.h"
#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/raw_peer.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

namespace asio = boost::asio;
using asio::ip::address;
using Tcp = asio::ip::tcp;
using web::Door;

address here() { return asio::ip::make_address("127.0.0.1"); }
/// Of another machine.
address elsewhere(unsigned number) { return asio::ip::address_v4(0x0a000001U + number); }

TEST_CASE("200 addresses with 16 connections each keep nobody on this machine out") {
  Door door({.connections = 256, .of_address = 16});
  bool page_gave_way = false;
  REQUIRE(door.enter(here(), 0));
  door.wait(here(), 0, [&] { page_gave_way = true; });
  std::size_t fleet = 0;
  for (unsigned round = 0; round < 16; ++round) {
    for (unsigned i = 0; i < 200; ++i) {
      // Every other one never waits: it is being served, or looks.
      if (!door.enter(elsewhere(i), 1)) continue;
      ++fleet;
      if (i % 2 == 0) door.wait(elsewhere(i), 1, [&] { --fleet; });
      CHECK(door.size() == fleet + 1);
      REQUIRE(door.size() <= 256);
    }
  }
  CHECK(fleet == 192);
  CHECK_FALSE(page_gave_way);
  CHECK(door.counters().refused_full > 0);
  for (int i = 0; i < 63; ++i) CHECK(door.enter(here(), 2));
  CHECK_FALSE(page_gave_way);
}

TEST_CASE("this machine takes all places where it wants them, and its own give way in order") {
  Door door({.connections = 4, .of_address = 1});
  std::vector<int> gone;
  for (int i = 0; i < 6; ++i) {
    REQUIRE(door.enter(here(), i));
    door.wait(here(), i, [&gone, i] { gone.push_back(i); });
  }
  CHECK(gone == std::vector<int>{0, 1});
  CHECK(door.size() == 4);
}

TEST_CASE("of IPv6 a /64 counts as one address, and the next one as another") {
  SplitMix64 random(fresh_seed());
  Door door({.connections = 256, .of_address = 16});
  const auto of_network = [&](std::uint8_t network) {
    asio::ip::address_v6::bytes_type bytes{0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, network};
    for (std::size_t k = 8; k < bytes.size(); ++k) {
      bytes[k] = static_cast<std::uint8_t>(random.below(256));
    }
    return address(asio::ip::address_v6(bytes));
  };
  std::vector<address> entered;
  for (std::uint8_t network = 1; network <= 3; ++network) {
    for (int i = 0; i < 16; ++i) {
      entered.push_back(of_network(network));
      CHECK(door.enter(entered.back(), 0));
    }
    CHECK_FALSE(door.enter(of_network(network), 0));
  }
  for (const address& each : entered) door.leave(each);
  CHECK(door.size() == 0);
  CHECK(door.enter(of_network(1), 0));
}

TEST_CASE("one address takes 16 places, and beyond them only its own") {
  Door door({.connections = 256, .of_address = 16});
  bool other_gave_way = false;
  REQUIRE(door.enter(elsewhere(1), 0));
  door.wait(elsewhere(1), 0, [&] { other_gave_way = true; });
  for (int i = 0; i < 16; ++i) CHECK(door.enter(elsewhere(2), 1));
  CHECK_FALSE(door.enter(elsewhere(2), 2));
  CHECK(door.counters().refused_address == 1);
  int gave_way = 0;
  door.wait(elsewhere(2), 3, [&] { ++gave_way; });
  CHECK(door.enter(elsewhere(2), 4));
  CHECK(gave_way == 1);
  CHECK(door.size() == 17);
  CHECK_FALSE(other_gave_way);
}

TEST_CASE("whoever comes and goes, the door knows how many there are") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  Door door({.connections = 16, .of_address = 3});
  // What a list kept beside it says.
  struct One {
    address from;
    std::uint64_t number = 0;
  };
  std::map<int, One> open;
  int next = 0;
  for (std::int64_t now_ns = 0; now_ns < scaled(200'000); ++now_ns) {
    const unsigned which = static_cast<unsigned>(random.below(7));
    const address from = which == 0 ? here() : elsewhere(which);
    const auto action = random.below(4);
    if (action < 2 && door.enter(from, now_ns)) {
      const int id = next++;
      open[id] = {from};
      if (action == 0) open[id].number = door.wait(from, now_ns, [&open, id] { open.erase(id); });
    } else if (action >= 2 && !open.empty()) {
      const auto some =
          std::next(open.begin(), static_cast<std::ptrdiff_t>(random.below(open.size())));
      door.resume(some->second.number);
      some->second.number = 0;
      if (action == 3) {
        door.leave(some->second.from);
        open.erase(some);
      }
    }
    std::map<address, std::size_t> held;
    std::size_t away = 0;
    std::size_t waiting = 0;
    for (const auto& [id, one] : open) {
      ++held[one.from];
      if (!one.from.is_loopback()) ++away;
      if (one.number != 0) ++waiting;
    }
    REQUIRE(door.size() == open.size());
    REQUIRE(door.waiting() == waiting);
    REQUIRE(open.size() <= 16);
    REQUIRE(away <= 12);
    for (const auto& [of, count] : held) REQUIRE((of.is_loopback() || count <= 3));
  }
}

/// A server of a large file whose peers come from where it is told: 127.1.x.y is 10.1.x.y, of
/// another machine.
class House {
 public:
  static constexpr const char* kToken = "0123456789abcdef0123456789abcdef";
  static constexpr std::uintmax_t kFileBytes = 8'000'000;

  House() {
    std::string name = (std::filesystem::temp_directory_path() / "hapticd_web_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    folder_ = name;
    std::ofstream(folder_ / "large.js") << "";
    std::filesystem::resize_file(folder_ / "large.js", kFileBytes);
    web::ServerOptions options;
    options.port = 0;
    options.token = kToken;
    options.page = folder_;
    shared_ = std::make_shared<web::HttpServer::Shared>(context_, std::move(options), hub_);
    accept();
    thread_ = std::thread([this] { context_.run(); });
  }
  ~House() {
    asio::post(context_, [this] {
      boost::system::error_code ignored;
      shared_->acceptor.close(ignored);
      context_.stop();
    });
    thread_.join();
    shared_->files.reset();
    std::filesystem::remove_all(folder_);
  }
  House(const House&) = delete;
  House& operator=(const House&) = delete;

  [[nodiscard]] std::uint16_t port() const { return shared_->acceptor.local_endpoint().port(); }
  /// Connections that have a place, and viewers.
  std::pair<std::size_t, std::size_t> taken() {
    std::promise<std::pair<std::size_t, std::size_t>> told;
    asio::post(context_, [&] { told.set_value({shared_->door.size(), shared_->viewers}); });
    return told.get_future().get();
  }

 private:
  void accept() {
    shared_->acceptor.async_accept(
        [this](const boost::system::error_code& error, Tcp::socket peer) {
          if (error) return;
          address from = web::remote_address(peer);
          if (from.to_v4().to_bytes()[1] != 0) {
            const auto bytes = from.to_v4().to_bytes();
            from = asio::ip::address_v4({10, bytes[1], bytes[2], bytes[3]});
          }
          web::begin_connection(shared_, std::move(peer), from);
          accept();
        });
  }

  std::filesystem::path folder_;
  web::Hub hub_{{}};
  asio::io_context context_{1};
  std::shared_ptr<web::HttpServer::Shared> shared_;
  std::thread thread_;
};

bool answers_ping(Browser& page) {
  v1::PageRequest ping;
  ping.mutable_ping()->set_sent_s(1.5);
  page.send(ping);
  return page.wait_for([](const v1::PageEvent& event) { return event.has_pong(); })
             .pong()
             .sent_s() == 1.5;
}

TEST_CASE("3200 peers from 200 addresses neither hurt a page on this machine nor fill the memory") {
  // 192 places for them, each with a block of 64 KiB that has grown by a head, so twice that at
  // most, a head of 8 KiB and buffers of Boost.Beast; the rest is for what the peers and downloads
  // cost here.
  constexpr std::size_t kMost = 192 * (192U << 10U);
  const std::size_t open_before = descriptors();
  {
    House house;
    const std::string control = std::string("hapticd.v1.") + House::kToken;
    Browser page(house.port(), control);
    REQUIRE(page.status() == 101);
    const std::size_t before = anonymous_bytes();
    std::deque<std::unique_ptr<Peer>> fleet;
    for (unsigned i = 0; i < 3200; ++i) {
      const std::string from = "127.1." + std::to_string(i % 200) + ".1";
      Peer& peer = *fleet.emplace_back(std::make_unique<Peer>(house.port(), 4096, from));
      if (i % 4 == 1) peer.try_to_say("GET / HTTP/1.1\r\nCookie: " + std::string(8000, 'x'));
      if (i % 4 == 2) peer.try_to_say(get("/large.js"));
      if (i % 4 == 3) peer.try_to_say(handshake());
      // What is closed here is closed there; most of it is so by then.
      if (fleet.size() > 400) fleet.pop_front();
      if (i % 400 == 399) {
        CHECK(answers_ping(page));
        CHECK(fetch(house.port(), "/large.js").body().size() == House::kFileBytes);
        Browser other(house.port(), control);
        CHECK(other.status() == 101);
      }
    }
    const auto [connections, viewers] = house.taken();
    CHECK(connections <= 256);
    CHECK(viewers <= 64);
    const std::size_t after = anonymous_bytes();
    MESSAGE("held for ", connections, " connections: ", after > before ? after - before : 0);
    CHECK(after < before + kMost);
    CHECK(answers_ping(page));
  }
  CHECK(descriptors() == open_before);
}

}  // namespace
}  // namespace hapticd::test
