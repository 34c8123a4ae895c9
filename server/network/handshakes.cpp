// See handshakes.h.
#include "server/network/handshakes.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

constexpr std::int64_t kSecond_ns = 1000 * wire::kMillisecond_ns;
constexpr TokenRate kUnproven{kSecond_ns / kUnprovenPerSecond, kUnprovenBurst};
constexpr TokenRate kUnprovenOld{kSecond_ns / kUnprovenOldPerSecond, kUnprovenOldBurst};
constexpr TokenRate kAnswers{kSecond_ns / kAnswersPerSecond, kAnswerBurst};

Handshakes::Random or_system(Handshakes::Random random) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium does not start");
  if (random) return random;
  return [](std::span<std::uint8_t> bytes) { randombytes_buf(bytes.data(), bytes.size()); };
}

}  // namespace

template <std::size_t Count>
std::array<std::uint8_t, Count> Handshakes::drawn() {
  std::array<std::uint8_t, Count> bytes{};
  random_(bytes);
  return bytes;
}

Handshakes::Handshakes(const noise::ServerKeys& keys, Random random)
    : random_(or_system(std::move(random))),
      keys_(keys),
      limiter_(SecretHash(drawn<crypto_shorthash_KEYBYTES>())),
      retries_(SecretHash(drawn<crypto_shorthash_KEYBYTES>())) {}

void Handshakes::rotate(std::int64_t now_ns) {
  if (secret_since_ns_.has_value() && now_ns - *secret_since_ns_ < kCookieSecret_ns) return;
  const bool recent =
      secret_since_ns_.has_value() && now_ns - *secret_since_ns_ < 2 * kCookieSecret_ns;
  secret_before_ = recent ? secret_ : drawn<sizeof(Secret)>();
  secret_ = drawn<sizeof(Secret)>();
  secret_since_ns_ = now_ns;
}

Handshakes::Cookie Handshakes::cookie_of(const Secret& secret, const Address& from,
                                         std::span<const std::uint8_t> message) {
  const std::array<std::uint8_t, 2> port{static_cast<std::uint8_t>(from.port),
                                         static_cast<std::uint8_t>(from.port >> 8U)};
  crypto_generichash_state state;
  crypto_generichash_init(&state, secret.data(), secret.size(), kCookieBytes);
  crypto_generichash_update(&state, from.ip.data(), from.ip.size());
  crypto_generichash_update(&state, port.data(), port.size());
  // The client's ephemeral key.
  crypto_generichash_update(&state, message.data(), noise::kKeyBytes);
  Cookie cookie{};
  crypto_generichash_final(&state, cookie.data(), cookie.size());
  return cookie;
}

// The cookie of a RETRY is followed by its tag, and comes back with it.
bool Handshakes::is_ours(const Address& from, const wire::Hello& hello, const RingKey& key) const {
  if (hello.cookie.size() != kCookieBytes + noise::kRetryTagBytes) return false;
  const auto equals = [&](const Secret& secret) {
    return sodium_memcmp(cookie_of(secret, from, hello.message).data(), hello.cookie.data(),
                         kCookieBytes) == 0;
  };
  return (equals(secret_) || equals(secret_before_)) &&
         noise::is_tagged_retry(key.psk.get(), wire::prologue_of(hello.role, hello.method),
                                hello.message, hello.cookie);
}

HalfOpen* Handshakes::repeated(const Address& from, const wire::Hello& hello, std::int64_t now_ns) {
  for (HalfOpen& half : all_) {
    const bool lives = half.established || now_ns - half.since_ns < kHalfOpen_ns;
    if (lives && half.address == from && half.role == hello.role && half.method == hello.method &&
        std::ranges::equal(half.message, hello.message)) {
      return &half;
    }
  }
  return nullptr;
}

noise::Bytes Handshakes::welcome_again(HalfOpen& half, std::int64_t now_ns) {
  if (!half.repeats.take(kAnswers, now_ns)) {
    ++counters_.limited;
    return {};
  }
  ++counters_.repeated;
  return half.welcome;
}

// Dearest last: what a flood of strangers reaches costs a few hashes, and takes nothing that
// belongs to the address it names.
noise::Bytes Handshakes::receive(const Address& from, std::span<const std::uint8_t> datagram,
                                 std::int64_t now_ns) {
  const auto drop = [](std::uint64_t& count) {
    ++count;
    return noise::Bytes{};
  };
  const auto hello = wire::decode_hello(datagram);
  if (!hello.has_value()) return drop(counters_.malformed);
  rotate(now_ns);
  if (HalfOpen* half = repeated(from, *hello, now_ns); half != nullptr && !hello->cookie.empty()) {
    return welcome_again(*half, now_ns);
  }
  const RingKey* key = keys_.find(*hello);
  const bool in_time =
      hello->method == wire::Method::kNKpsk0 || unproven_old_.take(kUnprovenOld, now_ns);
  const bool looked_at = in_time && unproven_.take(kUnproven, now_ns);
  if (!looked_at && (key == nullptr || !is_ours(from, *hello, *key))) {
    return drop(counters_.limited);
  }
  if (key == nullptr || !is_authentic(*key, *hello)) return drop(counters_.forged);
  if (!is_ours(from, *hello, *key)) return retry(from, *hello, *key, now_ns);
  return welcome(from, *hello, *key, now_ns);
}

noise::Bytes Handshakes::retry(const Address& from, const wire::Hello& hello, const RingKey& key,
                               std::int64_t now_ns) {
  if (!retries_.allow(from, hello.message, kAnswers, now_ns)) {
    ++counters_.limited;
    return {};
  }
  const Cookie cookie = cookie_of(secret_, from, hello.message);
  const auto tag = noise::retry_tag(key.psk.get(), wire::prologue_of(hello.role, hello.method),
                                    hello.message, cookie);
  std::array<std::uint8_t, kCookieBytes + noise::kRetryTagBytes> body{};
  std::copy(tag.begin(), tag.end(), std::copy(cookie.begin(), cookie.end(), body.begin()));
  ++counters_.retried;
  return wire::encode_retry(body);
}

bool Handshakes::has_room(const Address& from, wire::Role role) const {
  if (half_open(false) >= kMaxHalfOpen) return false;
  if (role == wire::Role::kControl) return true;
  const auto of_address = std::count_if(all_.begin(), all_.end(), [&](const HalfOpen& half) {
    return !half.established && half.role == wire::Role::kView && same_network(half.address, from);
  });
  return half_open(true) < kMaxHalfOpenViews &&
         static_cast<std::size_t>(of_address) < kMaxHalfOpenViewsOfAddress;
}

// A number that no session of a handshake has.
std::uint32_t Handshakes::new_session() {
  std::uint32_t session = 0;
  const auto taken = [&](const HalfOpen& half) { return half.session == session; };
  while (session == 0 || std::any_of(all_.begin(), all_.end(), taken)) {
    const auto bytes = drawn<4>();
    session = 0;
    for (const std::uint8_t byte : bytes) session = session << 8U | byte;
  }
  return session;
}

noise::Bytes Handshakes::welcome(const Address& from, const wire::Hello& hello, const RingKey& key,
                                 std::int64_t now_ns) {
  expire(now_ns);
  if (!has_room(from, hello.role)) {
    ++counters_.full;
    return {};
  }
  if (!limiter_.allow(from, hello.message.first(noise::kKeyBytes), now_ns)) {
    ++counters_.limited;
    return {};
  }
  noise::Handshake handshake = keys_.handshake(key, hello.method, drawn<noise::kKeyBytes>());
  const auto message = handshake.read(hello.message).has_value() ? handshake.write() : std::nullopt;
  if (!message.has_value()) {
    ++counters_.forged;
    return {};
  }
  const std::uint32_t session = new_session();
  HalfOpen half{from,
                hello.role,
                hello.method,
                key.id,
                key.name,
                session,
                noise::Bytes(hello.message.begin(), hello.message.end()),
                wire::encode_welcome({session, *message}),
                handshake.split(),
                now_ns,
                false,
                {}};
  all_.push_back(std::move(half));
  ++counters_.welcomed;
  return all_.back().welcome;
}

const HalfOpen* Handshakes::find(const Address& from, std::uint32_t session) const {
  for (const HalfOpen& half : all_) {
    if (half.session == session && half.address == from && !half.established) return &half;
  }
  return nullptr;
}

void Handshakes::establish(std::uint32_t session) {
  for (HalfOpen& half : all_) {
    if (half.session == session) half.established = true;
  }
}

void Handshakes::forget(std::uint32_t session) {
  std::erase_if(all_, [&](const HalfOpen& half) { return half.session == session; });
}

void Handshakes::replace_keys(const noise::ServerKeys& keys) {
  keys_ = KeyRing(keys);
  std::erase_if(all_, [&](const HalfOpen& half) {
    return !half.established && !keys_.holds(half.key_id, half.role);
  });
}

void Handshakes::expire(std::int64_t now_ns) {
  std::erase_if(all_, [&](const HalfOpen& half) {
    return !half.established && now_ns - half.since_ns >= kHalfOpen_ns;
  });
}

std::size_t Handshakes::half_open(bool views) const {
  return static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(), [views](const HalfOpen& half) {
        return !half.established && (!views || half.role == wire::Role::kView);
      }));
}

}  // namespace hapticd
