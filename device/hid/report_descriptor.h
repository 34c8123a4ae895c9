// HID report descriptors: the one of profile v1, and a reader that says of any descriptor whether
// it is one of this profile, whoever made the device (Device Class Definition for HID 1.11, section
// 6.2.2). Bytes come from a stranger's USB plug: every length is checked, everything is bounded.
// RT: no, but it allocates nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/fixed_vector.h"
#include "device/report_io/descriptor_reader.h"

namespace hapticd::hid {

/// The descriptor of a device without and with the affine command.
inline constexpr std::array<std::uint8_t, 55> kPlainDescriptor{
    0x06, 0x48, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,
    0x85, 0x01, 0x09, 0x01, 0x95, 0x3F, 0x81, 0x02, 0x85, 0x02, 0x09, 0x02, 0x95, 0x1F,
    0x91, 0x02, 0x85, 0x10, 0x09, 0x10, 0x95, 0x3F, 0xB1, 0x02, 0x85, 0x11, 0x09, 0x11,
    0x95, 0x0F, 0xB1, 0x02, 0x85, 0x12, 0x09, 0x12, 0x95, 0x07, 0xB1, 0x02, 0xC0};
inline constexpr std::array<std::uint8_t, 63> kAffineDescriptor{
    0x06, 0x48, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08, 0x85, 0x01,
    0x09, 0x01, 0x95, 0x3F, 0x81, 0x02, 0x85, 0x02, 0x09, 0x02, 0x95, 0x1F, 0x91, 0x02, 0x85, 0x03,
    0x09, 0x03, 0x95, 0x3F, 0x91, 0x02, 0x85, 0x10, 0x09, 0x10, 0x95, 0x3F, 0xB1, 0x02, 0x85, 0x11,
    0x09, 0x11, 0x95, 0x0F, 0xB1, 0x02, 0x85, 0x12, 0x09, 0x12, 0x95, 0x07, 0xB1, 0x02, 0xC0};

/// One report of a descriptor.
struct ReportSize {
  ReportKind kind = ReportKind::kInput;
  std::uint8_t id = 0;     ///< 0: the descriptor uses no IDs
  std::uint64_t bits = 0;  ///< without the ID
};

/// Bytes of a report on the wire, its ID included.
[[nodiscard]] std::uint64_t bytes_of(const ReportSize& report) noexcept;

/// What a descriptor says.
struct DescriptorFacts {
  DescriptorFlaw flaw = DescriptorFlaw::kNone;
  bool is_haptic = false;  ///< has a top-level application collection FF48:0001
  FixedVector<ReportSize, kMaxReports> reports;  ///< of all collections, in order of appearance
};

/// Reads a descriptor; with a flaw, nothing else is returned. O(bytes).
[[nodiscard]] DescriptorFacts read_descriptor(std::span<const std::uint8_t> descriptor) noexcept;

/// A descriptor without flaw that has the collection of profile v1 and its reports in their exact
/// sizes; `affine`, if not null, says whether report 0x03 is among them. Other reports and
/// collections do not matter.
[[nodiscard]] bool is_profile_v1(const DescriptorFacts& facts, bool* affine = nullptr) noexcept;

}  // namespace hapticd::hid
