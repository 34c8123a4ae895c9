// What a HELLO of NKpsk0 carries outside of Noise: which key it is of, and a MAC under that key, so
// that a server refuses a HELLO before any scalar multiplication. PROTOCOL.md, section 12. Pure.
// Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/noise/handshake.h"

namespace hapticd::noise {

inline constexpr std::size_t kKeyIdBytes = 8;
inline constexpr std::size_t kHelloTagBytes = 16;
/// Names a psk, and tells nothing of it.
using KeyId = std::array<std::uint8_t, kKeyIdBytes>;
using HelloTag = std::array<std::uint8_t, kHelloTagBytes>;

/// BLAKE2b of 8 bytes, keyed with the psk, over "KEY ID".
[[nodiscard]] KeyId key_id(const Key& psk);

/// The key of the MACs of HELLOs: BLAKE2b of 32 bytes, keyed with the psk, over "HELLO".
[[nodiscard]] Key hello_key(const Key& psk);

/// BLAKE2b of 16 bytes, keyed with hello_key(), over all of the HELLO before the tag.
[[nodiscard]] HelloTag hello_tag(const Key& hello_key, std::span<const std::uint8_t> before);

/// Whether `tag` is that, in constant time.
[[nodiscard]] bool is_hello_tag(const Key& hello_key, std::span<const std::uint8_t> before,
                                std::span<const std::uint8_t> tag);

}  // namespace hapticd::noise
