// Whether a text may stand on a terminal or in a log as it is: the fuzz targets' own judge of what
// programs say. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hapticd::test {

/// Bytes of the character of UTF-8 (RFC 3629) at text[at], which is decoded into `character`; 0:
/// there is none.
[[nodiscard]] inline std::size_t decode_character(const std::string& text, std::size_t at,
                                                  std::uint32_t& character) {
  const auto byte = [&](std::size_t k) -> std::uint32_t {
    return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0U;
  };
  std::size_t bytes = 1;
  character = byte(0);
  if (character >= 0x80U) {
    bytes = character >= 0xf0U ? 4 : character >= 0xe0U ? 3 : character >= 0xc0U ? 2 : 0;
    character &= bytes == 4 ? 0x0fU : bytes == 3 ? 0x0fU : 0x1fU;
    for (std::size_t k = 1; k < bytes; ++k) {
      if ((byte(k) & 0xc0U) != 0x80U) return 0;
      character = character << 6U | (byte(k) & 0x3fU);
    }
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xd800U && character < 0xe000U;
  return character < kLeast[bytes] || character > 0x10ffffU || surrogate ? 0 : bytes;
}

/// UTF-8 in which a terminal finds nothing to obey, nor to turn around; `lines`: but ends of lines.
[[nodiscard]] inline bool is_plain_line(const std::string& text, bool lines = false) {
  for (std::size_t at = 0; at < text.size();) {
    std::uint32_t c = 0;
    const std::size_t bytes = decode_character(text, at, c);
    const bool obeyed = c < 0x20U || (c >= 0x7fU && c <= 0x9fU);
    const bool turns = c == 0x200eU || c == 0x200fU || (c >= 0x202aU && c <= 0x202eU) ||
                       (c >= 0x2066U && c <= 0x2069U);
    if (bytes == 0 || turns || (obeyed && !(lines && c == '\n'))) return false;
    at += bytes;
  }
  return true;
}

}  // namespace hapticd::test
