// Texts that have to be short: cut between characters of UTF-8, so that they stay text, and made
// text where they are none. Protobuf refuses a string that is none, and with it the whole Packet.
// Not RT.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace hapticd::wire {

/// Longest Result.path and Result.message, bytes.
inline constexpr std::size_t kPathBytes = 256;
inline constexpr std::size_t kMessageBytes = 400;

/// Bytes of the character of UTF-8 that begins at text[at]; 0: none begins there. Overlong forms,
/// surrogates and what is beyond U+10FFFF are none (RFC 3629, section 4).
[[nodiscard]] inline std::size_t character_bytes(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t k) -> unsigned {
    return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0U;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80U) return 1;
  if (lead < 0xc2U || lead > 0xf4U) return 0;
  const std::size_t bytes = lead < 0xe0U ? 2 : lead < 0xf0U ? 3 : 4;
  const unsigned lowest = lead == 0xe0U ? 0xa0U : lead == 0xf0U ? 0x90U : 0x80U;
  const unsigned highest = lead == 0xedU ? 0x9fU : lead == 0xf4U ? 0x8fU : 0xbfU;
  if (byte(1) < lowest || byte(1) > highest) return 0;
  for (std::size_t k = 2; k < bytes; ++k) {
    if ((byte(k) & 0xc0U) != 0x80U) return 0;
  }
  return bytes;
}

/// The beginning of `text` in UTF-8, at most `bytes` of it; '?' for every byte of no character.
[[nodiscard]] inline std::string whole_characters(const std::string& text, std::size_t bytes) {
  std::string whole;
  whole.reserve(std::min(bytes, text.size()));
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t character = character_bytes(text, at);
    const std::size_t taken = std::max<std::size_t>(character, 1);
    if (at + taken > bytes) break;
    if (character == 0) {
      whole += '?';
    } else {
      whole.append(text, at, character);
    }
    at += taken;
  }
  return whole;
}

}  // namespace hapticd::wire
