// The datagrams of the Stop road, 64 bytes each way: their layout, and the tag that a holder of
// stop.key puts at the end. PROTOCOL.md, section 17. Pure but for libsodium; no heap, no lock. RT:
// no, but bounded: a tag costs about 1 us.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/noise/locked.h"

namespace hapticd::stop {

inline constexpr std::size_t kDatagramBytes = 64;
inline constexpr std::size_t kTagBytes = 16;
/// UDP port where a road is looked for.
inline constexpr std::uint16_t kDefaultPort = 47801;

/// What a HEARTBEAT may choose as the longest silence, ms.
inline constexpr std::uint16_t kShortestTimeout_ms = 50;
inline constexpr std::uint16_t kLongestTimeout_ms = 1000;

/// stop.key.
using Key = std::array<std::uint8_t, 32>;
/// The same where it is kept: neither swapped out nor dumped, and wiped when it goes.
using SecretKey = noise::Locked<Key>;
using Datagram = std::array<std::uint8_t, kDatagramBytes>;

/// What is asked for. An answer's has kAnswerBit beside it. Others may come off the wire.
enum class Kind : std::uint8_t { kStop = 1, kQuery = 2, kHeartbeat = 3, kLeave = 4 };
inline constexpr std::uint8_t kAnswerBit = 0x80;

/// What an answer says of its request.
enum class Code : std::uint8_t {
  kDone = 1,         ///< it was done
  kChallenge = 2,    ///< it was not: ask again with this challenge
  kOtherDaemon = 3,  ///< it is meant for another daemon
  kKeyNeeded = 4,    ///< it needs a tag
  kOutOfRange = 5,   ///< the heartbeat's time-out is
  kFull = 6,         ///< no room for another heartbeat
  kUnknownKind = 7,  ///< this daemon does not know the kind
};

/// How far a Stop has come.
enum class Latch : std::uint8_t {
  kNone = 0,     ///< no fault is latched
  kAsked = 1,    ///< a Stop waits for the loop's next tick
  kLatched = 2,  ///< the loop is in FAULT, without force until a Clear
};

/// What a daemon gives to one client at one address, to be repeated in its next request.
struct Challenge {
  std::uint64_t issued_ns = 0;  ///< the daemon's clock; 0: none
  std::uint64_t proof = 0;

  friend bool operator==(const Challenge&, const Challenge&) = default;
};

struct Request {
  Kind kind = Kind::kStop;
  std::uint16_t session_port = 0;  ///< of the daemon that is meant; 0: whoever hears it
  std::uint16_t timeout_ms = 0;    ///< of a HEARTBEAT; else 0
  std::uint64_t client = 0;        ///< chosen at random, not 0
  std::uint64_t number = 0;        ///< grows with each request of the client, from 1
  Challenge challenge;
};

struct Answer {
  Kind kind = Kind::kStop;
  Code code = Code::kDone;
  std::uint16_t session_port = 0;  ///< of the daemon that answers
  std::uint16_t timeout_ms = 0;    ///< as in the request
  Latch latch = Latch::kNone;
  std::uint8_t loop_state = 0;  ///< a LoopState of state.proto
  std::uint8_t cause = 0;       ///< a Cause of event.proto
  std::uint8_t heartbeats = 0;  ///< clients that must be alive
  std::uint32_t tick = 0;       ///< low bits of the newest tick that is over
  std::uint64_t client = 0;     ///< as in the request
  std::uint64_t number = 0;     ///< as in the request
  Challenge challenge;          ///< for the client's next request
};

/// The datagram, its tag zeros.
[[nodiscard]] Datagram encode(const Request& request) noexcept;
[[nodiscard]] Datagram encode(const Answer& answer) noexcept;

/// What a datagram asks for; nothing where it has another length, mark or version, a client or
/// number 0, or anything in a field that is to be 0. The kind, the time-out of a HEARTBEAT and the
/// tag are the caller's to judge.
[[nodiscard]] std::optional<Request> parse_request(std::span<const std::uint8_t> bytes) noexcept;
/// What a datagram answers; nothing where it is no answer of this version.
[[nodiscard]] std::optional<Answer> parse_answer(std::span<const std::uint8_t> bytes) noexcept;

/// Puts the tag at the end: BLAKE2b-128 under `key` of all that is before it.
void seal(Datagram& datagram, const Key& key) noexcept;
/// Whether there is a tag. One that is zeros is none.
[[nodiscard]] bool is_sealed(const Datagram& datagram) noexcept;
/// Whether the tag is that of `key`, in constant time.
[[nodiscard]] bool opens(const Datagram& datagram, const Key& key) noexcept;

}  // namespace hapticd::stop
