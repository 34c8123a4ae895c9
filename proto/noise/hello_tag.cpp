// See hello_tag.h.
#include "proto/noise/hello_tag.h"

#include <sodium.h>

#include <string_view>

namespace hapticd::noise {
namespace {

/// BLAKE2b of as many bytes, keyed.
template <std::size_t Bytes>
std::array<std::uint8_t, Bytes> keyed_hash(const Key& key, std::span<const std::uint8_t> data) {
  std::array<std::uint8_t, Bytes> hash{};
  crypto_generichash_blake2b(hash.data(), hash.size(), data.data(), data.size(), key.data(),
                             key.size());
  return hash;
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

KeyId key_id(const Key& psk) { return keyed_hash<kKeyIdBytes>(psk, bytes_of("KEY ID")); }

Key hello_key(const Key& psk) { return keyed_hash<kKeyBytes>(psk, bytes_of("HELLO")); }

HelloTag hello_tag(const Key& hello_key, std::span<const std::uint8_t> before) {
  return keyed_hash<kHelloTagBytes>(hello_key, before);
}

bool is_hello_tag(const Key& hello_key, std::span<const std::uint8_t> before,
                  std::span<const std::uint8_t> tag) {
  return tag.size() == kHelloTagBytes &&
         sodium_memcmp(hello_tag(hello_key, before).data(), tag.data(), tag.size()) == 0;
}

}  // namespace hapticd::noise
