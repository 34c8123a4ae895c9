// Lengths as people write them: 250um, 0.5mm, 1e-3m. Not RT.
#pragma once

#include <string>
#include <string_view>

namespace hapticd {

/// Metres. A number followed by um, mm, cm, m or in, with no unit: metres; a finite number, also
/// below 0. Throws std::invalid_argument with the text and what would be right.
[[nodiscard]] double parse_length(std::string_view text);

/// Metres in one of the units of parse_length. Throws std::invalid_argument naming those there are.
[[nodiscard]] double unit_in_metres(std::string_view unit);

/// `length` (m) in the unit that reads best, three digits: "250 um", "1.22 m".
[[nodiscard]] std::string format_length(double length);

}  // namespace hapticd
