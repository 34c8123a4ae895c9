// What every reader of HID report descriptors has in common (Device Class Definition for HID 1.11,
// section 6.2.2): the global items in force, with their stack, and the way through all items. A
// reader adds what it makes of main and local items. Bytes come from a stranger's USB plug: every
// length is checked, everything is bounded. No heap of its own; O(bytes).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/fixed_vector.h"
#include "device/report_io/descriptor_item.h"

namespace hapticd {

/// Longest descriptor that Linux accepts, bytes; longer ones are refused.
inline constexpr std::size_t kMaxDescriptor = 4096;
/// Reports told of one descriptor; one with more is refused. HID profile v1 has six, force devices
/// of the PID class about 20.
inline constexpr std::size_t kMaxReports = 64;
/// Longest report that Linux keeps, bytes; a descriptor with a longer one is refused.
inline constexpr std::size_t kMaxReportRead = 16'384;

enum class ReportKind : std::uint8_t { kInput, kOutput, kFeature };

/// What is wrong with a descriptor.
enum class DescriptorFlaw : std::uint8_t {
  kNone,
  kTooLong,      ///< more than kMaxDescriptor
  kCutOff,       ///< ends within an item
  kUnbalanced,   ///< collections or stacked globals that do not match, or too deep
  kBadReportId,  ///< 0, or more than a byte holds
  kTooLarge,     ///< more reports, or longer ones, than the bounds above; more than a reader takes
};

/// A usage with its page, as descriptors pack them.
[[nodiscard]] constexpr std::uint32_t usage_of(std::uint32_t page, std::uint32_t usage) noexcept {
  return page << 16U | usage;
}

/// A usage as an item names it: one of four bytes has its own page.
struct NamedUsage {
  std::uint32_t value = 0;
  bool has_page = false;
};

/// The usage of a local item.
[[nodiscard]] constexpr NamedUsage named_usage(const DescriptorItem& item) noexcept {
  return {item.value, item.data_bytes == 4};
}

/// Global items in force.
struct DescriptorGlobals {
  std::uint32_t usage_page = 0;
  std::int64_t minimum = 0;           ///< logical
  std::int64_t maximum = 0;           ///< logical, as a signed number
  std::int64_t maximum_unsigned = 0;  ///< as another one
  std::uint32_t report_size = 0;      ///< bits of a field
  std::uint32_t report_count = 0;
  std::uint8_t report_id = 0;  ///< 0: the descriptor uses no IDs

  /// The page that counts is the one in force at the main item, not the one before the usage.
  [[nodiscard]] std::uint32_t resolve(NamedUsage usage) const noexcept {
    return usage.has_page ? usage.value : usage_of(usage_page, usage.value);
  }
  /// Bits that a main item adds to its report. Both factors have 32 bits.
  [[nodiscard]] std::uint64_t bits() const noexcept {
    return std::uint64_t{report_size} * report_count;
  }
};

/// The global items in force, kept as items come.
class GlobalItems {
 public:
  /// Takes in a global item; any other changes nothing.
  DescriptorFlaw take(const DescriptorItem& item) noexcept;
  [[nodiscard]] const DescriptorGlobals& operator*() const noexcept { return now_; }
  [[nodiscard]] const DescriptorGlobals* operator->() const noexcept { return &now_; }

 private:
  /// Bound of what a sane device stacks.
  static constexpr std::size_t kDeepestStack = 4;

  DescriptorGlobals now_;
  FixedVector<DescriptorGlobals, kDeepestStack> stack_;
};

/// Gives `reader` all items of a descriptor in turn, by `DescriptorFlaw take(const
/// DescriptorItem&)`, until one is flawed; at the end all its collections have to be closed (`bool
/// is_closed()`).
template <class Reader>
[[nodiscard]] DescriptorFlaw read_items(std::span<const std::uint8_t> bytes, Reader& reader) {
  if (bytes.size() > kMaxDescriptor) return DescriptorFlaw::kTooLong;
  while (!bytes.empty()) {
    DescriptorItem item;
    if (!next_item(bytes, item)) return DescriptorFlaw::kCutOff;
    if (const DescriptorFlaw flaw = reader.take(item); flaw != DescriptorFlaw::kNone) return flaw;
  }
  return reader.is_closed() ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
}

}  // namespace hapticd
