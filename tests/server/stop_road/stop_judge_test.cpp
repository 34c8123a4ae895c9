// The Stop road's judge in virtual time: what stops, what does nothing, and what it costs. Peers
// without the key forge, repeat, cut and flip; only a Stop that is new and true stops.
#include "server/stop_road/stop_judge.h"

#include <doctest/doctest.h>
#include <sodium.h>

#include <initializer_list>
#include <vector>

#include "proto/stop/stop_call.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using stop::Code;
using stop::Datagram;
using stop::Kind;
using stop::Latch;
using stop::StopCall;
using State = StopCall::State;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint16_t kSessionPort = 47800;

StopPeer peer(std::uint8_t last, bool loopback, std::uint16_t port = 5000) {
  StopPeer made;
  made.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 10, 0, 0, last};
  made.port = port;
  made.loopback = loopback;
  return made;
}

/// A judge with a key, and a loop that ticks when it is told to.
struct Road {
  explicit Road(bool keyed = true, std::uint8_t secret = 3) {
    REQUIRE(sodium_init() >= 0);
    key.fill(0x5a);
    rules.session_port = kSessionPort;
    rules.secret.fill(secret);
    if (keyed) rules.key = stop::SecretKey(key);
    judge.emplace(rules, line);
  }

  std::optional<Datagram> hear(const Datagram& datagram, const StopPeer& from) {
    return judge->receive(datagram, from, now_ns);
  }
  std::optional<stop::Answer> ask(Datagram datagram, const StopPeer& from, bool sealed = true) {
    if (sealed) stop::seal(datagram, key);
    const auto answer = hear(datagram, from);
    return answer ? stop::parse_answer(*answer) : std::nullopt;
  }
  /// What a tick of the loop does with the line; whether it latched a Stop.
  bool tick() {
    const bool stopped = line.take();
    if (stopped) state = LoopState::kFault;
    now_ns += kMs;
    line.tell(++number, state, stopped ? Cause::kStopped : Cause::kNone);
    return stopped;
  }
  void clear() {
    state = LoopState::kEngaged;
    line.note_clear();
    tick();
  }

  stop::Key key{};
  StopRules rules;
  StopLine line;
  std::optional<StopJudge> judge;
  std::int64_t now_ns = 77'000 * kMs;
  LoopState state = LoopState::kEngaged;
  std::uint64_t number = 0;
};

/// A Stop under the key, asked until the daemon has it; the datagrams that were sent.
std::vector<Datagram> stop_with_key(Road& road, const StopPeer& from, std::uint64_t client = 9) {
  StopCall call(Kind::kStop, {kSessionPort, stop::SecretKey(road.key)}, client);
  std::vector<Datagram> sent;
  for (int k = 0; k < 10 && call.state() == State::kAsking; ++k) {
    sent.push_back(call.next());
    if (const auto answer = road.hear(sent.back(), from)) call.receive(*answer);
    road.tick();
  }
  CHECK(call.state() == State::kDone);
  CHECK(call.asked());
  return sent;
}

TEST_CASE("on loopback one datagram in the clear stops, and the answer says how far it has come") {
  Road road(false);
  StopCall call(Kind::kStop, {kSessionPort, std::nullopt}, 1);
  const auto asked = road.hear(call.next(), peer(1, true));
  REQUIRE(asked);
  CHECK(stop::parse_answer(*asked)->latch == Latch::kAsked);
  CHECK(call.receive(*asked));
  CHECK(call.asked());
  CHECK(road.tick());
  const auto latched = road.hear(call.next(), peer(1, true));
  REQUIRE(latched);
  CHECK(call.receive(*latched));
  CHECK(call.state() == State::kDone);
  CHECK(stop::parse_answer(*latched)->latch == Latch::kLatched);
  CHECK(stop::parse_answer(*latched)->cause == 1);
  CHECK(stop::parse_answer(*latched)->tick == 1);
  CHECK(road.judge->counters().stops.value() == 1);
}

TEST_CASE(
    "from elsewhere a Stop needs the key, and two datagrams, or one with a challenge in hand") {
  Road road;
  const StopPeer far = peer(2, false);
  CHECK_FALSE(road.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 1, {}}), far, false));
  CHECK_FALSE(road.line.waits());
  CHECK(stop_with_key(road, far).size() <= 3);
  road.clear();
  const auto known = road.ask(stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 2, {}}), far);
  REQUIRE(known);
  const auto done =
      road.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 3, known->challenge}), far);
  REQUIRE(done);
  CHECK(done->code == Code::kDone);
  CHECK(done->latch == Latch::kAsked);
}

TEST_CASE("a daemon without the key hears nobody from elsewhere, and no heartbeat") {
  Road road(false);
  CHECK_FALSE(road.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 1, {}}), peer(2, false)));
  const auto beat = road.ask(stop::encode(stop::Request{Kind::kHeartbeat, 0, 100, 4, 1, {}}),
                             peer(1, true), false);
  REQUIRE(beat);
  CHECK(beat->code == Code::kKeyNeeded);
  CHECK_FALSE(road.line.lets_go(road.now_ns + 10'000 * kMs));
}

TEST_CASE("every datagram of a Stop that was recorded does nothing when it is played again") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  Road road;
  std::vector<std::pair<Datagram, StopPeer>> recorded;
  for (int round = 0; round < scaled(2000); ++round) {
    const StopPeer from = peer(static_cast<std::uint8_t>(random.below(4)), false,
                               static_cast<std::uint16_t>(1000 + random.below(3)));
    for (const Datagram& sent : stop_with_key(road, from, 1 + random.below(5))) {
      recorded.emplace_back(sent, from);
    }
    road.clear();
    for (int k = 0; k < 20; ++k) {
      // The newest are the likeliest to be taken for new.
      const std::uint64_t back = random.below(1 + random.below(recorded.size()));
      const auto& [datagram, first_from] = recorded[recorded.size() - 1 - back];
      road.hear(datagram, random.chance(0.8) ? first_from : peer(9, random.chance(0.5)));
      REQUIRE_FALSE(road.line.waits());
      road.now_ns += static_cast<std::int64_t>(random.below(1'500'000'000));
    }
  }
}

TEST_CASE("what another daemon, or an earlier start, was told does nothing here") {
  Road here(true, 1);
  Road there(true, 2);
  const StopPeer from = peer(2, false);
  const auto known = there.ask(stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 1, {}}), from);
  REQUIRE(known);
  // Here challenges as new as that one have been given.
  here.now_ns = there.now_ns + kMs;
  REQUIRE(here.ask(stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 1, {}}), from));
  const auto refused =
      here.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 2, known->challenge}), from);
  REQUIRE(refused);
  CHECK(refused->code == Code::kChallenge);
  CHECK_FALSE(here.line.waits());
  CHECK(here.judge->counters().replayed.value() == 1);
}

TEST_CASE("a challenge is good for a second") {
  for (const std::int64_t late_ms : {0, 999, 1000, 1001, 5000}) {
    Road road;
    const StopPeer from = peer(2, false);
    const auto known = road.ask(stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 1, {}}), from);
    REQUIRE(known);
    road.now_ns += late_ms * kMs;
    const auto answer =
        road.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 2, known->challenge}), from);
    REQUIRE(answer);
    CHECK((answer->code == Code::kDone) == (late_ms <= 1000));
    CHECK(road.line.waits() == (late_ms <= 1000));
  }
}

TEST_CASE("a Stop for another daemon is left alone, and not reported as done") {
  Road road;
  REQUIRE((road.line.ask(), road.tick()));
  for (const bool sealed : {false, true}) {
    const auto answer =
        road.ask(stop::encode(stop::Request{Kind::kStop, kSessionPort + 90, 0, 4, 1, {}}),
                 peer(1, true), sealed);
    REQUIRE(answer);
    CHECK(answer->code == Code::kOtherDaemon);
    CHECK(answer->latch == Latch::kNone);
    CHECK(answer->session_port == kSessionPort);
    CHECK_FALSE(road.line.waits());
  }
  CHECK(road.judge->counters().other_daemon.value() == 2);
}

TEST_CASE("nothing but a whole and true Stop stops: cut, flipped, forged and random ones do not") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  Road road;
  const StopPeer from = peer(2, false);
  const auto some = [&](std::size_t bytes) {
    std::vector<std::uint8_t> made(bytes);
    for (std::uint8_t& byte : made) byte = static_cast<std::uint8_t>(random.next());
    return made;
  };
  for (int k = 0; k < scaled(300'000); ++k) {
    const auto known = road.ask(stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 1, {}}), from);
    REQUIRE(known);
    Datagram good = stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 2, known->challenge});
    stop::seal(good, road.key);
    std::vector<std::uint8_t> bad(good.begin(), good.end());
    switch (random.below(5)) {
      case 0:
        bad.resize(random.below(stop::kDatagramBytes));
        break;
      case 1:
        bad[random.below(bad.size())] ^= static_cast<std::uint8_t>(1U << random.below(8));
        break;
      case 2:
        bad = some(random.below(200));
        break;
      case 3: {
        stop::Key other{};
        for (std::uint8_t& byte : other) byte = static_cast<std::uint8_t>(random.next());
        stop::seal(good, other);
        bad.assign(good.begin(), good.end());
        break;
      }
      default:
        bad.push_back(0);
        break;
    }
    const auto answer = road.judge->receive(bad, from, road.now_ns);
    REQUIRE_FALSE(road.line.waits());
    REQUIRE_FALSE(answer);
    REQUIRE_FALSE(road.line.lets_go(road.now_ns + 10'000 * kMs));
  }
  const StopCounters& counters = road.judge->counters();
  CHECK(counters.malformed.value() + counters.unauthenticated.value() +
            counters.challenged.value() + static_cast<std::uint64_t>(scaled(300'000)) ==
        counters.received.value());
  CHECK(counters.stops.value() == 0);
}

TEST_CASE("fields that must be 0 are") {
  Road road;
  const Datagram good = stop::encode(stop::Request{Kind::kStop, 0, 0, 4, 1, {}});
  // Code, time-out, and what only answers have.
  for (const std::size_t at :
       std::initializer_list<std::size_t>{3, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}) {
    Datagram bad = good;
    bad[at] = 1;
    CAPTURE(at);
    CHECK_FALSE(road.hear(bad, peer(1, true)));
    CHECK_FALSE(road.line.waits());
  }
  for (const std::size_t zeroed : std::initializer_list<std::size_t>{16, 24}) {
    Datagram bad = good;
    bad[zeroed] = 0;
    CHECK_FALSE(road.hear(bad, peer(1, true)));
  }
  CHECK(road.hear(good, peer(1, true)));
}

/// A client that beats with the newest challenge.
struct DeadMan {
  std::optional<stop::Answer> beat(Road& road, std::uint16_t timeout_ms,
                                   Kind kind = Kind::kHeartbeat) {
    for (int k = 0; k < 2; ++k) {
      const std::uint16_t chosen = kind == Kind::kHeartbeat ? timeout_ms : std::uint16_t{0};
      Datagram datagram = stop::encode(stop::Request{kind, 0, chosen, id, ++number, challenge});
      stop::seal(datagram, road.key);
      sent.push_back(datagram);
      const auto answer = road.hear(datagram, from);
      if (!answer) return std::nullopt;
      last = stop::parse_answer(*answer);
      challenge = last->challenge;
      if (last->code != Code::kChallenge) break;
    }
    return last;
  }

  std::uint64_t id = 1;
  StopPeer from = peer(2, false);
  std::uint64_t number = 0;
  stop::Challenge challenge;
  std::optional<stop::Answer> last;
  std::vector<Datagram> sent;
};

TEST_CASE("a heartbeat holds the force on for as long as it says, from when it came") {
  for (const std::uint16_t timeout_ms : std::initializer_list<std::uint16_t>{50, 51, 333, 1000}) {
    Road road;
    DeadMan man;
    REQUIRE(man.beat(road, timeout_ms)->code == Code::kDone);
    CHECK(man.last->heartbeats == 1);
    CHECK_FALSE(road.line.lets_go(road.now_ns + timeout_ms * kMs));
    CHECK(road.line.lets_go(road.now_ns + timeout_ms * kMs + 1));
  }
  for (const std::uint16_t timeout_ms :
       std::initializer_list<std::uint16_t>{0, 1, 49, 1001, 65535}) {
    Road road;
    DeadMan man;
    CHECK(man.beat(road, timeout_ms)->code == Code::kOutOfRange);
    CHECK_FALSE(road.line.lets_go(road.now_ns + 100'000 * kMs));
  }
}

TEST_CASE("all dead-men have to be alive; one that leaves is not missed") {
  Road road;
  std::array<DeadMan, kMaxHeartbeats> men;
  for (std::size_t k = 0; k < men.size(); ++k) {
    men[k].id = 10 + k;
    REQUIRE(men[k].beat(road, static_cast<std::uint16_t>(100 + 100 * k))->code == Code::kDone);
  }
  DeadMan late;
  late.id = 99;
  CHECK(late.beat(road, 100)->code == Code::kFull);
  CHECK(road.judge->counters().full.value() == 1);
  CHECK(road.line.lets_go(road.now_ns + 101 * kMs));
  REQUIRE(men[0].beat(road, 0, Kind::kLeave)->code == Code::kDone);
  CHECK_FALSE(road.line.lets_go(road.now_ns + 101 * kMs));
  CHECK(road.line.lets_go(road.now_ns + 201 * kMs));
}

TEST_CASE("heartbeats that were recorded hold nothing on, and bring nobody back") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int round = 0; round < scaled(1000); ++round) {
    Road road;
    DeadMan man;
    for (std::uint64_t k = 0; k < 1 + random.below(20); ++k) {
      REQUIRE(man.beat(road, static_cast<std::uint16_t>(50 + random.below(951)))->code ==
              Code::kDone);
      road.now_ns += static_cast<std::int64_t>(random.below(40'000'000));
    }
    const bool leaves = random.chance(0.5);
    if (leaves) {
      REQUIRE(man.beat(road, 0, Kind::kLeave)->code == Code::kDone);
    }
    for (int k = 0; k < 100; ++k) {
      road.hear(man.sent[random.below(man.sent.size())], man.from);
      road.now_ns += static_cast<std::int64_t>(random.below(100'000'000));
      if (leaves) REQUIRE_FALSE(road.line.lets_go(road.now_ns + 1'000'000 * kMs));
    }
    if (leaves) continue;
    road.now_ns += 1000 * kMs;
    CHECK(road.line.lets_go(road.now_ns));
    // A Clear lets go of it for good.
    road.clear();
    road.judge->look(road.now_ns);
    CHECK_FALSE(road.line.lets_go(road.now_ns + 1'000'000 * kMs));
    for (const Datagram& sent : man.sent) road.hear(sent, man.from);
    CHECK_FALSE(road.line.lets_go(road.now_ns + 1'000'000 * kMs));
  }
}

TEST_CASE("a heartbeat that was withheld on the way for longer than its time-out does not count") {
  Road road;
  DeadMan man;
  REQUIRE(man.beat(road, 50)->code == Code::kDone);
  Datagram withheld =
      stop::encode(stop::Request{Kind::kHeartbeat, 0, 50, man.id, ++man.number, man.challenge});
  stop::seal(withheld, road.key);
  road.now_ns += 51 * kMs;
  const auto answer = road.hear(withheld, man.from);
  REQUIRE(answer);
  CHECK(stop::parse_answer(*answer)->code == Code::kChallenge);
  CHECK(road.line.lets_go(road.now_ns));
}

TEST_CASE("a Stop wins over one that the loop has not told of, and over none that it has") {
  Road road(false);
  const auto stop = [&] {
    static std::uint64_t number = 0;
    return road.ask(stop::encode(stop::Request{Kind::kStop, 0, 0, 4, ++number, {}}), peer(1, true),
                    false);
  };
  for (int k = 0; k < 5; ++k) CHECK(stop()->latch == Latch::kAsked);
  CHECK(road.tick());
  CHECK_FALSE(road.tick());
  road.clear();
  CHECK_FALSE(road.tick());
  CHECK(stop()->latch == Latch::kAsked);
  CHECK(road.tick());
}

TEST_CASE("judging leaves the heap alone, and no answer is longer than its question") {
  Road road;
  const StopPeer from = peer(2, false);
  Datagram query = stop::encode(stop::Request{Kind::kQuery, 0, 0, 4, 1, {}});
  stop::seal(query, road.key);
  Datagram beat = stop::encode(stop::Request{Kind::kHeartbeat, 0, 100, 4, 2, {}});
  stop::seal(beat, road.key);
  const NoHeapScope scope;
  const auto known = road.judge->receive(query, from, road.now_ns);
  const auto other = road.judge->receive(beat, from, road.now_ns);
  road.judge->look(road.now_ns);
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK(known.has_value());
  CHECK(other.has_value());
  static_assert(sizeof(*known) == stop::kDatagramBytes);
}

}  // namespace
}  // namespace hapticd::test
