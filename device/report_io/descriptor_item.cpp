// See descriptor_item.h.
#include "device/report_io/descriptor_item.h"

namespace hapticd {

bool next_item(std::span<const std::uint8_t>& bytes, DescriptorItem& item) noexcept {
  constexpr std::uint8_t kLongItem = 0xFE;
  constexpr unsigned kSizeMask = 3;
  const unsigned prefix = bytes[0];
  if (prefix == kLongItem) {
    constexpr std::size_t kLongHead = 3;
    if (bytes.size() < kLongHead || bytes.size() - kLongHead < bytes[1]) return false;
    item = {};
    bytes = bytes.subspan(kLongHead + bytes[1]);
    return true;
  }
  const unsigned code = prefix & kSizeMask;
  const std::size_t size = code == 3 ? 4 : code;
  if (bytes.size() - 1 < size) return false;
  item = {static_cast<ItemKind>(prefix & ~kSizeMask), 0, 0, size};
  for (std::size_t i = 0; i < size; ++i) item.value |= std::uint32_t{bytes[1 + i]} << (8 * i);
  const std::size_t unused = 32 - 8 * size;
  // Arithmetic shift: the sign comes down with it.
  item.signed_value =
      size == 0 ? 0 : static_cast<std::int32_t>(item.value << unused) >> static_cast<int>(unused);
  bytes = bytes.subspan(1 + size);
  return true;
}

}  // namespace hapticd
