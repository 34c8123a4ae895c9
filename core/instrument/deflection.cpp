// Eq. 10-12 without cancellation, and their series with a spring. See deflection.h. Every
// difference of nearly equal numbers is written as a quotient, and every quotient so that it is
// finite where one half of the string has no length. RT: yes.
#include "core/instrument/deflection.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Deflections whose square is neither lost nor too large, m. Normal values 1e-140 and 1e140;
/// outside of them lengths take a slower way.
constexpr double kMinSquared = 1e-140;
constexpr double kMaxSquared = 1e140;

/// Displacements and distances to an end below this count as 0 in the series law, m. Normal value
/// 1e-80; far smaller would let its starting point leave the range of a double.
constexpr double kMinDisplacement = 1e-80;

/// The series law is solved when its two sides differ by less than this share of kc D, 1. Normal
/// value 1e-15, a few roundings; smaller chases them, larger loses digits.
constexpr double kBalanced = 1e-15;

/// And when a step is smaller than this share of delta: the error it leaves is about its square,
/// 1. Normal value 1e-8; larger loses digits, smaller costs a step.
constexpr double kLastStep = 1e-8;

/// A Newton step that leaves more than this share of the imbalance is too slow, and the next one
/// halves the bracket, 1. Normal value 0.25: a cube far from its root leaves 0.3.
constexpr double kSlow = 0.25;

/// Brackets wider than this ratio are halved in the logarithm, 1. Normal value 4; any value works.
constexpr double kWide = 4.0;

/// Most steps of the series law. Normal: 2 or 3, next to an end 5; 3e6 random extremes took 20 at
/// most. Fewer would stop short there.
constexpr int kMaxSteps = 32;

/// Hypotenuse of two lengths >= 0, of which `delta` is not 0.
double hypotenuse(double run, double delta) noexcept {
  if (delta >= kMinSquared && delta <= kMaxSquared) [[likely]] {
    return std::sqrt(run * run + delta * delta);
  }
  const double large = run > delta ? run : delta;
  const double small = run > delta ? delta : run;
  const double ratio = small / large;
  return large * std::sqrt(1.0 + ratio * ratio);
}

/// The triangle A-P-B of a string of some length, deflected by delta > 0.
struct Triangle {
  Triangle(const StringConstants& of, double at, double by) noexcept
      : string(of),
        lambda(at),
        delta(by),
        run_1(lambda * string.length),
        run_2((1.0 - lambda) * string.length),
        length_1(hypotenuse(run_1, delta)),
        length_2(hypotenuse(run_2, delta)),
        sine_1(delta / length_1),
        sine_2(delta / length_2),
        stretch(delta * (delta / (length_1 + run_1) + delta / (length_2 + run_2))),
        axial_force(string.axial_stiffness * (stretch / string.length)),
        tension(string.tension + axial_force) {}

  [[nodiscard]] double cosine_1() const noexcept { return run_1 / length_1; }
  [[nodiscard]] double cosine_2() const noexcept { return run_2 / length_2; }
  [[nodiscard]] double force() const noexcept { return tension * (sine_1 + sine_2); }
  /// dF/ddelta: the growing F_i, and the sines' d(delta/L_i)/ddelta = cos^2 / L_i.
  [[nodiscard]] double slope() const noexcept {
    const double sines = sine_1 + sine_2;
    const double elastic = string.axial_stiffness / string.length * (sines * sines);
    return elastic + (tension * (cosine_1() * cosine_1()) / length_1 +
                      tension * (cosine_2() * cosine_2()) / length_2);
  }
  /// tension (cos theta_2 - cos theta_1) with the difference of the cosines from that of their
  /// squares, (delta L / (L_1 L_2))^2 (1 - 2 lambda).
  [[nodiscard]] double lateral_force() const noexcept {
    const bool first_is_short = length_1 < length_2;
    const double shorter = first_is_short ? length_1 : length_2;
    const double longer = first_is_short ? length_2 : length_1;
    const double ratio = (delta / shorter) * (string.length / longer);
    return tension * (ratio * ratio * (1.0 - 2.0 * lambda) / (cosine_1() + cosine_2()));
  }

  const StringConstants& string;
  double lambda;
  double delta;
  double run_1;        ///< lambda L
  double run_2;        ///< (1 - lambda) L
  double length_1;     ///< |AP| = L_1
  double length_2;     ///< |PB| = L_2
  double sine_1;       ///< delta / L_1
  double sine_2;       ///< delta / L_2
  double stretch;      ///< ext = L_1 + L_2 - L
  double axial_force;  ///< F_i
  double tension;      ///< T + F_i
};

struct ForceAndSlope {
  double force;
  double slope;
};

/// F and dF/ddelta alone, as deflect() gives them.
ForceAndSlope force_and_slope(const StringConstants& string, double lambda, double delta) noexcept {
  const Triangle bent(string, lambda, delta);
  return {bent.force(), bent.slope()};
}

/// Cube root of a positive normal number within 6 %: a third of the exponent, and of the mantissa
/// with it.
double rough_cube_root(double value) noexcept {
  constexpr std::uint64_t kTwoThirdsOfBias = 0x2a9f7893782da1ceU;
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) / 3U + kTwoThirdsOfBias);
}

/// Where F(delta) + kc delta = load is looked for: lower <= root <= upper, lower <= start <= upper.
struct Bracket {
  double lower;
  double start;
  double upper;
};

/// Bounds of the root, 0 < load = kc D. From above: kc delta <= load, and T delta / L_i <= load.
/// From below: k delta + c delta^3 is more than the left side (tangents of sines and stretch at 0;
/// exact for small delta, so its root is the start), and so is T + (kc + T/L' + 4 EA/L) delta, L'
/// the longer run (one sine and all other growth at their largest).
Bracket bracket_series(const StringConstants& string, double lambda, double displacement,
                       double stiffness) noexcept {
  const double run_1 = lambda * string.length;
  const double run_2 = (1.0 - lambda) * string.length;
  const double shorter = run_1 < run_2 ? run_1 : run_2;
  const double longer = run_1 < run_2 ? run_2 : run_1;
  const double load = stiffness * displacement;
  const double elastic = string.axial_stiffness / string.length;

  Bracket bracket{0.0, 0.0, displacement};
  if (load > string.tension) {
    const double steepest = stiffness + string.tension / longer + 4.0 * elastic;
    bracket.lower = (load - string.tension) / steepest;
  } else if (load < string.tension) {
    const double cosine_side =
        std::sqrt((string.tension - load) * (string.tension + load));  // T cos theta >= this
    const double reach = shorter * (load / cosine_side);
    bracket.upper = reach < displacement ? reach : displacement;
  }
  bracket.start = bracket.lower;
  if (shorter > 0.0) {
    const double steepness = 1.0 / shorter + 1.0 / longer;
    const double linear = stiffness + string.tension * steepness;
    const double cubic = 0.5 * elastic * (steepness * steepness);
    double root = load / linear;
    if (cubic * (root * root) > linear) {
      const double of_cube = rough_cube_root(load / cubic);
      root = of_cube < root ? of_cube : root;
    }
    if (0.5 * root > bracket.lower) bracket.lower = 0.5 * root;
    // Two Newton steps on the cubic, from above its root or next to it.
    for (int i = 0; i < 2; ++i) {
      const double square = cubic * (root * root);
      root = (load + 2.0 * square * root) / (linear + 3.0 * square);
    }
    if (root > bracket.start) bracket.start = root;
  }
  if (bracket.start > bracket.upper) bracket.start = bracket.upper;
  return bracket;
}

/// lambda, or the end it is closer to than kMinDisplacement.
double place_of(const StringConstants& string, double lambda) noexcept {
  if (lambda * string.length < kMinDisplacement) return 0.0;
  if ((1.0 - lambda) * string.length < kMinDisplacement) return 1.0;
  return lambda;
}

/// Share of the fundamental in the squared slopes of a string drawn aside at lambda. The tension
/// they make is at its most where the fundamental turns back, which counts that share one and a
/// half times (Kirchhoff's string, averaged over a swing).
double fundamental_share(double lambda) noexcept {
  const double shorter = lambda < 0.5 ? lambda : 1.0 - lambda;
  if (!(shorter > 0.0)) return 0.0;
  const double ratio = mode_shape(1, shorter) / kPi;
  return 2.0 * ratio * (ratio / (shorter * (1.0 - shorter)));
}

/// A point between both ends.
double middle(double lower, double upper) noexcept {
  return upper > kWide * lower ? std::sqrt(lower * upper) : 0.5 * (lower + upper);
}

}  // namespace

Deflection deflect(const StringConstants& string, double lambda, double delta) noexcept {
  if (string.length <= 0.0) return {};
  if (!(delta > 0.0)) {
    const double stiffness = small_deflection_stiffness(string, lambda);
    return {0.0, stiffness, stiffness, 0.0, 0.0, 0.0};
  }
  const Triangle bent(string, lambda, delta);
  Deflection result;
  result.force = bent.force();
  result.slope = bent.slope();
  result.secant = bent.tension / bent.length_1 + bent.tension / bent.length_2;
  result.energy = (string.tension + 0.5 * bent.axial_force) * bent.stretch;
  result.axial_force = bent.axial_force;
  result.lateral_force = bent.lateral_force();
  return result;
}

double deflection_force(const StringConstants& string, double lambda, double delta) noexcept {
  if (string.length <= 0.0 || !(delta > 0.0)) return 0.0;
  return Triangle(string, lambda, delta).force();
}

double small_deflection_stiffness(const StringConstants& string, double lambda) noexcept {
  if (string.length <= 0.0 || string.tension <= 0.0) return 0.0;
  return string.tension / (string.length * (lambda * (1.0 - lambda)));
}

SeriesDeflection deflect_in_series(const StringConstants& string, double lambda,
                                   double displacement, double stiffness) noexcept {
  if (!(displacement >= kMinDisplacement)) return {0.0, 0.0};
  const double load = stiffness * displacement;
  if (string.length <= 0.0) return {0.0, load};
  const double place = place_of(string, lambda);
  if ((place == 0.0 || place == 1.0) && load <= string.tension) return {0.0, load};

  // Newton's method. A step out of the bracket, or one after a slow one, halves the bracket
  // instead.
  Bracket bracket = bracket_series(string, place, displacement, stiffness);
  double delta = bracket.start;
  double slow_above = load;
  for (int i = 0;; ++i) {
    const ForceAndSlope at = force_and_slope(string, place, delta);
    const double imbalance = load - (stiffness * delta + at.force);
    const double step = imbalance / (stiffness + at.slope);
    const double size = std::fabs(imbalance);
    if (size <= kBalanced * load || std::fabs(step) <= kLastStep * delta || i == kMaxSteps) {
      // Along the tangent to the end of the step: steep or soft, the string's law keeps its digits.
      double end = delta + step;
      end = end > 0.0 ? end : 0.0;
      const double force = at.force + at.slope * step;
      return {end < displacement ? end : displacement, force < load ? force : load};
    }
    (imbalance > 0.0 ? bracket.lower : bracket.upper) = delta;
    const double next = delta + step;
    const bool outside = !(next > bracket.lower && next < bracket.upper);
    if (outside || size > slow_above) {
      delta = middle(bracket.lower, bracket.upper);
      slow_above = load;
    } else {
      delta = next;
      slow_above = kSlow * size;
    }
  }
}

double pitch_factor(const StringConstants& string, double lambda, double delta) noexcept {
  if (string.length <= 0.0 || string.tension <= 0.0 || !(delta > 0.0)) return 1.0;
  const Triangle bent(string, lambda, delta);
  const double weight = 0.5 + 0.25 * fundamental_share(lambda);
  return std::sqrt(1.0 + weight * (bent.axial_force / string.tension));
}

}  // namespace hapticd
