// See retry_tag.h.
#include "proto/noise/retry_tag.h"

#include <sodium.h>

#include <string_view>

namespace hapticd::noise {

RetryTag retry_tag(const Key& psk, std::span<const std::uint8_t> prologue,
                   std::span<const std::uint8_t> message, std::span<const std::uint8_t> cookie) {
  constexpr std::string_view kWhat = "RETRY";
  crypto_generichash_blake2b_state state;
  crypto_generichash_blake2b_init(&state, psk.data(), psk.size(), kRetryTagBytes);
  crypto_generichash_blake2b_update(&state, reinterpret_cast<const std::uint8_t*>(kWhat.data()),
                                    kWhat.size());
  crypto_generichash_blake2b_update(&state, prologue.data(), prologue.size());
  crypto_generichash_blake2b_update(&state, message.data(), kKeyBytes);
  crypto_generichash_blake2b_update(&state, cookie.data(), cookie.size());
  RetryTag tag{};
  crypto_generichash_blake2b_final(&state, tag.data(), tag.size());
  return tag;
}

bool is_tagged_retry(const Key& psk, std::span<const std::uint8_t> prologue,
                     std::span<const std::uint8_t> message, std::span<const std::uint8_t> body) {
  if (body.size() <= kRetryTagBytes) return false;
  const RetryTag tag = retry_tag(psk, prologue, message, body.first(body.size() - kRetryTagBytes));
  return sodium_memcmp(tag.data(), body.last(kRetryTagBytes).data(), tag.size()) == 0;
}

}  // namespace hapticd::noise
