// Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b of the Noise specification, revision 34: the handshake of
// keyed sessions and the ciphers it ends with. PROTOCOL.md, section 12. Pattern, and beside it that
// of Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b, the handshake of 0.1:
//   <- s
//   -> psk, e, es          -> psk, e
//   <- e, ee               <- e, ee
// s is the responder's key: only who has its private half can answer. On primitives of libsodium.
// Pure: the maker of a Handshake brings its randomness. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "proto/noise/locked.h"

namespace hapticd::noise {

inline constexpr std::size_t kKeyBytes = 32;
inline constexpr std::size_t kTagBytes = 16;
/// Either message of the handshake with an empty payload, bytes: a public key and a tag.
inline constexpr std::size_t kMessageBytes = kKeyBytes + kTagBytes;

/// A shared secret, or either half of a key pair of Curve25519.
using Key = std::array<std::uint8_t, kKeyBytes>;
using Bytes = std::vector<std::uint8_t>;

/// The public half of a private key.
[[nodiscard]] Key public_half(const Key& private_half);

/// One direction of the transport phase: ChaCha20-Poly1305 with the nonce in the caller's hands.
/// Copies share the key, which is neither swapped out nor dumped, and wiped with the last of them.
class Cipher {
 public:
  explicit Cipher(const Locked<Key>& key) : key_(key) {}

  /// `plain` encrypted, and its tag. No `n` may be used twice.
  [[nodiscard]] Bytes seal(std::uint64_t n, std::span<const std::uint8_t> associated,
                           std::span<const std::uint8_t> plain) const;
  /// What was sealed; nothing when the tag does not verify.
  [[nodiscard]] std::optional<Bytes> open(std::uint64_t n, std::span<const std::uint8_t> associated,
                                          std::span<const std::uint8_t> sealed) const;

 private:
  Locked<Key> key_;
};

/// The ciphers of one side.
struct Transport {
  Cipher send;
  Cipher receive;
};

/// How far the hashing of a handshake is: SymmetricState of the specification.
class Symmetric {
 public:
  /// As it is before the first message of any handshake NNpsk0 under `psk`.
  Symmetric(const Key& psk, std::span<const std::uint8_t> prologue);
  /// The same of NKpsk0, with the responder whose public key is `responder`.
  Symmetric(const Key& psk, std::span<const std::uint8_t> prologue, const Key& responder);

  void mix_hash(std::span<const std::uint8_t> data);
  void mix_key(std::span<const std::uint8_t> material);
  [[nodiscard]] Bytes seal(std::span<const std::uint8_t> payload);
  [[nodiscard]] std::optional<Bytes> open(std::span<const std::uint8_t> sealed);
  /// Whether `message` is a first message of NNpsk0 with an empty payload, made by somebody who has
  /// the psk.
  /// 13 blocks of BLAKE2b and one of ChaCha20: no scalar multiplication, no heap.
  [[nodiscard]] bool is_first(std::span<const std::uint8_t> message) const;
  /// The keys of the initiator's and of the responder's direction.
  [[nodiscard]] std::array<Locked<Key>, 2> split() const;
  /// Overwrites it with zeros.
  void wipe();

 private:
  using Hash = std::array<std::uint8_t, 64>;

  void begin(std::string_view name, std::span<const std::uint8_t> prologue);
  void mix_psk(const Key& psk);

  Hash hash_{};
  Hash chaining_{};
  Key key_{};
};

enum class Side : std::uint8_t { kInitiator, kResponder };

/// One side of one handshake: the initiator writes, then reads; the responder reads, then writes.
/// Messages out of this order throw std::logic_error.
class Handshake {
 public:
  /// NNpsk0. `ephemeral` is the private key of this handshake alone: 32 random bytes.
  Handshake(Side side, const Key& psk, std::span<const std::uint8_t> prologue, const Key& ephemeral)
      : Handshake(side, Symmetric(psk, prologue), ephemeral) {}
  /// NNpsk0, from what was computed once for its psk and prologue.
  Handshake(Side side, const Symmetric& start, const Key& ephemeral);
  /// NKpsk0, from what was computed once. `responder`: its public key for the initiator, its
  /// private one for itself.
  Handshake(Side side, const Symmetric& start, const Key& ephemeral, const Key& responder);
  /// Wipes its secrets.
  ~Handshake();
  Handshake(const Handshake&) = delete;
  Handshake& operator=(const Handshake&) = delete;

  /// This side's message; nothing where the other side's public key is of low order, which only a
  /// holder of the psk can send. Each shared secret is a scalar multiplication, which costs most of
  /// a handshake: NNpsk0 has one, NKpsk0 two.
  [[nodiscard]] std::optional<Bytes> write(std::span<const std::uint8_t> payload = {});
  /// The payload of the other side's message; nothing where it does not open. Such a message leaves
  /// no trace: the true one may still come.
  [[nodiscard]] std::optional<Bytes> read(std::span<const std::uint8_t> message);
  /// The ciphers, once both messages have passed.
  [[nodiscard]] Transport split() const;

 private:
  enum class Step : std::uint8_t { kFirst, kSecond, kDone };

  bool mix_shared(const Key& mine, const Key& theirs);
  bool mix_responder(const Key& initiator);

  Side side_;
  Step step_ = Step::kFirst;
  Key private_;
  Key public_{};
  Key theirs_{};
  std::optional<Key> responder_;  ///< of NKpsk0
  Symmetric state_;
};

}  // namespace hapticd::noise
