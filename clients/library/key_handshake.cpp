// See key_handshake.h.
#include "clients/library/key_handshake.h"

#include <algorithm>
#include <array>

#include "proto/noise/retry_tag.h"
#include "proto/wire/item_outbox.h"

namespace hapticd::client {
namespace {

/// Time between two HELLOs, ns.
constexpr std::int64_t kHelloPeriod_ns = 250 * wire::kMillisecond_ns;

std::array<std::uint8_t, 9> prologue_of(const ClientKey& key) {
  return wire::prologue_of(key.role, wire::Method::kNKpsk0);
}

}  // namespace

ClientKey read_client_key(const std::filesystem::path& file, std::optional<wire::Role> role) {
  ClientKey key = noise::read_session_key(file);
  key.role = role.value_or(key.role);
  return key;
}

KeyHandshake::KeyHandshake(const ClientKey& key, const noise::Key& ephemeral)
    : key_(key),
      key_id_(noise::key_id(key.psk.get())),
      hello_key_(noise::SecretKey::filled(
          [&](noise::Key& mac) { mac = noise::hello_key(key.psk.get()); })),
      handshake_(noise::Side::kInitiator,
                 noise::Symmetric(key.psk.get(), prologue_of(key), key.server), ephemeral,
                 key.server),
      message_(handshake_.write().value_or(noise::Bytes{})) {}

noise::Bytes KeyHandshake::hello(std::int64_t now_ns) {
  due_ns_ = now_ns + kHelloPeriod_ns;
  return wire::encode_hello({key_.role, key_id_, cookie_, message_}, hello_key_.get());
}

// A RETRY without a tag may be of anybody who knows where this client is. It is believed, for the
// sake of servers that make no tags, until one with a tag has come; and but for the first one it
// makes no HELLO leave earlier, so that a flood of them neither hurries nor holds up the handshake.
void KeyHandshake::take_cookie(std::span<const std::uint8_t> cookie) {
  const bool tagged = noise::is_tagged_retry(key_.psk.get(), prologue_of(key_), message_, cookie);
  if (tagged_ && !tagged) return;
  // A second RETRY with the same cookie is the answer to a HELLO before it.
  const bool fresh = !std::ranges::equal(cookie, cookie_);
  if (fresh && (tagged || cookie_.empty())) due_ns_ = 0;
  cookie_.assign(cookie.begin(), cookie.end());
  tagged_ = tagged;
}

bool KeyHandshake::receive(std::span<const std::uint8_t> datagram) {
  if (session_ != 0) return false;
  if (const auto cookie = wire::decode_retry(datagram)) {
    take_cookie(*cookie);
    return false;
  }
  const auto welcome = wire::decode_welcome(datagram);
  if (!welcome.has_value() || !handshake_.read(welcome->message).has_value()) return false;
  session_ = welcome->session;
  return true;
}

}  // namespace hapticd::client
