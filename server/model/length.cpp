// See length.h.
#include "server/model/length.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "proto/hints/quantity.h"

namespace hapticd {
namespace {

struct Unit {
  std::string_view name;
  double metres;
};

constexpr std::array<Unit, 5> kUnits{
    {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}}};

}  // namespace

double unit_in_metres(std::string_view unit) {
  for (const Unit& known : kUnits) {
    if (known.name == unit) return known.metres;
  }
  throw std::invalid_argument("'" + std::string(unit) +
                              "' is not a unit of length: um, mm, cm, m, in");
}

double parse_length(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) {
    throw std::invalid_argument("'" + std::string(text) +
                                "' is not a length: write 250um or 0.25mm");
  }
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (unit.starts_with(',')) {
    throw std::invalid_argument("'" + std::string(text) + "' has a comma. " +
                                hints::parse_quantity(text, "m").fault);
  }
  return unit.empty() ? value : value * unit_in_metres(unit);
}

std::string format_length(double length) {
  const double size = std::fabs(length);
  const char* unit = "um";
  double scale = 1e6;
  if (size >= 0.9995) {
    unit = "m";
    scale = 1.0;
  } else if (size >= 0.9995e-3) {
    unit = "mm";
    scale = 1e3;
  }
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.3g %s", length * scale, unit);
  return text.data();
}

}  // namespace hapticd
