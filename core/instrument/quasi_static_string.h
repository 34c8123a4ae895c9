// The string of the paper: under a finger it is bent as in static equilibrium, once let go it rings
// with its fundamental, and a scene says how far up that ladder a string may climb
// (StringDetail) and whether a contact moves it (StringContact). The ladder asleep - touched -
// ringing - ringing under a finger, with vibration force, release detector and events. Frames:
// scalars along the touch normal. Source: Eq. 8-13 of the paper; the departures are named where
// they are.
//
// Energy: a release leaves what rings with E0, by the largest deflection of the touch; a second one
// leaves the larger of the two, never their sum. It decays by T_d, faster under a finger; every
// change of level keeps it. A release fills the tank with what it takes to bend the string as far,
// releases within 100 ms by their share of that: so no hand, not even one that plucks the string
// anew in every swing, draws more than E0 at once and E0 per 100 ms. RT: yes; 30 ns while it rings,
// 70 ns while touched, 130 ns both.
#pragma once

#include <algorithm>

#include "core/instrument/deflection.h"
#include "core/instrument/string_response.h"

namespace hapticd {

/// One of the models of string_model.h. Views the constants it is made from.
class QuasiStaticString {
 public:
  explicit QuasiStaticString(const StringConstants& string) noexcept : string_(string) {}

  /// True where a contact moves it: it has unknowns of the contact problem.
  [[nodiscard]] bool yields() const noexcept { return string_.model == StringContact::kYielding; }
  /// True where pressing it bends it.
  [[nodiscard]] bool bends() const noexcept { return string_.max_level >= StringDetail::kStatic; }
  /// True where it may ring once it is let go.
  [[nodiscard]] bool rings() const noexcept {
    return string_.max_level >= StringDetail::kFundamental && string_.frequency > 0.0;
  }

  /// Its law at a deflection, as deflect().
  [[nodiscard]] Deflection law(double lambda, double deflection) const noexcept {
    return deflect(string_, lambda, deflection);
  }
  /// The law in series with a spring, as deflect_in_series().
  [[nodiscard]] SeriesDeflection law_in_series(double lambda, double displacement,
                                               double stiffness) const noexcept {
    return deflect_in_series(string_, lambda, displacement, stiffness);
  }
  /// False where the law is certainly never stiffer than `stiffness` (N/m, > 0): it may be next to
  /// an end, and where the string is short.
  [[nodiscard]] bool may_exceed(double stiffness, double lambda) const noexcept {
    const double run = std::min(lambda, 1.0 - lambda) * string_.length;
    return string_.tension > stiffness * run ||
           4.0 * string_.axial_stiffness > stiffness * string_.length;
  }

  /// As envelope() of string_model.h.
  [[nodiscard]] HD_REALTIME double reach(const StringState& state, double lambda,
                                         std::int64_t t_ns) const noexcept;
  /// As respond() of string_model.h.
  [[nodiscard]] HD_REALTIME StringResponse advance(const SoundingString& sounding,
                                                   const StringTouch& touch,
                                                   StringEvents& events) const noexcept;

 private:
  const StringConstants& string_;
};

}  // namespace hapticd
