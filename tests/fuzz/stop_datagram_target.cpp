// See stop_datagram_target.h.
#include "tests/fuzz/stop_datagram_target.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <vector>

#include "server/stop_road/stop_judge.h"

namespace hapticd::test {
namespace {

using stop::Answer;
using stop::Code;
using stop::Kind;
using stop::Latch;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint16_t kSessionPort = 47800;
constexpr std::size_t kChallengeAt = 32;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

StopPeer peer(std::uint8_t last, std::uint16_t port, bool loopback) {
  StopPeer made;
  made.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, last};
  if (!loopback) made.ip[12] = 10;
  made.port = port;
  made.loopback = loopback;
  return made;
}

/// A challenge, and to whom and when it was given.
struct Given {
  std::size_t sender = 0;
  std::uint64_t client = 0;
  stop::Challenge challenge;
  std::int64_t given_ns = 0;
  bool stops = true;  ///< no Stop under the key has been obeyed since
};

std::uint64_t number_at(const stop::Datagram& datagram, std::size_t at) {
  std::uint64_t number = 0;
  for (std::size_t k = 8; k-- > 0;) number = number << 8U | datagram[at + k];
  return number;
}

/// The judge, the loop behind it, and what is known of both.
class Road {
 public:
  explicit Road(bool keyed) : keyed_(keyed), judge_(rules(keyed), line_) {}

  void pass(std::int64_t ns) { now_ns_ += ns; }

  void tick(bool clear) {
    if (line_.take()) state_ = LoopState::kFault;
    if (clear) {
      state_ = LoopState::kEngaged;
      line_.note_clear();
    }
    line_.tell(++tick_, state_, Cause::kNone);
    judge_.look(now_ns_);
  }

  void send(std::vector<std::uint8_t> bytes, unsigned how) {
    const std::size_t sender = how & 3U;
    if (bytes.size() == stop::kDatagramBytes) dress(bytes, sender, how);
    sent_.push_back(bytes);
    if ((how & 192U) != 128U) hear(bytes, sender);
  }

  /// What somebody has overheard comes once more.
  void send_again(std::size_t which, unsigned how) {
    if (!sent_.empty()) hear(sent_[which % sent_.size()], how & 3U);
  }

  void hear(const std::vector<std::uint8_t>& bytes, std::size_t sender) {
    const StopCounters before = judge_.counters();
    const bool waited = line_.waits();
    const bool held = let_go();
    const auto answer = judge_.receive(bytes, peers_.at(sender), now_ns_);
    require(judge_.counters().received.value() == before.received.value() + 1, "it was not heard");
    const bool stopped = judge_.counters().stops.value() != before.stops.value();
    require(line_.waits() == (waited || stopped), "the line does not say what was obeyed");
    if (!answer) {
      require(!stopped && let_go() == held, "something was obeyed in silence");
      return;
    }
    obeyed_ = check_answer(bytes, sender, *answer, before) || obeyed_;
  }

  [[nodiscard]] bool finish() const {
    const StopCounters& counters = judge_.counters();
    const std::uint64_t named = counters.malformed.value() + counters.unauthenticated.value() +
                                counters.replayed.value() + counters.challenged.value() +
                                counters.other_daemon.value() + counters.full.value() +
                                counters.stops.value() + counters.heartbeats.value();
    require(named <= counters.received.value(), "a datagram was counted twice");
    return obeyed_;
  }

 private:
  static const stop::Key& key() {
    static const stop::Key made = [] {
      stop::Key bytes;
      bytes.fill(0x5a);
      return bytes;
    }();
    return made;
  }

  static StopRules rules(bool keyed) {
    StopRules made;
    if (keyed) made.key = stop::SecretKey(key());
    made.session_port = kSessionPort;
    made.secret.fill(3);
    return made;
  }

  /// Whether force would be off because a heartbeat is missing, in a minute.
  [[nodiscard]] bool let_go() const { return line_.lets_go(now_ns_ + 60'000 * kMs); }

  /// Puts in what the fuzzer cannot know.
  void dress(std::vector<std::uint8_t>& bytes, std::size_t sender, unsigned how) const {
    stop::Datagram datagram;
    std::copy(bytes.begin(), bytes.end(), datagram.begin());
    const auto newest = std::find_if(given_.rbegin(), given_.rend(),
                                     [&](const Given& each) { return each.sender == sender; });
    if ((how & 8U) != 0 && newest != given_.rend()) {
      for (std::size_t k = 0; k < 8; ++k) {
        datagram[kChallengeAt + k] =
            static_cast<std::uint8_t>(newest->challenge.issued_ns >> (8 * k));
        datagram[kChallengeAt + 8 + k] =
            static_cast<std::uint8_t>(newest->challenge.proof >> (8 * k));
      }
    }
    if ((how & 4U) != 0) stop::seal(datagram, key());
    std::copy(datagram.begin(), datagram.end(), bytes.begin());
  }

  /// The challenge in the question if it is one that its sender was given.
  Given* known_challenge(const stop::Datagram& question, std::size_t sender) {
    const stop::Challenge challenge{number_at(question, kChallengeAt),
                                    number_at(question, kChallengeAt + 8)};
    const auto found = std::find_if(given_.begin(), given_.end(), [&](const Given& each) {
      return each.sender == sender && each.client == number_at(question, 16) &&
             each.challenge == challenge;
    });
    return found == given_.end() ? nullptr : &*found;
  }

  /// Whether the question was obeyed; an answer may not say so otherwise.
  bool check_answer(std::span<const std::uint8_t> bytes, std::size_t sender,
                    const stop::Datagram& said, const StopCounters& before) {
    require(bytes.size() >= said.size(), "an answer is longer than its question");
    stop::Datagram question;
    std::copy_n(bytes.begin(), question.size(), question.begin());
    const bool sealed = stop::is_sealed(question);
    require(sealed ? keyed_ && stop::opens(question, key()) : peers_.at(sender).loopback,
            "a stranger was answered");
    require(!sealed || stop::opens(said, key()), "an answer without the key");
    require(sealed || !stop::is_sealed(said), "an answer to nobody has a tag");
    const std::optional<Answer> answer = stop::parse_answer(said);
    require(answer.has_value(), "an answer that is none");
    require(said[2] == (question[2] | stop::kAnswerBit) &&
                answer->client == number_at(question, 16) &&
                answer->number == number_at(question, 24) && answer->session_port == kSessionPort,
            "an answer to something else");
    require(answer->code >= Code::kDone && answer->code <= Code::kUnknownKind, "no code");
    require(answer->heartbeats <= kMaxHeartbeats, "more heartbeats than there is room for");
    require(answer->code == Code::kOtherDaemon || (answer->latch == Latch::kAsked) == line_.waits(),
            "an answer that does not know of a Stop");
    const bool stopped = judge_.counters().stops.value() != before.stops.value();
    const bool beat = judge_.counters().heartbeats.value() != before.heartbeats.value();
    if (stopped) check_stop(question, sender, sealed);
    if (beat) check_beat(question, sender, sealed);
    if (sealed) given_.push_back({sender, answer->client, answer->challenge, now_ns_, true});
    return stopped || beat;
  }

  void check_stop(const stop::Datagram& question, std::size_t sender, bool sealed) {
    require(question[2] == static_cast<std::uint8_t>(Kind::kStop), "no Stop stopped");
    check_meant(question);
    if (!sealed) return;
    const Given* known = known_challenge(question, sender);
    require(known != nullptr && known->stops && now_ns_ - known->given_ns <= kChallengeLife_ns,
            "a Stop was obeyed that is old");
    for (Given& each : given_) each.stops = false;
  }

  void check_beat(const stop::Datagram& question, std::size_t sender, bool sealed) {
    require(question[2] == static_cast<std::uint8_t>(Kind::kHeartbeat) && sealed,
            "a heartbeat that is none, or of a stranger");
    check_meant(question);
    const std::int64_t timeout_ms = question[6] | question[7] << 8;
    require(timeout_ms >= stop::kShortestTimeout_ms && timeout_ms <= stop::kLongestTimeout_ms,
            "a heartbeat that may be silent for any time");
    const Given* known = known_challenge(question, sender);
    require(known != nullptr && now_ns_ - known->given_ns <= timeout_ms * kMs,
            "a heartbeat was counted that is old");
    require(line_.lets_go(now_ns_ + timeout_ms * kMs + 1), "a heartbeat holds the force for ever");
  }

  static void check_meant(const stop::Datagram& question) {
    const int port = question[4] | question[5] << 8;
    require(port == 0 || port == kSessionPort, "another daemon was meant");
  }

  bool keyed_;
  std::array<StopPeer, 4> peers_{peer(1, 5000, true), peer(1, 5001, true), peer(1, 5000, false),
                                 peer(2, 5000, false)};
  StopLine line_;
  StopJudge judge_;
  std::int64_t now_ns_ = 77'000 * kMs;
  LoopState state_ = LoopState::kEngaged;
  std::uint64_t tick_ = 0;
  std::vector<Given> given_;
  std::vector<std::vector<std::uint8_t>> sent_;
  bool obeyed_ = false;
};

}  // namespace

bool check_stop_datagrams(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return false;
  require(sodium_init() >= 0, "no libsodium");
  Road road((bytes[0] & 1U) != 0);
  bytes = bytes.subspan(1);
  while (bytes.size() >= 2) {
    const unsigned how = bytes[0];
    const unsigned which = bytes[1];
    bytes = bytes.subspan(2);
    if ((how & 16U) != 0) road.pass(100 * kMs);
    if ((how & 32U) != 0) road.pass(2000 * kMs);
    if ((how & 64U) != 0) road.tick((how & 128U) != 0);
    if ((which & 128U) != 0) {
      road.send_again(which & 127U, how);
      continue;
    }
    const auto datagram = bytes.first(std::min<std::size_t>(which, bytes.size()));
    road.send({datagram.begin(), datagram.end()}, how);
    bytes = bytes.subspan(datagram.size());
  }
  return road.finish();
}

}  // namespace hapticd::test
