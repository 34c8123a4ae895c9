// The value of a live parameter: a number, a truth value, a text or several numbers.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#pragma GCC visibility push(default)
namespace hapticd::client {
inline namespace abi_0 {

/// What a parameter is set to, or what it is. A text is the name of an enum's value, or a number
/// with or without its unit: "FIRM", "45 N", "250um". Seven numbers, p and q, are a pose.
struct Value {
  template <typename Number, std::enable_if_t<std::is_arithmetic_v<Number>, int> = 0>
  Value(Number number) {
    if constexpr (std::is_same_v<Number, bool>) {
      data = number;
    } else {
      data = static_cast<double>(number);
    }
  }
  Value(const char* text) : data(std::string(text)) {}
  Value(std::string text) : data(std::move(text)) {}
  Value(std::vector<double> numbers) : data(std::move(numbers)) {}

  /// The number; throws std::bad_variant_access where it is something else.
  [[nodiscard]] double number() const { return std::get<double>(data); }

  std::variant<double, bool, std::string, std::vector<double>> data;
};

}  // namespace abi_0
}  // namespace hapticd::client
#pragma GCC visibility pop
