// The items that a HID report descriptor is a row of (Device Class Definition for HID 1.11, section
// 6.2.2): what every reader of descriptors begins with. Bytes come from a stranger's USB plug:
// every length is checked. No heap; O(1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace hapticd {

/// Prefixes without their two size bits: type and tag. Others occur and mean nothing here.
enum class ItemKind : std::uint8_t {
  kUsagePage = 0x04,
  kUsage = 0x08,
  kReserved = 0x0C,  ///< long items too
  kMinimum = 0x14,   ///< logical
  kFirstUsage = 0x18,
  kMaximum = 0x24,  ///< logical
  kLastUsage = 0x28,
  kReportSize = 0x74,
  kInput = 0x80,
  kReportId = 0x84,
  kOutput = 0x90,
  kReportCount = 0x94,
  kCollection = 0xA0,
  kPush = 0xA4,
  kFeature = 0xB0,
  kPop = 0xB4,
  kEndCollection = 0xC0,
};

struct DescriptorItem {
  ItemKind kind = ItemKind::kReserved;
  std::uint32_t value = 0;        ///< unsigned
  std::int32_t signed_value = 0;  ///< the same bits
  std::size_t data_bytes = 0;     ///< 0, 1, 2 or 4
};

/// A main item: an input, output, feature, or an end of a collection; it ends the life of all local
/// ones.
[[nodiscard]] constexpr bool is_main(ItemKind kind) noexcept {
  constexpr unsigned kTypeMask = 0x0C;
  return (static_cast<unsigned>(kind) & kTypeMask) == 0;
}

/// Takes the next item off the front of `bytes`, which are not empty; false when they end within
/// it. Long items, which nobody uses, come out as a reserved one.
[[nodiscard]] bool next_item(std::span<const std::uint8_t>& bytes, DescriptorItem& item) noexcept;

}  // namespace hapticd
