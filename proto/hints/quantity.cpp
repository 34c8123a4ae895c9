// See quantity.h.
#include "proto/hints/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace hapticd::hints {
namespace {

constexpr std::array<std::string_view, 8> kSymbols{"m", "s", "N", "Pa", "Hz", "g", "rad", "deg"};

/// Decimal exponents of what stands before a symbol.
struct Prefix {
  std::string_view text;
  int exponent;
};
constexpr std::array<Prefix, 9> kPrefixes{{{"n", -9},
                                           {"u", -6},
                                           {"\u00b5", -6},
                                           {"\u03bc", -6},
                                           {"m", -3},
                                           {"c", -2},
                                           {"k", 3},
                                           {"M", 6},
                                           {"G", 9}}};
/// Beyond it every number but 0 is too large or too small.
constexpr int kMaxExponent = 10'000;

/// A unit taken apart.
struct Unit {
  std::vector<std::string_view> above;  ///< symbols, without what stands before them
  std::vector<std::string_view> below;
  int exponent = 0;     ///< of ten
  double factor = 1.0;  ///< beside it: of degrees
};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Adds one symbol, above (+1) or below (-1) the line; false: it is not known.
bool add_symbol(std::string_view text, int sign, Unit& unit) {
  int exponent = 0;
  const auto known = [](std::string_view name) {
    return std::find(kSymbols.begin(), kSymbols.end(), name) != kSymbols.end();
  };
  if (!known(text)) {
    const auto* const prefix =
        std::find_if(kPrefixes.begin(), kPrefixes.end(), [&](const Prefix& p) {
          return text.starts_with(p.text) && known(text.substr(p.text.size()));
        });
    if (prefix == kPrefixes.end()) return false;
    exponent = prefix->exponent;
    text.remove_prefix(prefix->text.size());
  }
  if (text == "deg") {
    unit.factor *= std::pow(std::numbers::pi / 180.0, sign);
    text = "rad";
  }
  unit.exponent += sign * exponent;
  (sign > 0 ? unit.above : unit.below).push_back(text);
  return true;
}

/// "N s/m": what is divided by stands behind the one '/'.
std::optional<Unit> parse_unit(std::string_view text) {
  Unit unit;
  int sign = 1;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const std::size_t end = std::min(text.find_first_of(" /"), text.size());
    if (end == 0) {
      if (text.front() != '/' || sign < 0) return std::nullopt;
      sign = -1;
      text.remove_prefix(1);
      continue;
    }
    if (!add_symbol(text.substr(0, end), sign, unit)) return std::nullopt;
    text.remove_prefix(end);
  }
  std::sort(unit.above.begin(), unit.above.end());
  std::sort(unit.below.begin(), unit.below.end());
  if (unit.above.empty() || (sign < 0 && unit.below.empty())) return std::nullopt;
  return unit;
}

/// The text up to where a number ends; empty: there is none.
std::string_view number_of(std::string_view text) {
  double ignored = 0.0;
  const char* const begin = text.data();
  const auto [end, error] = std::from_chars(begin, begin + text.size(), ignored);
  const bool finite = error == std::errc() && std::isfinite(ignored);
  return text.substr(0, finite ? static_cast<std::size_t>(end - begin) : 0);
}

/// `number` times a power of ten, rounded once; NaN: it is too large or too small.
double shifted(std::string_view number, int exponent) {
  const std::size_t e = number.find_first_of("eE");
  int own = 0;
  if (e != std::string_view::npos) {
    const std::string_view digits = number.substr(e + (number.substr(e + 1, 1) == "+" ? 2 : 1));
    std::from_chars(digits.data(), digits.data() + digits.size(), own);
    own = std::clamp(own, -kMaxExponent, kMaxExponent);
  }
  const std::string text = std::string(number.substr(0, e)) + "e" + std::to_string(own + exponent);
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() ? value : std::numeric_limits<double>::quiet_NaN();
}

Quantity refused(const std::string& fault) { return {0.0, fault}; }

/// A text without spaces around it.
Quantity read(std::string_view text, std::string_view unit) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const std::string_view number = number_of(text);
  if (number.empty()) return refused("Give a number.");
  const std::string_view given = trimmed(text.substr(number.size()));
  if (given.empty()) return {shifted(number, 0), ""};
  const std::optional<Unit> wanted = parse_unit(unit);
  if (!wanted) return refused("Give a number alone; it has no unit.");
  const std::optional<Unit> found = parse_unit(given);
  if (!found || found->above != wanted->above || found->below != wanted->below) {
    return refused("Give it in " + std::string(unit) + ".");
  }
  const double value =
      shifted(number, found->exponent - wanted->exponent) * (found->factor / wanted->factor);
  return std::isfinite(value) ? Quantity{value, ""} : refused("Give a number.");
}

}  // namespace

Quantity parse_quantity(std::string_view text, std::string_view unit) {
  text = trimmed(text);
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return read(text, unit);
  std::string pointed(text);
  pointed[comma] = '.';
  // Three digits may be thousands, but for those after a nought: what is meant is not known.
  const std::size_t end = std::min(text.find_first_not_of("0123456789", comma + 1), text.size());
  const std::string_view whole = text.substr(0, comma);
  const bool may_be_thousands = end - comma == 4 && whole != "0" && !whole.ends_with("-0");
  const bool right = !may_be_thousands && read(pointed, unit).fault.empty();
  return refused(right ? "Write " + pointed + ", with a point." : "Give a number without commas.");
}

}  // namespace hapticd::hints
