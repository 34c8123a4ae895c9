// A client shakes hands while others flood the server in its name: with what they made up, with
// what they have seen of it, and from anywhere. Virtual time. PROTOCOL.md, section 12.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "tests/server/network/keyed_peer.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// 100 000 datagrams a second.
constexpr std::int64_t kEvery_ns = kSecond_ns / 100'000;
/// A client says HELLO again after this.
constexpr std::int64_t kRepeat_ns = kSecond_ns / 4;

const Address kVictim = ipv4_address({10, 0, 0, 1}, 5000);

/// Somebody who sees everything that the victim sends, and can send in everyone's name.
class Flood {
 public:
  explicit Flood(std::uint64_t seed) : random_(seed) {}

  void sees(const noise::Bytes& datagram) { seen_.push_back(datagram); }
  /// A datagram and whom it seems to come from.
  std::pair<Address, noise::Bytes> next() { return {source(), datagram()}; }

 private:
  Address source() {
    const std::uint64_t kind = random_.below(3);
    if (kind == 0) return kVictim;
    Address from = kVictim;
    from.port = static_cast<std::uint16_t>(random_.next());
    if (kind == 1) return from;
    for (std::size_t i = 12; i < 16; ++i) from.ip[i] = byte();
    return from;
  }
  noise::Bytes datagram() {
    if (!seen_.empty() && random_.below(4) == 0) return seen_[random_.below(seen_.size())];
    noise::Bytes bytes = raw_header(1, 0, 0);
    bytes.push_back(static_cast<std::uint8_t>(1 + random_.below(4)));
    const std::uint64_t cookie = random_.below(2) == 0 ? 0 : random_.below(65);
    bytes.push_back(static_cast<std::uint8_t>(cookie));
    for (std::uint64_t i = 0; i < cookie + 72; ++i) bytes.push_back(byte());
    bytes.resize(random_.below(10) == 0 ? random_.below(1200) : 1200);
    return bytes;
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_.next() >> 56U); }

  SplitMix64 random_;
  std::vector<noise::Bytes> seen_;
};

/// The victim as a client is: HELLO again every 250 ms, and at once after a RETRY.
class Victim {
 public:
  Victim(Handshakes& handshakes, Flood& flood, std::uint64_t seed)
      : client_(kControlRole, seed), handshakes_(handshakes), flood_(flood) {}

  /// Says what is due; true once it is in.
  bool pass(std::int64_t now_ns) {
    if (now_ns < due_ns_) return false;
    due_ns_ = now_ns + kRepeat_ns;
    const noise::Bytes hello = client_.hello(cookie_);
    flood_.sees(hello);
    return hears(handshakes_.receive(kVictim, hello, now_ns));
  }
  /// An answer to its address, to whomever it was; true once it is in.
  bool hears(const noise::Bytes& answer) {
    if (answer.size() > 16 && answer[2] == 2) {
      // Those for its earlier handshakes are not for this one.
      const noise::Bytes cookie(answer.begin() + 16, answer.end());
      const bool mine = noise::is_tagged_retry(control_key_of_tests(), client_.prologue(),
                                               client_.message(), cookie);
      if (mine && cookie != cookie_) due_ns_ = 0;
      if (mine) cookie_ = cookie;
    }
    return client_.welcome(answer);
  }
  [[nodiscard]] std::uint32_t session() const { return client_.session(); }

 private:
  KeyedClient client_;
  Handshakes& handshakes_;
  Flood& flood_;
  noise::Bytes cookie_;
  std::int64_t due_ns_ = 0;
};

/// Time of a handshake beside the flood, ns; beyond 2 s it has failed.
std::int64_t handshake_ns(Handshakes& handshakes, Flood& flood, Victim& victim,
                          std::int64_t& now_ns) {
  const std::int64_t begin_ns = now_ns;
  for (; now_ns - begin_ns < 2 * kSecond_ns; now_ns += kEvery_ns) {
    const auto [from, datagram] = flood.next();
    const noise::Bytes answer = handshakes.receive(from, datagram, now_ns);
    if (from == kVictim && victim.hears(answer)) break;
    if (victim.pass(now_ns)) break;
  }
  return now_ns - begin_ns;
}

TEST_CASE(
    "beside 100 000 HELLOs a second in its name a client with the key is in within a second") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  auto handshakes = std::make_unique<Handshakes>(test_keys(), seeded_bytes(seed + 1));
  Flood flood(seed);
  std::int64_t now_ns = 1000 * kSecond_ns;
  // Half a second of it, so that whatever can be spent is spent.
  for (int i = 0; i < 50'000; ++i, now_ns += kEvery_ns) {
    const auto [from, datagram] = flood.next();
    (void)handshakes->receive(from, datagram, now_ns);
  }
  CHECK(handshakes->half_open() == 0);
  for (std::uint64_t i = 0; i < 6; ++i) {
    CAPTURE(i);
    Victim victim(*handshakes, flood, seed + 10 + i);
    CHECK(handshake_ns(*handshakes, flood, victim, now_ns) < kSecond_ns);
    // Its session ends, and what was seen of it is sent on.
    handshakes->establish(victim.session());
    handshakes->forget(victim.session());
  }
  CHECK(handshakes->counters().forged > 20'000);
}

TEST_CASE("of many handshakes that somebody has seen few are made again, and a new one is made") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  auto handshakes = std::make_unique<Handshakes>(test_keys(), seeded_bytes(seed + 1));
  Flood quiet(seed);
  std::vector<noise::Bytes> seen;
  std::int64_t now_ns = 1000 * kSecond_ns;
  for (std::uint64_t i = 0; i < 300; ++i, now_ns += kSecond_ns / 10) {
    const KeyedClient client(kControlRole, seed + 10 + i);
    const noise::Bytes retry = handshakes->receive(kVictim, client.hello(), now_ns);
    REQUIRE(retry.size() > 16);
    seen.push_back(client.hello({retry.begin() + 16, retry.end()}));
    const noise::Bytes welcome = handshakes->receive(kVictim, seen.back(), now_ns);
    REQUIRE(welcome.at(2) == 3);
    std::uint32_t session = 0;
    for (std::size_t k = 8; k-- > 4;) session = session << 8U | welcome[k];
    handshakes->forget(session);
  }
  const std::uint64_t before = handshakes->counters().welcomed;
  const std::int64_t begin_ns = now_ns;
  SplitMix64 random(seed);
  Victim victim(*handshakes, quiet, seed + 1000);
  bool in = false;
  for (; now_ns - begin_ns < 5 * kSecond_ns; now_ns += kSecond_ns / 10'000) {
    const noise::Bytes answer =
        handshakes->receive(kVictim, seen[random.below(seen.size())], now_ns);
    in = in || victim.hears(answer) || (now_ns > begin_ns + kSecond_ns && victim.pass(now_ns));
    if (now_ns - begin_ns > 2 * kSecond_ns) CHECK(in);
  }
  CHECK(handshakes->counters().welcomed - before <= 1 + 5 * 4 + 4);
}

}  // namespace
}  // namespace hapticd::test
