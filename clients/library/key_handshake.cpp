// See key_handshake.h.
#include "clients/library/key_handshake.h"

#include "proto/noise/key_file.h"
#include "proto/wire/item_outbox.h"

namespace hapticd::client {
namespace {

/// Time between two HELLOs, ns.
constexpr std::int64_t kHelloPeriod_ns = 250 * wire::kMillisecond_ns;

}  // namespace

ClientKey read_client_key(const std::filesystem::path& file, std::optional<wire::Role> role) {
  const bool is_view = file.filename() == noise::kViewKeyName;
  return {role.value_or(is_view ? wire::Role::kView : wire::Role::kControl),
          noise::read_key_file(file)};
}

KeyHandshake::KeyHandshake(const ClientKey& key, const noise::Key& ephemeral)
    : role_(key.role),
      handshake_(noise::Side::kInitiator, key.key, wire::prologue_of(key.role), ephemeral),
      message_(handshake_.write().value_or(noise::Bytes{})) {}

noise::Bytes KeyHandshake::hello(std::int64_t now_ns) {
  due_ns_ = now_ns + kHelloPeriod_ns;
  return wire::encode_hello({role_, cookie_, message_});
}

bool KeyHandshake::receive(std::span<const std::uint8_t> datagram) {
  if (session_ != 0) return false;
  if (const auto cookie = wire::decode_retry(datagram)) {
    // A second RETRY with the same cookie is the answer to a HELLO before it.
    const noise::Bytes fresh(cookie->begin(), cookie->end());
    if (fresh != cookie_) due_ns_ = 0;
    cookie_ = fresh;
    return false;
  }
  const auto welcome = wire::decode_welcome(datagram);
  if (!welcome.has_value() || !handshake_.read(welcome->message).has_value()) return false;
  session_ = welcome->session;
  return true;
}

}  // namespace hapticd::client
