// Which HELLOs a server answers, and with what. PROTOCOL.md, section 12.
#include "server/network/handshakes.h"

#include <doctest/doctest.h>

#include "tests/server/network/keyed_peer.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// Long enough for a bucket of HELLOs to be full again, ns.
constexpr std::int64_t kRest_ns = kSecond_ns;

const Address kHere = ipv4_address({10, 0, 0, 1}, 5000);

/// The server's side, with a clock.
struct Desk {
  Handshakes handshakes{test_keys(), seeded_bytes(4)};
  std::int64_t now_ns = 1000 * kSecond_ns;

  noise::Bytes say(const Address& from, const noise::Bytes& datagram) {
    return handshakes.receive(from, datagram, now_ns);
  }
  /// The cookie for a client at an address, after a rest.
  noise::Bytes cookie(const Address& from, const KeyedClient& client) {
    now_ns += kRest_ns;
    const noise::Bytes retry = say(from, client.hello());
    REQUIRE(retry.size() > 16);
    REQUIRE(retry[2] == 2);
    return {retry.begin() + 16, retry.end()};
  }
};

TEST_CASE("a HELLO gets a RETRY and leaves no trace; with its cookie it gets a WELCOME") {
  for (const std::uint8_t role : {kViewRole, kControlRole}) {
    Desk desk;
    KeyedClient client(role);
    const noise::Bytes cookie = desk.cookie(kHere, client);
    CHECK(cookie.size() >= 1);
    CHECK(cookie.size() <= 64);
    CHECK(desk.handshakes.half_open() == 0);
    const noise::Bytes welcome = desk.say(kHere, client.hello(cookie));
    CHECK(client.welcome(welcome));
    CHECK(client.session() != 0);
    CHECK(desk.handshakes.half_open() == 1);
    CHECK(desk.handshakes.find(kHere, client.session()) != nullptr);
  }
}

TEST_CASE("what is no HELLO under a key of the server is not answered") {
  Desk desk;
  const KeyedClient client(kControlRole);
  const noise::Bytes good = client.hello();
  std::vector<noise::Bytes> bad;
  bad.push_back(KeyedClient(kControlRole, 1, test_keys().view).hello());
  bad.push_back(KeyedClient(kViewRole, 1, test_keys().control).hello());
  bad.push_back(KeyedClient(kControlRole, 1, noise::Key{}).hello());
  bad.push_back(KeyedClient(3).hello());
  bad.push_back(KeyedClient(0).hello());
  bad.emplace_back(good.begin(), good.end() - 1);
  bad.emplace_back(good.begin(), good.begin() + 16 + 2 + 48);
  for (const std::size_t byte : {0U, 1U, 2U, 3U, 4U, 8U, 15U, 16U, 17U, 18U, 50U, 65U}) {
    bad.push_back(good);
    bad.back()[byte] ^= 1U;
  }
  bad.push_back(good);
  bad.back()[17] = 65;
  for (const noise::Bytes& each : bad) {
    desk.now_ns += kRest_ns;
    CHECK(desk.say(kHere, each).empty());
  }
  CHECK(!desk.cookie(kHere, client).empty());
}

TEST_CASE("a cookie is good for its address, port and ephemeral key alone") {
  Desk desk;
  const KeyedClient client(kControlRole, 1);
  const KeyedClient other(kControlRole, 2);
  const noise::Bytes cookie = desk.cookie(kHere, client);
  const auto kind_of_answer = [&](const Address& from, const noise::Bytes& datagram) {
    desk.now_ns += kRest_ns;
    return int{desk.say(from, datagram).at(2)};
  };
  CHECK(kind_of_answer(ipv4_address({10, 0, 0, 2}, 5000), client.hello(cookie)) == 2);
  CHECK(kind_of_answer(ipv4_address({10, 0, 0, 1}, 5001), client.hello(cookie)) == 2);
  CHECK(kind_of_answer(kHere, other.hello(cookie)) == 2);
  noise::Bytes damaged = cookie;
  damaged.back() ^= 1U;
  CHECK(kind_of_answer(kHere, client.hello(damaged)) == 2);
  damaged = cookie;
  damaged.pop_back();
  CHECK(kind_of_answer(kHere, client.hello(damaged)) == 2);
  CHECK(desk.handshakes.half_open() == 0);
  CHECK(kind_of_answer(kHere, client.hello(cookie)) == 3);
}

TEST_CASE("a cookie outlives one change of the secret, not two") {
  Desk desk;
  KeyedClient client(kControlRole);
  const noise::Bytes cookie = desk.cookie(kHere, client);
  desk.now_ns += 119 * kSecond_ns;
  (void)desk.cookie(kHere, client);  // By now the secret has changed once.
  CHECK(desk.say(kHere, client.hello(cookie)).at(2) == 3);
  desk.now_ns += 121 * kSecond_ns;
  CHECK(desk.say(kHere, client.hello(cookie)).at(2) == 2);
  const noise::Bytes late = desk.cookie(kHere, client);
  desk.now_ns += 1000 * kSecond_ns;
  CHECK(desk.say(kHere, client.hello(late)).at(2) == 2);
}

TEST_CASE("a repeated HELLO gets the same WELCOME, byte for byte, also when the session lives") {
  Desk desk;
  KeyedClient client(kControlRole);
  const noise::Bytes cookie = desk.cookie(kHere, client);
  const noise::Bytes welcome = desk.say(kHere, client.hello(cookie));
  CHECK(desk.say(kHere, client.hello(cookie)) == welcome);
  REQUIRE(client.welcome(welcome));
  desk.handshakes.establish(client.session());
  CHECK(desk.handshakes.half_open() == 0);
  CHECK(desk.handshakes.find(kHere, client.session()) == nullptr);
  desk.now_ns += 60 * kSecond_ns;
  desk.handshakes.expire(desk.now_ns);
  CHECK(desk.say(kHere, client.hello(cookie)) == welcome);
  desk.handshakes.forget(client.session());
  desk.now_ns += kRest_ns;
  CHECK(desk.say(kHere, client.hello(cookie)) != welcome);
}

TEST_CASE("64 handshakes wait, 3 s each; the next is answered when one is over") {
  Desk desk;
  const auto from = [](std::size_t i) {
    return ipv4_address({10, 0, 1, static_cast<std::uint8_t>(i)}, 5000);
  };
  std::vector<noise::Bytes> hellos;
  for (std::size_t i = 0; i < 65; ++i) {
    const KeyedClient client(kControlRole, i);
    const noise::Bytes retry = desk.say(from(i), client.hello());
    hellos.push_back(client.hello({retry.begin() + 16, retry.end()}));
  }
  for (std::size_t i = 0; i < 64; ++i) CHECK(desk.say(from(i), hellos[i]).at(2) == 3);
  CHECK(desk.handshakes.half_open() == 64);
  CHECK(desk.say(from(64), hellos[64]).empty());
  desk.now_ns += 3 * kSecond_ns - 1;
  CHECK(desk.say(from(64), hellos[64]).empty());
  desk.now_ns += 1;
  CHECK(desk.say(from(64), hellos[64]).at(2) == 3);
  CHECK(desk.handshakes.half_open() == 1);
}

TEST_CASE("of one address 5 HELLOs at once and 20 a second are looked at") {
  Desk desk;
  const noise::Bytes hello = KeyedClient(kControlRole).hello();
  const auto answered = [&](const Address& from, int count, std::int64_t every_ns) {
    int sum = 0;
    for (int i = 0; i < count; ++i) {
      sum += desk.say(from, hello).empty() ? 0 : 1;
      desk.now_ns += every_ns;
    }
    return sum;
  };
  CHECK(answered(kHere, 100, 0) == 5);
  CHECK(answered(ipv4_address({10, 0, 0, 1}, 9), 10, 0) == 0);
  CHECK(answered(ipv4_address({10, 0, 0, 2}, 9), 10, 0) == 5);
  desk.now_ns += kRest_ns;
  const int in_ten_seconds = answered(kHere, 10'000, 1'000'000);
  CHECK(in_ten_seconds >= 5 + 199);
  CHECK(in_ten_seconds <= 5 + 200);
}

TEST_CASE("an IPv6 network of 64 bits counts as one address") {
  Desk desk;
  const noise::Bytes hello = KeyedClient(kControlRole).hello();
  Address from;
  from.ip = {0x20, 0x01, 0x0d, 0xb8};
  int answered = 0;
  for (std::uint8_t i = 0; i < 100; ++i) {
    from.ip[15] = i;
    from.ip[8] = static_cast<std::uint8_t>(i * 3);
    answered += desk.say(from, hello).empty() ? 0 : 1;
  }
  CHECK(answered == 5);
  from.ip[7] = 1;
  CHECK(!desk.say(from, hello).empty());
}

}  // namespace
}  // namespace hapticd::test
