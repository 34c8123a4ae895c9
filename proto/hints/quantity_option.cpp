// See quantity_option.h.
#include "proto/hints/quantity_option.h"

#include <array>
#include <charconv>
#include <string>
#include <string_view>

#include "proto/hints/quantity.h"

namespace hapticd::hints {
namespace {

/// Puts the number in `unit` in the place of `text`. Returns what is wrong; empty: nothing.
std::string read_in_place(std::string& text, std::string_view unit) {
  std::string_view given = text;
  // Decibels are no unit that others of its kind are made of.
  const bool decibels = unit == "dB";
  if (decibels && given.ends_with(unit)) given.remove_suffix(unit.size());
  const Quantity quantity = parse_quantity(given, unit);
  if (!quantity.fault.empty()) {
    // Of a decimal comma the fault says all.
    if (text.find(',') != std::string::npos) return quantity.fault;
    return text + " cannot be read. " +
           (decibels ? std::string("Give a number, in dB.") : quantity.fault);
  }
  std::array<char, 32> shortest{};
  const auto end =
      std::to_chars(shortest.data(), shortest.data() + shortest.size(), quantity.value).ptr;
  text.assign(shortest.data(), end);
  return {};
}

}  // namespace

CLI::Option* takes_unit(CLI::Option* option, const char* unit) {
  const std::string in = unit;
  return option->transform(
      CLI::Validator([in](std::string& text) { return read_in_place(text, in); }, ""));
}

}  // namespace hapticd::hints
