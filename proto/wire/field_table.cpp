// See field_table.h.
#include "proto/wire/field_table.h"

#include <array>
#include <charconv>

namespace hapticd::wire {
namespace {

constexpr std::array kTable{
#include "proto/wire/field_table.inc"
};

constexpr std::array kMotionTable{
#include "proto/wire/motion_table.inc"
};

/// Reads a number off the front of `text`.
bool take_number(std::string_view& text, double& number) noexcept {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  if (result.ec != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(result.ptr - text.data()));
  return true;
}

bool take(std::string_view& text, std::string_view what) noexcept {
  if (!text.starts_with(what)) return false;
  text.remove_prefix(what.size());
  return true;
}

/// "1..64"; from_chars would take the first dot for the number's.
std::optional<Interval> parse_count(std::string_view range) noexcept {
  const std::size_t dots = range.find("..");
  if (dots == std::string_view::npos) return std::nullopt;
  std::string_view low = range.substr(0, dots);
  std::string_view high = range.substr(dots + 2);
  Interval interval;
  if (!take_number(low, interval.low) || !low.empty() || !take_number(high, interval.high)) {
    return std::nullopt;
  }
  return interval;
}

}  // namespace

std::span<const FieldRow> field_table() noexcept { return kTable; }

const FieldRow* find_row(std::string_view field) noexcept {
  for (const FieldRow& row : kTable) {
    if (row.field == field) return &row;
  }
  for (const FieldRow& row : kMotionTable) {
    if (row.field == field) return &row;
  }
  return nullptr;
}

std::optional<Interval> parse_interval(std::string_view range) noexcept {
  Interval interval;
  interval.low_open = range.starts_with('(');
  if (!interval.low_open && !range.starts_with('[')) return parse_count(range);
  range.remove_prefix(1);
  if (!take_number(range, interval.low) || !take(range, ", ") ||
      !take_number(range, interval.high) || range.empty()) {
    return std::nullopt;
  }
  interval.high_open = range.front() == ')';
  return interval;
}

}  // namespace hapticd::wire
