// See handshake.h. Names of the steps are those of the Noise specification, section 5.
#include "proto/noise/handshake.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

namespace hapticd::noise {
namespace {

constexpr std::string_view kProtocolName = "Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b";
constexpr std::size_t kHashBytes = 64;
/// Block of BLAKE2b, bytes: what HMAC pads its key to.
constexpr std::size_t kBlockBytes = 128;
constexpr std::size_t kNonceBytes = crypto_aead_chacha20poly1305_ietf_NPUBBYTES;

static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == kKeyBytes);
static_assert(crypto_aead_chacha20poly1305_ietf_ABYTES == kTagBytes);
static_assert(crypto_scalarmult_BYTES == kKeyBytes);
static_assert(crypto_generichash_blake2b_BYTES_MAX == kHashBytes);
static_assert(kProtocolName.size() <= kHashBytes);

using Hash = std::array<std::uint8_t, kHashBytes>;
using View = std::span<const std::uint8_t>;

/// Lets libsodium choose what this processor does best; harmless when repeated.
void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium does not start");
}

/// BLAKE2b of two runs of bytes.
Hash hash_of(View first, View second) {
  crypto_generichash_blake2b_state state;
  crypto_generichash_blake2b_init(&state, nullptr, 0, kHashBytes);
  crypto_generichash_blake2b_update(&state, first.data(), first.size());
  crypto_generichash_blake2b_update(&state, second.data(), second.size());
  Hash hash;
  crypto_generichash_blake2b_final(&state, hash.data(), hash.size());
  return hash;
}

/// HMAC (RFC 2104) with BLAKE2b; the key is a hash and so shorter than a block.
Hash hmac(const Hash& key, View data) {
  std::array<std::uint8_t, kBlockBytes> inner{};
  std::array<std::uint8_t, kBlockBytes> outer{};
  for (std::size_t i = 0; i < kBlockBytes; ++i) {
    const std::uint8_t byte = i < key.size() ? key[i] : std::uint8_t{0};
    inner[i] = byte ^ 0x36U;
    outer[i] = byte ^ 0x5cU;
  }
  return hash_of(outer, hash_of(inner, data));
}

/// HKDF as the specification has it: `Count` outputs.
template <std::size_t Count>
std::array<Hash, Count> hkdf(const Hash& chaining, View material) {
  const Hash temporary = hmac(chaining, material);
  std::array<Hash, Count> outputs{};
  Bytes data;
  for (std::size_t i = 0; i < Count; ++i) {
    if (i > 0) data.assign(outputs[i - 1].begin(), outputs[i - 1].end());
    data.push_back(static_cast<std::uint8_t>(i + 1));
    outputs[i] = hmac(temporary, data);
  }
  return outputs;
}

Key key_of(const Hash& hash) {
  Key key;
  std::copy_n(hash.begin(), key.size(), key.begin());
  return key;
}

std::array<std::uint8_t, kNonceBytes> nonce_of(std::uint64_t n) {
  std::array<std::uint8_t, kNonceBytes> nonce{};
  for (std::size_t i = 0; i < 8; ++i) nonce[4 + i] = static_cast<std::uint8_t>(n >> (8 * i));
  return nonce;
}

}  // namespace

Bytes Cipher::seal(std::uint64_t n, View associated, View plain) const {
  Bytes sealed(plain.size() + kTagBytes);
  const auto nonce = nonce_of(n);
  crypto_aead_chacha20poly1305_ietf_encrypt(sealed.data(), nullptr, plain.data(), plain.size(),
                                            associated.data(), associated.size(), nullptr,
                                            nonce.data(), key_.data());
  return sealed;
}

std::optional<Bytes> Cipher::open(std::uint64_t n, View associated, View sealed) const {
  if (sealed.size() < kTagBytes) return std::nullopt;
  Bytes plain(sealed.size() - kTagBytes);
  const auto nonce = nonce_of(n);
  const int bad = crypto_aead_chacha20poly1305_ietf_decrypt(
      plain.data(), nullptr, nullptr, sealed.data(), sealed.size(), associated.data(),
      associated.size(), nonce.data(), key_.data());
  if (bad != 0) return std::nullopt;
  return plain;
}

Handshake::Handshake(Side side, const Key& psk, View prologue, const Key& ephemeral)
    : side_(side), private_(ephemeral) {
  start_sodium();
  crypto_scalarmult_base(public_.data(), private_.data());
  std::copy(kProtocolName.begin(), kProtocolName.end(), state_.hash.begin());
  state_.chaining = state_.hash;
  mix_hash(prologue);
  // Token psk: MixKeyAndHash.
  const auto [chaining, hashed, key] = hkdf<3>(state_.chaining, psk);
  state_.chaining = chaining;
  mix_hash(hashed);
  state_.key = key_of(key);
}

Handshake::~Handshake() {
  sodium_memzero(private_.data(), private_.size());
  sodium_memzero(&state_, sizeof state_);
}

void Handshake::mix_hash(View data) { state_.hash = hash_of(state_.hash, data); }

void Handshake::mix_key(View material) {
  const auto [chaining, key] = hkdf<2>(state_.chaining, material);
  state_.chaining = chaining;
  state_.key = key_of(key);
}

// Token ee.
bool Handshake::mix_shared(const Key& theirs) {
  Key shared;
  if (crypto_scalarmult(shared.data(), private_.data(), theirs.data()) != 0) return false;
  mix_key(shared);
  sodium_memzero(shared.data(), shared.size());
  return true;
}

std::optional<Bytes> Handshake::write(View payload) {
  const Step turn = side_ == Side::kInitiator ? Step::kFirst : Step::kSecond;
  if (step_ != turn) throw std::logic_error("not this side's turn to write");
  const Symmetric before = state_;
  // Token e: with a psk it is mixed into the key too.
  mix_hash(public_);
  mix_key(public_);
  if (side_ == Side::kResponder && !mix_shared(theirs_)) {
    state_ = before;
    return std::nullopt;
  }
  const Bytes sealed = Cipher(state_.key).seal(0, state_.hash, payload);
  mix_hash(sealed);
  step_ = side_ == Side::kInitiator ? Step::kSecond : Step::kDone;
  Bytes message(public_.begin(), public_.end());
  message.insert(message.end(), sealed.begin(), sealed.end());
  return message;
}

std::optional<Bytes> Handshake::read(View message) {
  const Step turn = side_ == Side::kInitiator ? Step::kSecond : Step::kFirst;
  if (step_ != turn) throw std::logic_error("not this side's turn to read");
  if (message.size() < kMessageBytes) return std::nullopt;
  const Symmetric before = state_;
  Key theirs;
  std::copy_n(message.begin(), theirs.size(), theirs.begin());
  mix_hash(theirs);
  mix_key(theirs);
  const View sealed = message.subspan(kKeyBytes);
  std::optional<Bytes> payload;
  if (side_ == Side::kResponder || mix_shared(theirs)) {
    payload = Cipher(state_.key).open(0, state_.hash, sealed);
  }
  if (!payload.has_value()) {
    state_ = before;
    return std::nullopt;
  }
  mix_hash(sealed);
  theirs_ = theirs;
  step_ = side_ == Side::kInitiator ? Step::kDone : Step::kSecond;
  return payload;
}

Transport Handshake::split() const {
  if (step_ != Step::kDone) throw std::logic_error("the handshake is not done");
  const auto [first, second] = hkdf<2>(state_.chaining, {});
  const Cipher initiator(key_of(first));
  const Cipher responder(key_of(second));
  return side_ == Side::kInitiator ? Transport{initiator, responder}
                                   : Transport{responder, initiator};
}

}  // namespace hapticd::noise
