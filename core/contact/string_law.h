// The law of a touched string: what it does to the hand for how far it is bent or pressed. Strings
// that do not yield get their force here (Eq. 10-13): with F the net contact force of the string,
// the hand has pressed D = |F| / kt into it, the string counts as deflected by delta = D / k_s, and
// |F_r| = F(delta), no more than kc D. Deviation: the bound by kc; without it the ends are stiffer
// than any loop can render. SI. RT: yes, about 0.1 us per string.
#pragma once

#include <cstdint>

#include "core/contact/contact_input.h"
#include "core/instrument/string_model.h"

namespace hapticd {

/// Stiffnesses of a string in the program stay within these shares of kt: a slack string keeps the
/// program solvable, one touched at its end is as good as rigid.
inline constexpr double kMinStringStiffness = 1e-6;
inline constexpr double kMaxStringStiffness = 1e5;

/// The string law at deflection |u| = `deflection`, in series with what kt is stiffer than kc, and
/// next to an end with kMaxStringStiffness kt.
[[nodiscard]] HD_REALTIME Deflection string_law(const ContactInput& input, const StringBend& bend,
                                                double deflection) noexcept;

/// What the program's contacts press on a string together.
struct StringPress {
  std::int32_t string;  ///< its number
  double lambda;        ///< where, along the string
  Vector3 F_W;          ///< net force on the tool, N
};

/// What a string gives the hand for that.
struct StringLoad {
  double force;         ///< |F_r|, N
  double deflection;    ///< delta, m
  double displacement;  ///< D, m
  /// Along the axis, of one that does not yield, N: with `force` the gradient of one energy of D
  /// and the place. 0 unless asked for.
  double lateral;
};

/// The law of a string that is pressed, and bent as `touched` says (null: not touched). A string
/// that yields has its law in the program; it gives no more than kc D either.
[[nodiscard]] HD_REALTIME StringLoad string_load(const ContactInput& input,
                                                 const TouchedString* touched,
                                                 const StringPress& press) noexcept;

}  // namespace hapticd
