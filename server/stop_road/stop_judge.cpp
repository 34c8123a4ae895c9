// See stop_judge.h.
#include "server/stop_road/stop_judge.h"

#include <sodium.h>

#include <algorithm>
#include <cstring>

namespace hapticd {
namespace {

using stop::Code;
using stop::Kind;

static_assert(sizeof(StopRules::secret) == crypto_shorthash_KEYBYTES);

bool is_known(Kind kind) noexcept { return kind >= Kind::kStop && kind <= Kind::kLeave; }

/// A dead-man's: what a stranger could keep alive or end.
bool is_of_heartbeat(Kind kind) noexcept {
  return kind == Kind::kHeartbeat || kind == Kind::kLeave;
}

std::int64_t life_of_challenge_ns(const stop::Request& request) noexcept {
  return request.kind == Kind::kHeartbeat ? std::int64_t{request.timeout_ms} * 1'000'000
                                          : kChallengeLife_ns;
}

}  // namespace

bool StopJudge::authentic(const stop::Datagram& datagram, const StopPeer& from) const noexcept {
  if (!stop::is_sealed(datagram)) return from.loopback;
  return rules_.key && stop::opens(datagram, rules_.key->get());
}

std::optional<stop::Datagram> StopJudge::receive(std::span<const std::uint8_t> bytes,
                                                 const StopPeer& from,
                                                 std::int64_t now_ns) noexcept {
  counters_.received.add();
  const std::optional<stop::Request> request = stop::parse_request(bytes);
  if (!request) {
    counters_.malformed.add();
    return std::nullopt;
  }
  stop::Datagram datagram;
  std::copy(bytes.begin(), bytes.end(), datagram.begin());
  if (!authentic(datagram, from)) {
    counters_.unauthenticated.add();
    return std::nullopt;
  }
  const Heard heard{*request, from, now_ns, stop::is_sealed(datagram)};
  return answer(heard, judge(heard));
}

stop::Code StopJudge::judge(const Heard& heard) noexcept {
  const stop::Request& request = heard.request;
  if (!is_known(request.kind)) {
    counters_.malformed.add();
    return Code::kUnknownKind;
  }
  if (request.session_port != 0 && request.session_port != rules_.session_port) {
    counters_.other_daemon.add();
    return Code::kOtherDaemon;
  }
  if (!heard.sealed && is_of_heartbeat(request.kind)) {
    counters_.unauthenticated.add();
    return Code::kKeyNeeded;
  }
  if (request.kind == Kind::kHeartbeat && (request.timeout_ms < stop::kShortestTimeout_ms ||
                                           request.timeout_ms > stop::kLongestTimeout_ms)) {
    counters_.malformed.add();
    return Code::kOutOfRange;
  }
  // What anybody on this machine may ask needs no proof that it is new.
  if (heard.sealed && request.kind != Kind::kQuery && !fresh(heard)) {
    StopCount& cause =
        request.challenge == stop::Challenge{} ? counters_.challenged : counters_.replayed;
    cause.add();
    return Code::kChallenge;
  }
  return obey(heard);
}

bool StopJudge::fresh(const Heard& heard) const noexcept {
  const stop::Request& request = heard.request;
  const std::uint64_t issued_ns = request.challenge.issued_ns;
  if (issued_ns == 0 || issued_ns > last_issued_ns_) return false;
  if (request.challenge.proof != proof_of(heard, issued_ns)) return false;
  if (request.kind == Kind::kStop && issued_ns <= stop_used_ns_) return false;
  const auto age_ns = heard.now_ns - static_cast<std::int64_t>(issued_ns);
  return age_ns <= life_of_challenge_ns(request);
}

stop::Code StopJudge::obey(const Heard& heard) noexcept {
  const stop::Request& request = heard.request;
  switch (request.kind) {
    case Kind::kStop:
      line_.ask();
      counters_.stops.add();
      if (heard.sealed) stop_used_ns_ = last_issued_ns_;
      return Code::kDone;
    case Kind::kHeartbeat: {
      const Code code =
          count(heartbeats_.beat(request.client, request.number,
                                 std::int64_t{request.timeout_ms} * 1'000'000, heard.now_ns));
      if (code == Code::kDone) counters_.heartbeats.add();
      return code;
    }
    case Kind::kLeave:
      return count(heartbeats_.leave(request.client, request.number, heard.now_ns));
    case Kind::kQuery:
      break;
  }
  return Code::kDone;
}

stop::Code StopJudge::count(Heartbeats::Verdict verdict) noexcept {
  hold();
  if (verdict == Heartbeats::Verdict::kRepeated) counters_.replayed.add();
  if (verdict == Heartbeats::Verdict::kFull) counters_.full.add();
  return verdict == Heartbeats::Verdict::kCounts     ? Code::kDone
         : verdict == Heartbeats::Verdict::kRepeated ? Code::kChallenge
                                                     : Code::kFull;
}

void StopJudge::hold() noexcept {
  line_.hold_until(heartbeats_.earliest_ns(StopLine::kNoHeartbeat));
}

void StopJudge::look(std::int64_t now_ns) noexcept {
  const std::uint32_t clears = line_.told().clears;
  if (clears == clears_seen_) return;
  clears_seen_ = clears;
  heartbeats_.forget_absent(now_ns);
  hold();
}

std::uint64_t StopJudge::proof_of(const Heard& heard, std::uint64_t issued_ns) const noexcept {
  std::array<std::uint8_t, 34> bound;
  std::copy(heard.from.ip.begin(), heard.from.ip.end(), bound.begin());
  std::memcpy(bound.data() + 16, &heard.from.port, sizeof(heard.from.port));
  std::memcpy(bound.data() + 18, &heard.request.client, sizeof(heard.request.client));
  std::memcpy(bound.data() + 26, &issued_ns, sizeof(issued_ns));
  std::uint64_t proof = 0;
  static_assert(sizeof(proof) == crypto_shorthash_BYTES);
  crypto_shorthash(reinterpret_cast<unsigned char*>(&proof), bound.data(), bound.size(),
                   rules_.secret.data());
  return proof;
}

stop::Datagram StopJudge::answer(const Heard& heard, stop::Code code) noexcept {
  stop::Answer said;
  said.kind = heard.request.kind;
  said.code = code;
  said.session_port = rules_.session_port;
  said.timeout_ms = heard.request.timeout_ms;
  said.client = heard.request.client;
  said.number = heard.request.number;
  // Another daemon's Stop must not be read as that of the one that is meant.
  if (code != Code::kOtherDaemon) {
    const StopLine::Told told = line_.told();
    const bool latched = told.state == LoopState::kFault;
    said.latch = told.waits ? stop::Latch::kAsked
                 : latched  ? stop::Latch::kLatched
                            : stop::Latch::kNone;
    said.loop_state = static_cast<std::uint8_t>(told.state);
    said.cause = static_cast<std::uint8_t>(told.cause);
    said.tick = told.tick;
    said.heartbeats = static_cast<std::uint8_t>(heartbeats_.count());
  }
  if (heard.sealed) {
    last_issued_ns_ = std::max(last_issued_ns_ + 1, static_cast<std::uint64_t>(heard.now_ns));
    said.challenge = {last_issued_ns_, proof_of(heard, last_issued_ns_)};
  }
  stop::Datagram datagram = stop::encode(said);
  if (heard.sealed) stop::seal(datagram, rules_.key->get());
  return datagram;
}

}  // namespace hapticd
