// See handshakes.h.
#include "server/network/handshakes.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

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

Handshakes::Handshakes(const noise::KeyPair& keys, Random random)
    : keys_(keys),
      random_(or_system(std::move(random))),
      limiter_(drawn<crypto_shorthash_KEYBYTES>()) {}

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

bool Handshakes::is_ours(const Address& from, const wire::Hello& hello) const {
  if (hello.cookie.size() != kCookieBytes) return false;
  const auto equals = [&](const Secret& secret) {
    return sodium_memcmp(cookie_of(secret, from, hello.message).data(), hello.cookie.data(),
                         kCookieBytes) == 0;
  };
  return equals(secret_) || equals(secret_before_);
}

noise::Bytes Handshakes::receive(const Address& from, std::span<const std::uint8_t> datagram,
                                 std::int64_t now_ns) {
  const auto hello = wire::decode_hello(datagram);
  if (!hello.has_value() || !limiter_.allow(from, now_ns)) return {};
  rotate(now_ns);
  noise::Handshake handshake(noise::Side::kResponder,
                             hello->role == wire::Role::kView ? keys_.view : keys_.control,
                             wire::prologue_of(hello->role), drawn<noise::kKeyBytes>());
  const auto payload = handshake.read(hello->message);
  if (!payload.has_value() || !payload->empty()) return {};
  if (!is_ours(from, *hello)) {
    return wire::encode_retry(cookie_of(secret_, from, hello->message));
  }
  for (const HalfOpen& half : all_) {
    if (half.address == from && half.role == hello->role &&
        std::equal(half.message.begin(), half.message.end(), hello->message.begin())) {
      return half.welcome;
    }
  }
  return welcome(from, *hello, handshake, now_ns);
}

noise::Bytes Handshakes::welcome(const Address& from, const wire::Hello& hello,
                                 noise::Handshake& handshake, std::int64_t now_ns) {
  expire(now_ns);
  if (half_open(false) >= kMaxHalfOpen) return {};
  if (hello.role == wire::Role::kView && half_open(true) >= kMaxHalfOpenViews) return {};
  const auto message = handshake.write();
  if (!message.has_value()) return {};
  std::uint32_t session = 0;
  const auto taken = [&](const HalfOpen& half) { return half.session == session; };
  while (session == 0 || std::any_of(all_.begin(), all_.end(), taken)) {
    const auto bytes = drawn<4>();
    session = 0;
    for (const std::uint8_t byte : bytes) session = session << 8U | byte;
  }
  HalfOpen half{from,
                hello.role,
                session,
                noise::Bytes(hello.message.begin(), hello.message.end()),
                wire::encode_welcome({session, *message}),
                handshake.split(),
                now_ns,
                false};
  all_.push_back(std::move(half));
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
