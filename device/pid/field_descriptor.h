// HID report descriptors field by field: where each usage lies in which report (Device Class
// Definition for HID 1.11, section 6.2.2), for devices whose reports only their descriptor
// describes. Bytes come from a stranger's USB plug: every length is checked, everything is bounded.
// Bits count from the first byte of a report, its ID included. Allocates; not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "device/report_io/descriptor_reader.h"

namespace hapticd::pid {

/// Fields and collections of one descriptor; one with more is refused. Force devices have about 100
/// and 50.
inline constexpr std::size_t kMaxFields = 2048;
inline constexpr std::size_t kMaxCollections = 256;
/// Usages that one item names; more are without a name.
inline constexpr std::size_t kMaxUsages = 64;

/// One report.
struct ReportSize {
  ReportKind kind = ReportKind::kInput;
  std::uint8_t id = 0;   ///< 0: the descriptor uses no IDs
  std::size_t bits = 0;  ///< its ID included
};

/// A collection, and the one it is in.
struct Collection {
  std::uint32_t usage = 0;
  int parent = -1;              ///< -1: none
  bool is_application = false;  ///< a device of its own
};

/// One variable, or one element of an array, that is data.
struct Field {
  ReportKind kind = ReportKind::kInput;
  std::uint8_t report_id = 0;
  std::size_t bit = 0;                ///< where it begins
  std::size_t bits = 0;               ///< 1..32
  std::int64_t minimum = 0;           ///< logical
  std::int64_t maximum = 0;           ///< logical, >= minimum
  bool is_array = false;              ///< its value, less the minimum, is a place in `usages`
  bool is_relative = false;           ///< its value is a change
  std::vector<std::uint32_t> usages;  ///< of an array all; else one, or none
  int collection = -1;
};

/// What a descriptor says.
struct Descriptor {
  DescriptorFlaw flaw = DescriptorFlaw::kNone;
  std::vector<Field> fields;  ///< without constants, and without fields of more than 32 bits
  std::vector<Collection> collections;
  std::vector<ReportSize> reports;
};

/// Reads a descriptor; with a flaw, nothing else is returned. O(bytes), and the fields it has.
[[nodiscard]] Descriptor read_fields(std::span<const std::uint8_t> descriptor);

/// True when the collection, or one around it, has this usage.
[[nodiscard]] bool is_within(const Descriptor& descriptor, int collection, std::uint32_t usage);

/// The innermost application collection around, or the collection itself; -1: none.
[[nodiscard]] int application_of(const Descriptor& descriptor, int collection);

/// True when `outer` is the collection or around it.
[[nodiscard]] bool is_inside(const Descriptor& descriptor, int collection, int outer);

}  // namespace hapticd::pid
