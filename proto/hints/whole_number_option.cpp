// See whole_number_option.h.
#include "proto/hints/whole_number_option.h"

#include <charconv>
#include <string>
#include <string_view>
#include <system_error>

namespace hapticd::hints {
namespace {

/// What takes_whole_number() was told.
struct Bounds {
  std::uint64_t lowest;
  std::uint64_t highest;
};

/// Puts the number in the place of `text`, without noughts before it. Returns what is wrong; empty:
/// nothing.
std::string read_in_place(std::string& text, const Bounds& bounds) {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  std::uint64_t number = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool whole = error == std::errc() && stop == digits.data() + digits.size();
  if (!whole || number < bounds.lowest || number > bounds.highest) {
    return "'" + text + "' is not a whole number from " + std::to_string(bounds.lowest) + " to " +
           std::to_string(bounds.highest) + ".";
  }
  text = std::to_string(number);
  return {};
}

}  // namespace

CLI::Option* takes_whole_number(CLI::Option* option, std::uint64_t lowest, std::uint64_t highest) {
  const Bounds bounds{lowest, highest};
  return option->transform(
      CLI::Validator([bounds](std::string& text) { return read_in_place(text, bounds); }, ""));
}

}  // namespace hapticd::hints
