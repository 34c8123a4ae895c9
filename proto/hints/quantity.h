// Numbers with units, as people write them: 45N, 250 um, 190GPa, 1.2 N/mm, 30deg. Not RT.
#pragma once

#include <string>
#include <string_view>

namespace hapticd::hints {

/// What a text says.
struct Quantity {
  double value = 0.0;  ///< finite; in the unit that was asked for
  std::string fault;   ///< a sentence that says what is right instead; empty: there is a value
};

/// Reads `text`: a number, in `unit` where no unit follows it. Units are products and quotients of
/// m, s, N, Pa, Hz, g, rad and deg, such as "N s/m", with n, u, m, c, k, M or G before each. A
/// `unit` of another kind ("", "count") allows a number alone. What only shifts the decimal point
/// is exact: 250um is the double nearest to 250e-6.
[[nodiscard]] Quantity parse_quantity(std::string_view text, std::string_view unit);

}  // namespace hapticd::hints
