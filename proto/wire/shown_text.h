// Text that came from somebody else, as it may stand on a terminal, in a log or in an error: the
// one place that decides it. What a terminal would obey, or what would turn the order of letters
// around, is shown by its number instead. Pure. Not RT.
#pragma once

#include <cstdint>
#include <string>

#include "proto/wire/whole_characters.h"

namespace hapticd::wire {

/// Whether a terminal would do something else than show this character: the controls C0 and C1,
/// DEL, and what changes direction, breaks lines or is not seen (Unicode's Bidi_Control, U+2028,
/// U+2029, U+FEFF).
[[nodiscard]] constexpr bool is_control(std::uint32_t character) noexcept {
  return character < 0x20U || (character >= 0x7fU && character < 0xa0U) || character == 0x061cU ||
         character == 0x200eU || character == 0x200fU ||
         (character >= 0x2028U && character <= 0x202eU) ||
         (character >= 0x2066U && character <= 0x2069U) || character == 0xfeffU;
}

/// The character of UTF-8 in `bytes` bytes, [1, 4], at text[at].
[[nodiscard]] inline std::uint32_t character_at(const std::string& text, std::size_t at,
                                                std::size_t bytes) {
  const auto byte = [&](std::size_t k) {
    return std::uint32_t{static_cast<unsigned char>(text[at + k])};
  };
  if (bytes == 1) return byte(0);
  std::uint32_t character = byte(0) & (0x7fU >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) character = character << 6U | (byte(k) & 0x3fU);
  return character;
}

/// Whether `text` is UTF-8 without controls: a name that can be shown as it is.
[[nodiscard]] inline bool is_plain(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = character_bytes(text, at);
    if (bytes == 0 || is_control(character_at(text, at, bytes))) return false;
    at += bytes;
  }
  return true;
}

/// `text` with \uXXXX for every control that is not one of `kept`, and '?' for every byte of no
/// character.
[[nodiscard]] inline std::string without_controls(const std::string& text, const char* kept) {
  constexpr const char* kDigits = "0123456789abcdef";
  const std::string as_they_are = kept;
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = character_bytes(text, at);
    if (bytes == 0) {
      shown += '?';
      ++at;
      continue;
    }
    const std::uint32_t character = character_at(text, at, bytes);
    if (!is_control(character) || (bytes == 1 && as_they_are.find(text[at]) != std::string::npos)) {
      shown.append(text, at, bytes);
    } else {
      shown += "\\u";
      for (const unsigned shift : {12U, 8U, 4U, 0U}) shown += kDigits[character >> shift & 0xfU];
    }
    at += bytes;
  }
  return shown;
}

/// One line of text: nothing in it is a control.
[[nodiscard]] inline std::string shown_text(const std::string& text) {
  return without_controls(text, "");
}

/// The same for what may have several lines.
[[nodiscard]] inline std::string shown_lines(const std::string& text) {
  return without_controls(text, "\n");
}

}  // namespace hapticd::wire
