// See string_law.h. RT: yes.
#include "core/contact/string_law.h"

#include <algorithm>
#include <cmath>

#include "core/contact/coupling_axes.h"

namespace hapticd {
namespace {

/// Root of the stiffness of the coupling along F, k, over kt: 1 where all axes are alike. What a
/// rigid string stores is a function of sqrt(2 U / kt) = |F| / sqrt(k kt), the depth that would
/// store U at kt; it goes with the hand by -F / |F| times this, so that the force is a gradient.
double root_share(const CouplingStiffness& stiffness, double pressed, double depth) noexcept {
  return stiffness.per_axis ? std::sqrt(pressed / (stiffness.kt * depth)) : 1.0;
}

/// Of a string's model in series with `compliance` (m/N).
template <IsStringModel Model>
Deflection law_in_series(const Model& model, const StringBend& bend, double deflection,
                         double compliance) noexcept {
  if (!(compliance > 0.0)) return model.law(bend.lambda, deflection);
  const SeriesDeflection series = model.law_in_series(bend.lambda, deflection, 1.0 / compliance);
  Deflection law = model.law(bend.lambda, series.delta);
  law.energy += 0.5 * compliance * series.force * series.force;
  law.force = series.force;
  law.slope = 1.0 / (1.0 / law.slope + compliance);
  law.secant = deflection > 0.0 ? series.force / deflection : law.slope;
  return law;
}

/// Halvings of a bracket of deflections: below the rounding of what is looked for.
constexpr int kHalvings = 50;

/// Where in (0, `deflection`) a string's secant comes to `stiffness`, m; it is on different sides
/// of it at the two ends.
template <IsStringModel Model>
double crossing(const Model& model, double lambda, double deflection, double stiffness) noexcept {
  double low = 0.0;
  double high = deflection;
  const bool rises = model.law(lambda, high).secant > stiffness;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    ((model.law(lambda, middle).secant > stiffness) == rises ? high : low) = middle;
  }
  return high;
}

/// Axial force of a string that does not yield and gives min(F(delta), kc D), D = k_s delta: by
/// that force over D it stores, and this is what that changes along the string, as far as it is the
/// string's and not kc's.
template <IsStringModel Model>
double rigid_lateral(const Model& model, const StringConstants& string, double kc, double lambda,
                     double deflection) noexcept {
  const double stiffest = kc * string.k_s;
  const bool bounded_at_first = model.law(lambda, 0.0).secant > stiffest;
  const bool bounded = model.law(lambda, deflection).secant > stiffest;
  double at = deflection;
  if (bounded == bounded_at_first) {
    if (bounded) return 0.0;
    return string.k_s * model.law(lambda, at).lateral_force;
  }
  at = crossing(model, lambda, deflection, stiffest);
  const double there = model.law(lambda, at).lateral_force;
  if (bounded) return string.k_s * there;
  return string.k_s * (model.law(lambda, deflection).lateral_force - there);
}

}  // namespace

Deflection string_law(const ContactInput& input, const StringBend& bend,
                      double deflection) noexcept {
  const StringConstants& string = input.strings[static_cast<std::size_t>(bend.capsule)];
  const double kt = input.stiffness.kt;
  return ask_model(string, [&](const auto& model) {
    double compliance = std::max(0.0, 1.0 / string.contact_stiffness - 1.0 / kt);
    // What is stiffer than the program and its rounding bear.
    const double greatest = kMaxStringStiffness * kt;
    if (model.may_exceed(greatest, bend.lambda)) compliance += 1.0 / greatest;
    return law_in_series(model, bend, deflection, compliance);
  });
}

StringLoad string_load(const ContactInput& input, const TouchedString* touched,
                       const StringPress& press) noexcept {
  const StringConstants& string = input.strings[static_cast<std::size_t>(press.string)];
  const double kt = input.stiffness.kt;
  const double kc = std::min(string.contact_stiffness, kt);
  const double pressed = press.F_W.norm();
  StringLoad load{pressed, 0.0, pressed / kt, 0.0};
  if (!(pressed > 0.0)) return load;
  const double hand = depth_under(input.stiffness, pressed, press.F_W / pressed);
  const bool yields = touched != nullptr && touched->yields;
  const bool on_end = press.lambda <= 0.0 || press.lambda >= 1.0;
  if (yields || (on_end && hapticd::yields(string))) {
    // Next to an end, which does not yield, the program's contact is as stiff as kt.
    if (yields) {
      const Vector3& u_W = touched->u_felt_W;
      load.deflection = u_W.norm();
      // Along the normal: a string that slips aside is not pressed.
      load.displacement += deflection_share(touched->bend, press.lambda) *
                           std::max(0.0, -u_W.dot(press.F_W) / pressed);
    }
    load.force = std::min(pressed, kc * load.displacement);
    load.displacement += hand - pressed / kt;
    return load;
  }
  load.displacement = hand;
  if (!bends(string) || !(string.length > 0.0)) return load;
  const double share = root_share(input.stiffness, pressed, hand);
  const double depth = share * hand;
  load.deflection = depth / string.k_s;
  load.force = ask_model(string, [&](const auto& model) {
    if (input.instrument.lateral_force) {
      load.lateral = share * rigid_lateral(model, string, kc, press.lambda, load.deflection);
    }
    return share * std::min(model.law(press.lambda, load.deflection).force, kc * depth);
  });
  return load;
}

}  // namespace hapticd
