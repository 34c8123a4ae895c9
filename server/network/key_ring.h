// The keys of a server as HELLOs are judged by them, with what is computed once of each: which key
// a HELLO names, and whether somebody who has it made the HELLO. PROTOCOL.md, section 12. Pure. Not
// RT.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/noise/hello_tag.h"
#include "proto/noise/key_folder.h"
#include "proto/wire/hello.h"

namespace hapticd {

/// One of them.
struct RingKey {
  noise::KeyId id{};
  std::string name;  ///< of its client; empty: view.key or control.key
  wire::Role role = wire::Role::kView;
  noise::SecretKey psk;
  noise::SecretKey hello_key;              ///< of the MACs of HELLOs
  noise::Locked<noise::Symmetric> start;   ///< of NKpsk0
  noise::Locked<noise::Symmetric> before;  ///< of NNpsk0
};

class KeyRing {
 public:
  explicit KeyRing(const noise::ServerKeys& keys);

  /// The key that the HELLO names: NKpsk0 by its id, NNpsk0 by its role, and then one without a
  /// name; null: there is none. A comparison for each key, no hash.
  [[nodiscard]] const RingKey* find(const wire::Hello& hello) const noexcept;
  /// Whether there is a key of this id and role.
  [[nodiscard]] bool holds(const noise::KeyId& id, wire::Role role) const noexcept;
  /// The server's side of a handshake with `key`; `ephemeral` is its private key.
  [[nodiscard]] noise::Handshake handshake(const RingKey& key, wire::Method method,
                                           const noise::Key& ephemeral) const;

 private:
  noise::SecretKey own_;
  std::vector<RingKey> keys_;
};

/// Whether somebody who has `key` made the HELLO: its tag, or message 1 of NNpsk0, verifies. A few
/// hashes and no scalar multiplication.
[[nodiscard]] bool is_authentic(const RingKey& key, const wire::Hello& hello);

}  // namespace hapticd
