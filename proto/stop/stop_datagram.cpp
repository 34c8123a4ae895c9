// See stop_datagram.h.
#include "proto/stop/stop_datagram.h"

#include <sodium.h>

#include <algorithm>

namespace hapticd::stop {
namespace {

constexpr std::uint8_t kMark = 'S';
constexpr std::uint8_t kVersion = 1;

// Offsets.
constexpr std::size_t kKindAt = 2;
constexpr std::size_t kCodeAt = 3;
constexpr std::size_t kPortAt = 4;
constexpr std::size_t kTimeoutAt = 6;
constexpr std::size_t kLatchAt = 8;
constexpr std::size_t kLoopStateAt = 9;
constexpr std::size_t kCauseAt = 10;
constexpr std::size_t kHeartbeatsAt = 11;
constexpr std::size_t kTickAt = 12;
constexpr std::size_t kClientAt = 16;
constexpr std::size_t kNumberAt = 24;
constexpr std::size_t kIssuedAt = 32;
constexpr std::size_t kProofAt = 40;
constexpr std::size_t kTagAt = 48;
static_assert(kTagAt + kTagBytes == kDatagramBytes);

/// Little-endian.
template <typename T>
void put(Datagram& to, std::size_t at, T value) noexcept {
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    to[at + k] = static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * k));
  }
}

template <typename T>
T get(std::span<const std::uint8_t> from, std::size_t at) noexcept {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < sizeof(T); ++k) value |= std::uint64_t{from[at + k]} << (8 * k);
  return static_cast<T>(value);
}

Datagram begin(std::uint8_t kind, std::uint64_t client, std::uint64_t number,
               const Challenge& challenge) noexcept {
  Datagram made{};
  made[0] = kMark;
  made[1] = kVersion;
  made[kKindAt] = kind;
  put(made, kClientAt, client);
  put(made, kNumberAt, number);
  put(made, kIssuedAt, challenge.issued_ns);
  put(made, kProofAt, challenge.proof);
  return made;
}

bool has_form(std::span<const std::uint8_t> bytes) noexcept {
  return bytes.size() == kDatagramBytes && bytes[0] == kMark && bytes[1] == kVersion;
}

void tag_of(const Datagram& datagram, const Key& key,
            std::array<std::uint8_t, kTagBytes>& tag) noexcept {
  crypto_generichash(tag.data(), tag.size(), datagram.data(), kTagAt, key.data(), key.size());
}

}  // namespace

Datagram encode(const Request& request) noexcept {
  Datagram made = begin(static_cast<std::uint8_t>(request.kind), request.client, request.number,
                        request.challenge);
  put(made, kPortAt, request.session_port);
  put(made, kTimeoutAt, request.timeout_ms);
  return made;
}

Datagram encode(const Answer& answer) noexcept {
  const auto kind = static_cast<std::uint8_t>(static_cast<std::uint8_t>(answer.kind) | kAnswerBit);
  Datagram made = begin(kind, answer.client, answer.number, answer.challenge);
  made[kCodeAt] = static_cast<std::uint8_t>(answer.code);
  put(made, kPortAt, answer.session_port);
  put(made, kTimeoutAt, answer.timeout_ms);
  made[kLatchAt] = static_cast<std::uint8_t>(answer.latch);
  made[kLoopStateAt] = answer.loop_state;
  made[kCauseAt] = answer.cause;
  made[kHeartbeatsAt] = answer.heartbeats;
  put(made, kTickAt, answer.tick);
  return made;
}

std::optional<Request> parse_request(std::span<const std::uint8_t> bytes) noexcept {
  if (!has_form(bytes) || bytes[kCodeAt] != 0 || (bytes[kKindAt] & kAnswerBit) != 0) {
    return std::nullopt;
  }
  const auto unused = bytes.subspan(kLatchAt, kClientAt - kLatchAt);
  if (std::any_of(unused.begin(), unused.end(), [](std::uint8_t byte) { return byte != 0; })) {
    return std::nullopt;
  }
  Request read;
  read.kind = static_cast<Kind>(bytes[kKindAt]);
  read.session_port = get<std::uint16_t>(bytes, kPortAt);
  read.timeout_ms = get<std::uint16_t>(bytes, kTimeoutAt);
  read.client = get<std::uint64_t>(bytes, kClientAt);
  read.number = get<std::uint64_t>(bytes, kNumberAt);
  read.challenge = {get<std::uint64_t>(bytes, kIssuedAt), get<std::uint64_t>(bytes, kProofAt)};
  const bool odd_timeout = read.kind != Kind::kHeartbeat && read.timeout_ms != 0;
  if (odd_timeout || read.client == 0 || read.number == 0) return std::nullopt;
  return read;
}

std::optional<Answer> parse_answer(std::span<const std::uint8_t> bytes) noexcept {
  if (!has_form(bytes) || (bytes[kKindAt] & kAnswerBit) == 0 ||
      bytes[kLatchAt] > static_cast<std::uint8_t>(Latch::kLatched)) {
    return std::nullopt;
  }
  Answer read;
  read.kind = static_cast<Kind>(bytes[kKindAt] & ~kAnswerBit);
  read.code = static_cast<Code>(bytes[kCodeAt]);
  read.session_port = get<std::uint16_t>(bytes, kPortAt);
  read.timeout_ms = get<std::uint16_t>(bytes, kTimeoutAt);
  read.latch = static_cast<Latch>(bytes[kLatchAt]);
  read.loop_state = bytes[kLoopStateAt];
  read.cause = bytes[kCauseAt];
  read.heartbeats = bytes[kHeartbeatsAt];
  read.tick = get<std::uint32_t>(bytes, kTickAt);
  read.client = get<std::uint64_t>(bytes, kClientAt);
  read.number = get<std::uint64_t>(bytes, kNumberAt);
  read.challenge = {get<std::uint64_t>(bytes, kIssuedAt), get<std::uint64_t>(bytes, kProofAt)};
  return read;
}

void seal(Datagram& datagram, const Key& key) noexcept {
  std::array<std::uint8_t, kTagBytes> tag;
  tag_of(datagram, key, tag);
  std::copy(tag.begin(), tag.end(), datagram.begin() + kTagAt);
}

bool is_sealed(const Datagram& datagram) noexcept {
  return std::any_of(datagram.begin() + kTagAt, datagram.end(),
                     [](std::uint8_t byte) { return byte != 0; });
}

bool opens(const Datagram& datagram, const Key& key) noexcept {
  std::array<std::uint8_t, kTagBytes> tag;
  tag_of(datagram, key, tag);
  return crypto_verify_16(tag.data(), datagram.data() + kTagAt) == 0;
}

}  // namespace hapticd::stop
