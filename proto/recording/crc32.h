// CRC-32 as MCAP, PNG and zip use it: polynomial 0xEDB88320 reflected, start and end inverted
// (ISO 3309). Not RT, about 2 ns per byte.
#pragma once

#include <cstdint>
#include <string_view>

namespace hapticd {

/// CRC of the bytes so far (`crc`, 0 at the start) followed by `bytes`.
[[nodiscard]] std::uint32_t crc32(std::string_view bytes, std::uint32_t crc = 0) noexcept;

}  // namespace hapticd
