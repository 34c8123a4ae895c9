// What the comments of scene.proto, gesture.proto and device_profile.proto promise of each field:
// unit, shape, range, whether it is live. Made from the .proto files during the build
// (make_field_table.py), so that what is checked is what is written there. Offline.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace hapticd::wire {

struct FieldRow {
  std::string_view field;      ///< "Message.field"
  std::string_view unit;       ///< "m", "text"; empty for messages and enums
  std::string_view shape;      ///< of repeated numbers: "3: x y z"; else empty
  std::string_view range;      ///< "[0, 1]" of numbers; "1..64" of the length of texts and lists
  bool live = false;           ///< may change while the loop runs
  bool may_be_absent = false;  ///< a list may be empty, a text not given
};

/// All fields of Scene and what is in it.
[[nodiscard]] std::span<const FieldRow> field_table() noexcept;

/// The row of "Message.field", of a scene, a gesture or a device profile; null when there is none.
[[nodiscard]] const FieldRow* find_row(std::string_view field) noexcept;

/// An interval as the comments write it.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  bool low_open = false;
  bool high_open = false;

  /// False for NaN.
  [[nodiscard]] bool contains(double value) const noexcept {
    return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
  }
};

/// "[0, 1)" or "1..64", with words behind it or not; nothing for other texts.
[[nodiscard]] std::optional<Interval> parse_interval(std::string_view range) noexcept;

}  // namespace hapticd::wire
