// What a server adds to a RETRY so that its client knows who sent it: a MAC under the psk of the
// handshake that the RETRY answers. PROTOCOL.md, section 12. Pure. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/noise/handshake.h"

namespace hapticd::noise {

inline constexpr std::size_t kRetryTagBytes = 16;
using RetryTag = std::array<std::uint8_t, kRetryTagBytes>;

/// BLAKE2b of 16 bytes, keyed with the psk, over "RETRY", the prologue of the handshake, the
/// client's ephemeral public key (the first 32 bytes of `message`, at least 32) and the cookie.
[[nodiscard]] RetryTag retry_tag(const Key& psk, std::span<const std::uint8_t> prologue,
                                 std::span<const std::uint8_t> message,
                                 std::span<const std::uint8_t> cookie);

/// Whether the last 16 bytes of `body` are the tag of what is before them, at least one byte.
[[nodiscard]] bool is_tagged_retry(const Key& psk, std::span<const std::uint8_t> prologue,
                                   std::span<const std::uint8_t> message,
                                   std::span<const std::uint8_t> body);

}  // namespace hapticd::noise
