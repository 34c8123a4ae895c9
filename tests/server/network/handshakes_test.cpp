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
  std::uint64_t clients = 1000;  ///< seeds of those that welcomed() made

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
  for (const std::uint8_t role : {kViewRole, kControlRole, kOldViewRole, kOldControlRole}) {
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

TEST_CASE("of HELLOs by NNpsk0 1000 a second cost their hashes, and a new client is in at once") {
  Desk desk;
  const KeyedClient good(kControlRole);
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    desk.now_ns += kSecond_ns / 100'000;
    const auto last = static_cast<std::uint8_t>(i);
    const std::uint8_t role = i % 2 == 0 ? kOldViewRole : kOldControlRole;
    CHECK(desk.say(ipv4_address({10, 0, 1, last}, 5000),
                   KeyedClient(role, i % 50, noise::Key{}).hello())
              .empty());
  }
  const HelloCounters& counters = desk.handshakes.counters();
  CHECK(counters.forged >= 1000);
  CHECK(counters.forged <= 1000 + 100);
  CHECK(counters.forged + counters.limited == 100'000);
  const noise::Bytes retry = desk.say(kHere, good.hello());
  REQUIRE(retry.size() > 16);
  CHECK(desk.say(kHere, good.hello({retry.begin() + 16, retry.end()})).at(2) == 3);
}

TEST_CASE("what is no HELLO under a key of the server is not answered") {
  Desk desk;
  const KeyedClient client(kControlRole);
  const noise::Bytes good = client.hello();
  std::vector<noise::Bytes> bad;
  bad.push_back(KeyedClient(kControlRole, 1, view_key()).hello());
  bad.push_back(KeyedClient(kViewRole, 1, control_key_of_tests()).hello());
  bad.push_back(KeyedClient(kControlRole, 1, noise::Key{}).hello());
  bad.push_back(KeyedClient(5).hello());
  bad.push_back(KeyedClient(0).hello());
  bad.emplace_back(good.begin(), good.end() - 1);
  bad.emplace_back(good.begin(), good.begin() + 16 + 2 + 8 + 48 + 16);
  // Header, role and cookie; key id, ephemeral key and tag of message 1; tag of the HELLO.
  for (const std::size_t byte :
       {0U, 1U, 2U, 3U, 4U, 8U, 15U, 16U, 17U, 18U, 25U, 26U, 57U, 58U, 73U, 74U, 89U}) {
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

TEST_CASE("a HELLO that is refused costs no ephemeral key, and so no scalar multiplication") {
  std::size_t drawn = 0;
  const auto bytes = seeded_bytes(4);
  const auto counting = [&](std::span<std::uint8_t> into) {
    drawn += into.size();
    bytes(into);
  };
  Handshakes handshakes(test_keys(), counting);
  const KeyedClient client(kControlRole);
  std::int64_t now_ns = 1000 * kSecond_ns;
  const noise::Bytes retry = handshakes.receive(kHere, client.hello(), now_ns);
  REQUIRE(retry.size() > 16);
  const noise::Bytes good = client.hello({retry.begin() + 16, retry.end()});
  const std::size_t before = drawn;
  // What is after the tag means nothing.
  for (std::size_t byte = 16; byte < 16 + 2 + 48 + 8 + 48 + 16; ++byte) {
    noise::Bytes bad = good;
    bad[byte] ^= 1U;
    now_ns += kRest_ns / 100;
    CHECK(handshakes.receive(kHere, bad, now_ns).empty());
  }
  CHECK(drawn == before);
  CHECK(handshakes.counters().forged > 100);
  CHECK(handshakes.receive(kHere, good, now_ns).at(2) == 3);
  CHECK(drawn > before);
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

/// Handshakes of fresh keys that get a WELCOME, from addresses that `from` gives.
template <typename From>
int welcomed(Desk& desk, const From& from, int count, std::int64_t every_ns) {
  int sum = 0;
  for (int i = 0; i < count; ++i) {
    const KeyedClient client(kControlRole, ++desk.clients);
    const noise::Bytes retry = desk.say(from(i), client.hello());
    REQUIRE(retry.size() > 16);
    const noise::Bytes answer = desk.say(from(i), client.hello({retry.begin() + 16, retry.end()}));
    sum += answer.empty() ? 0 : 1;
    desk.now_ns += every_ns;
    desk.handshakes.expire(desk.now_ns);
  }
  return sum;
}

TEST_CASE("of one address that has proved itself 5 handshakes at once and 20 a second are made") {
  Desk desk;
  const auto here = [](int port) {
    return ipv4_address({10, 0, 0, 1}, static_cast<std::uint16_t>(port));
  };
  CHECK(welcomed(desk, here, 20, 0) == 5);
  CHECK(welcomed(
            desk,
            [](int) {
              return ipv4_address({10, 0, 0, 2}, 9);
            },
            10, 0) == 5);
  desk.now_ns += 4 * kSecond_ns;
  const int in_ten_seconds = welcomed(desk, here, 500, kSecond_ns / 50);
  CHECK(in_ten_seconds >= 5 + 190);
  CHECK(in_ten_seconds <= 5 + 200);
}

TEST_CASE("an IPv6 network of 64 bits counts as one address") {
  Desk desk;
  const auto network = [](int i) {
    Address from;
    from.ip = {0x20, 0x01, 0x0d, 0xb8};
    from.ip[15] = static_cast<std::uint8_t>(i);
    from.ip[8] = static_cast<std::uint8_t>(i * 3);
    return from;
  };
  CHECK(welcomed(desk, network, 40, 0) == 5);
  const auto other = [&](int i) {
    Address from = network(i);
    from.ip[7] = 1;
    return from;
  };
  CHECK(welcomed(desk, other, 1, 0) == 1);
}

TEST_CASE("one handshake gets 5 RETRYs at once and 20 a second, whoever else asks for more") {
  Desk desk;
  const noise::Bytes hello = KeyedClient(kControlRole).hello();
  int answered = 0;
  for (int i = 0; i < 1000; ++i) answered += desk.say(kHere, hello).empty() ? 0 : 1;
  CHECK(answered == 5);
  CHECK(!desk.say(kHere, KeyedClient(kControlRole, 2).hello()).empty());
  CHECK(!desk.say(ipv4_address({10, 0, 0, 1}, 5001), hello).empty());
}

TEST_CASE("of the view key's handshakes that wait one address has a quarter at most") {
  Desk desk;
  int views = 0;
  for (int i = 0; i < 40; ++i) {
    desk.now_ns += kSecond_ns / 20;
    const KeyedClient client(kViewRole, static_cast<std::uint64_t>(100 + i));
    const noise::Bytes retry = desk.say(kHere, client.hello());
    const noise::Bytes answer = desk.say(kHere, client.hello({retry.begin() + 16, retry.end()}));
    views += answer.empty() ? 0 : 1;
  }
  CHECK(views == 12);
  const KeyedClient operating(kControlRole, 3);
  CHECK(desk.say(kHere, operating.hello(desk.cookie(kHere, operating))).at(2) == 3);
}

TEST_CASE("a RETRY is signed for the client's handshake, and for no other") {
  Desk desk;
  const KeyedClient client(kControlRole, 1);
  const noise::Bytes body = desk.cookie(kHere, client);
  const noise::Bytes prologue = client.prologue();
  const noise::Key key = control_key_of_tests();
  CHECK(noise::is_tagged_retry(key, prologue, client.message(), body));
  CHECK(!noise::is_tagged_retry(view_key(), prologue, client.message(), body));
  CHECK(!noise::is_tagged_retry(key, prologue, KeyedClient(kControlRole, 2).message(), body));
  for (std::size_t bit = 0; bit < 8 * body.size(); ++bit) {
    noise::Bytes bad = body;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    CHECK(!noise::is_tagged_retry(key, prologue, client.message(), bad));
  }
  for (std::size_t bytes = 0; bytes < body.size(); ++bytes) {
    CHECK(!noise::is_tagged_retry(key, prologue, client.message(), std::span(body).first(bytes)));
  }
}

}  // namespace
}  // namespace hapticd::test
