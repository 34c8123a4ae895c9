// Texts that have to be short: cut between characters of UTF-8, so that they stay text. Protobuf
// refuses a string that is none, and with it the whole Packet. Not RT.
#pragma once

#include <cstddef>
#include <string>

namespace hapticd::wire {

/// Longest Result.path and Result.message, bytes.
inline constexpr std::size_t kPathBytes = 256;
inline constexpr std::size_t kMessageBytes = 400;

/// The beginning of `text` in UTF-8, at most `bytes` of it.
[[nodiscard]] inline std::string whole_characters(const std::string& text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; };
  while (bytes > 0 && continues(text[bytes])) --bytes;
  return text.substr(0, bytes);
}

}  // namespace hapticd::wire
