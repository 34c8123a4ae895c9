// See handshake.h. Names of the steps are those of the Noise specification, section 5.
#include "proto/noise/handshake.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

namespace hapticd::noise {
namespace {

constexpr std::string_view kNobodyKnown = "Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b";
constexpr std::string_view kResponderKnown = "Noise_NKpsk0_25519_ChaChaPoly_BLAKE2b";
constexpr std::size_t kHashBytes = 64;
/// Block of BLAKE2b, bytes: what HMAC pads its key to.
constexpr std::size_t kBlockBytes = 128;
constexpr std::size_t kNonceBytes = crypto_aead_chacha20poly1305_ietf_NPUBBYTES;

static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == kKeyBytes);
static_assert(crypto_aead_chacha20poly1305_ietf_ABYTES == kTagBytes);
static_assert(crypto_scalarmult_BYTES == kKeyBytes);
static_assert(crypto_generichash_blake2b_BYTES_MAX == kHashBytes);
static_assert(kNobodyKnown.size() <= kHashBytes && kResponderKnown.size() <= kHashBytes);

using Hash = std::array<std::uint8_t, kHashBytes>;
using View = std::span<const std::uint8_t>;

/// Lets libsodium choose what this processor does best; harmless when repeated.
void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium does not start");
}

/// BLAKE2b of two runs of bytes. It wipes what it reckons with.
void hash_into(Hash& hash, View first, View second) {
  crypto_generichash_blake2b_state state;
  crypto_generichash_blake2b_init(&state, nullptr, 0, kHashBytes);
  crypto_generichash_blake2b_update(&state, first.data(), first.size());
  crypto_generichash_blake2b_update(&state, second.data(), second.size());
  crypto_generichash_blake2b_final(&state, hash.data(), hash.size());
}

Hash hash_of(View first, View second) {
  Hash hash;
  hash_into(hash, first, second);
  return hash;
}

/// What keys come of, overwritten with zeros where it goes out of scope.
template <typename Value>
class Wiped : public Value {
 public:
  Wiped() : Value{} {}
  explicit Wiped(const Value& value) : Value(value) {}
  Wiped(const Wiped&) = default;
  Wiped& operator=(const Wiped&) = default;
  ~Wiped() { sodium_memzero(this, sizeof(Value)); }
};

/// HMAC (RFC 2104) with BLAKE2b; the key is a hash and so shorter than a block.
void hmac_into(Hash& hash, const Hash& key, View data) {
  Wiped<std::array<std::uint8_t, kBlockBytes>> inner;
  Wiped<std::array<std::uint8_t, kBlockBytes>> outer;
  for (std::size_t i = 0; i < kBlockBytes; ++i) {
    const std::uint8_t byte = i < key.size() ? key[i] : std::uint8_t{0};
    inner[i] = byte ^ 0x36U;
    outer[i] = byte ^ 0x5cU;
  }
  Wiped<Hash> within;
  hash_into(within, inner, data);
  hash_into(hash, outer, within);
}

/// HKDF as the specification has it: `Count` outputs.
template <std::size_t Count>
std::array<Wiped<Hash>, Count> hkdf(const Hash& chaining, View material) {
  Wiped<Hash> temporary;
  hmac_into(temporary, chaining, material);
  std::array<Wiped<Hash>, Count> outputs;
  // The output before, and its number.
  Wiped<std::array<std::uint8_t, kHashBytes + 1>> data;
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < Count; ++i) {
    data[bytes] = static_cast<std::uint8_t>(i + 1);
    hmac_into(outputs[i], temporary, View(data).first(bytes + 1));
    bytes = kHashBytes;
    std::copy(outputs[i].begin(), outputs[i].end(), data.begin());
  }
  return outputs;
}

void key_from(const Hash& hash, Key& key) { std::copy_n(hash.begin(), key.size(), key.begin()); }

std::array<std::uint8_t, kNonceBytes> nonce_of(std::uint64_t n) {
  std::array<std::uint8_t, kNonceBytes> nonce{};
  for (std::size_t i = 0; i < 8; ++i) nonce[4 + i] = static_cast<std::uint8_t>(n >> (8 * i));
  return nonce;
}

/// What a sealed message is bound to beside its key.
struct Bound {
  std::uint64_t n;
  View associated;
};

Bytes sealed_with(const Key& key, const Bound& bound, View plain) {
  Bytes sealed(plain.size() + kTagBytes);
  const auto nonce = nonce_of(bound.n);
  crypto_aead_chacha20poly1305_ietf_encrypt(sealed.data(), nullptr, plain.data(), plain.size(),
                                            bound.associated.data(), bound.associated.size(),
                                            nullptr, nonce.data(), key.data());
  return sealed;
}

std::optional<Bytes> opened_with(const Key& key, const Bound& bound, View sealed) {
  if (sealed.size() < kTagBytes) return std::nullopt;
  Bytes plain(sealed.size() - kTagBytes);
  const auto nonce = nonce_of(bound.n);
  const int bad = crypto_aead_chacha20poly1305_ietf_decrypt(
      plain.data(), nullptr, nullptr, sealed.data(), sealed.size(), bound.associated.data(),
      bound.associated.size(), nonce.data(), key.data());
  if (bad != 0) return std::nullopt;
  return plain;
}

}  // namespace

Key public_half(const Key& private_half) {
  Key half;
  crypto_scalarmult_base(half.data(), private_half.data());
  return half;
}

Bytes Cipher::seal(std::uint64_t n, View associated, View plain) const {
  return sealed_with(key_.get(), {n, associated}, plain);
}

std::optional<Bytes> Cipher::open(std::uint64_t n, View associated, View sealed) const {
  return opened_with(key_.get(), {n, associated}, sealed);
}

Symmetric::Symmetric(const Key& psk, View prologue) {
  begin(kNobodyKnown, prologue);
  mix_psk(psk);
}

Symmetric::Symmetric(const Key& psk, View prologue, const Key& responder) {
  begin(kResponderKnown, prologue);
  // The message before the first: s.
  mix_hash(responder);
  mix_psk(psk);
}

void Symmetric::begin(std::string_view name, View prologue) {
  start_sodium();
  std::copy(name.begin(), name.end(), hash_.begin());
  chaining_ = hash_;
  mix_hash(prologue);
}

// Token psk: MixKeyAndHash.
void Symmetric::mix_psk(const Key& psk) {
  const auto [chaining, hashed, key] = hkdf<3>(chaining_, psk);
  chaining_ = chaining;
  mix_hash(hashed);
  key_from(key, key_);
}

void Symmetric::mix_hash(View data) { hash_ = hash_of(hash_, data); }

void Symmetric::mix_key(View material) {
  const auto [chaining, key] = hkdf<2>(chaining_, material);
  chaining_ = chaining;
  key_from(key, key_);
}

Bytes Symmetric::seal(View payload) {
  Bytes sealed = sealed_with(key_, {0, hash_}, payload);
  mix_hash(sealed);
  return sealed;
}

std::optional<Bytes> Symmetric::open(View sealed) {
  std::optional<Bytes> payload = opened_with(key_, {0, hash_}, sealed);
  if (payload.has_value()) mix_hash(sealed);
  return payload;
}

bool Symmetric::is_first(View message) const {
  if (message.size() != kMessageBytes) return false;
  const View ephemeral = message.first(kKeyBytes);
  const Hash hash = hash_of(hash_, ephemeral);
  Wiped<Key> key;
  key_from(hkdf<2>(chaining_, ephemeral)[1], key);
  const auto nonce = nonce_of(0);
  const View tag = message.subspan(kKeyBytes);
  return crypto_aead_chacha20poly1305_ietf_decrypt_detached(nullptr, nullptr, tag.data(), 0,
                                                            tag.data(), hash.data(), hash.size(),
                                                            nonce.data(), key.data()) == 0;
}

std::array<Locked<Key>, 2> Symmetric::split() const {
  const auto keys = hkdf<2>(chaining_, {});
  const auto locked = [](const Hash& hash) {
    return Locked<Key>::filled([&](Key& key) { key_from(hash, key); });
  };
  return {locked(keys[0]), locked(keys[1])};
}

void Symmetric::wipe() {
  for (const std::span<std::uint8_t> bytes :
       {std::span<std::uint8_t>(hash_), {chaining_}, {key_}}) {
    sodium_memzero(bytes.data(), bytes.size());
  }
}

Handshake::Handshake(Side side, const Symmetric& start, const Key& ephemeral)
    : side_(side), private_(ephemeral), public_(public_half(ephemeral)), state_(start) {}

Handshake::Handshake(Side side, const Symmetric& start, const Key& ephemeral, const Key& responder)
    : Handshake(side, start, ephemeral) {
  responder_ = responder;
}

Handshake::~Handshake() {
  sodium_memzero(private_.data(), private_.size());
  if (responder_.has_value()) sodium_memzero(responder_->data(), responder_->size());
  state_.wipe();
}

// Token ee or es.
bool Handshake::mix_shared(const Key& mine, const Key& theirs) {
  Wiped<Key> shared;
  if (crypto_scalarmult(shared.data(), mine.data(), theirs.data()) != 0) return false;
  state_.mix_key(shared);
  return true;
}

// Token es of NKpsk0; `initiator` is the ephemeral public key of that side.
bool Handshake::mix_responder(const Key& initiator) {
  if (!responder_.has_value()) return true;
  return side_ == Side::kInitiator ? mix_shared(private_, *responder_)
                                   : mix_shared(*responder_, initiator);
}

std::optional<Bytes> Handshake::write(View payload) {
  const Step turn = side_ == Side::kInitiator ? Step::kFirst : Step::kSecond;
  if (step_ != turn) throw std::logic_error("not this side's turn to write");
  const Wiped<Symmetric> before(state_);
  // Token e: with a psk it is mixed into the key too.
  state_.mix_hash(public_);
  state_.mix_key(public_);
  const bool mixed =
      side_ == Side::kInitiator ? mix_responder(public_) : mix_shared(private_, theirs_);
  if (!mixed) {
    state_ = before;
    return std::nullopt;
  }
  const Bytes sealed = state_.seal(payload);
  step_ = side_ == Side::kInitiator ? Step::kSecond : Step::kDone;
  Bytes message(public_.begin(), public_.end());
  message.insert(message.end(), sealed.begin(), sealed.end());
  return message;
}

std::optional<Bytes> Handshake::read(View message) {
  const Step turn = side_ == Side::kInitiator ? Step::kSecond : Step::kFirst;
  if (step_ != turn) throw std::logic_error("not this side's turn to read");
  if (message.size() < kMessageBytes) return std::nullopt;
  const Wiped<Symmetric> before(state_);
  Key theirs;
  std::copy_n(message.begin(), theirs.size(), theirs.begin());
  state_.mix_hash(theirs);
  state_.mix_key(theirs);
  std::optional<Bytes> payload;
  if (side_ == Side::kResponder ? mix_responder(theirs) : mix_shared(private_, theirs)) {
    payload = state_.open(message.subspan(kKeyBytes));
  }
  if (!payload.has_value()) {
    state_ = before;
    return std::nullopt;
  }
  theirs_ = theirs;
  step_ = side_ == Side::kInitiator ? Step::kDone : Step::kSecond;
  return payload;
}

Transport Handshake::split() const {
  if (step_ != Step::kDone) throw std::logic_error("the handshake is not done");
  const auto [first, second] = state_.split();
  const Cipher initiator(first);
  const Cipher responder(second);
  return side_ == Side::kInitiator ? Transport{initiator, responder}
                                   : Transport{responder, initiator};
}

}  // namespace hapticd::noise
