// See key_ring.h.
#include "server/network/key_ring.h"

#include <sodium.h>

#include <algorithm>

namespace hapticd {
namespace {

noise::Locked<noise::Symmetric> locked(noise::Symmetric start) {
  noise::Locked<noise::Symmetric> kept(start);
  start.wipe();
  return kept;
}

RingKey ring_key(const noise::KnownKey& known, const noise::Key& server) {
  const noise::Key& psk = known.psk.get();
  return {noise::key_id(psk),
          known.name,
          known.role,
          known.psk,
          noise::SecretKey::filled([&](noise::Key& key) { key = noise::hello_key(psk); }),
          locked({psk, wire::prologue_of(known.role, wire::Method::kNKpsk0), server}),
          locked({psk, wire::prologue_of(known.role, wire::Method::kNNpsk0)})};
}

}  // namespace

KeyRing::KeyRing(const noise::ServerKeys& keys) : own_(keys.own) {
  for (const noise::KnownKey& known : keys.known) keys_.push_back(ring_key(known, keys.server));
}

const RingKey* KeyRing::find(const wire::Hello& hello) const noexcept {
  const bool by_role = hello.method == wire::Method::kNNpsk0;
  const auto found = std::find_if(keys_.begin(), keys_.end(), [&](const RingKey& key) {
    if (key.role != hello.role) return false;
    return by_role ? key.name.empty() : std::ranges::equal(key.id, hello.key_id);
  });
  return found == keys_.end() ? nullptr : &*found;
}

bool KeyRing::holds(const noise::KeyId& id, wire::Role role) const noexcept {
  return std::any_of(keys_.begin(), keys_.end(),
                     [&](const RingKey& key) { return key.id == id && key.role == role; });
}

noise::Handshake KeyRing::handshake(const RingKey& key, wire::Method method,
                                    const noise::Key& ephemeral) const {
  if (method == wire::Method::kNNpsk0) {
    return {noise::Side::kResponder, key.before.get(), ephemeral};
  }
  return {noise::Side::kResponder, key.start.get(), ephemeral, own_.get()};
}

bool is_authentic(const RingKey& key, const wire::Hello& hello) {
  if (hello.method == wire::Method::kNNpsk0) return key.before.get().is_first(hello.message);
  return noise::is_hello_tag(key.hello_key.get(), hello.before, hello.tag);
}

}  // namespace hapticd
