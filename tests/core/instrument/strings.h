// Strings for tests, and the geometry of a bent one in long double, written as it is defined. Not
// RT.
#pragma once

#include <cmath>

#include "core/instrument/string_parameters.h"

namespace hapticd::test {

/// A string along x of the given length, tension, Young's modulus and radius, tuned to 110 Hz.
inline StringParameters string_parameters(double length, double tension, double youngs_modulus,
                                          double radius) {
  StringParameters parameters;
  parameters.p_WB = {length, 0.0, 0.0};
  parameters.tension = tension;
  parameters.youngs_modulus = youngs_modulus;
  parameters.radius = radius;
  parameters.frequency = 110.0;
  return parameters;
}

inline StringConstants make_string(double length, double tension, double youngs_modulus,
                                   double radius) {
  return derive_string(string_parameters(length, tension, youngs_modulus, radius));
}

/// A string of a Guqin: 1.1 m of 0.34 mm steel at 30 N.
inline StringConstants guqin_string() { return make_string(1.1, 30.0, 1.9e11, 0.34e-3); }

/// |value - truth| / |truth|; 0 where both are 0.
inline long double relative_error(double value, long double truth) {
  const long double error = std::fabs(static_cast<long double>(value) - truth);
  return error == 0.0L ? 0.0L : error / std::fabs(truth);
}

/// The triangle A (0, 0), P (x, delta), B (length, 0) in long double.
class BentString {
 public:
  BentString(const StringConstants& string, double lambda, long double delta)
      : string_(string),
        delta_(delta),
        run_1_(static_cast<long double>(lambda) * static_cast<long double>(string.length)),
        run_2_(static_cast<long double>(string.length) - run_1_) {}

  [[nodiscard]] long double side_1() const { return std::hypot(run_1_, delta_); }
  [[nodiscard]] long double side_2() const { return std::hypot(run_2_, delta_); }
  [[nodiscard]] long double tension() const {
    const long double length = static_cast<long double>(string_.length);
    const long double stretch = side_1() + side_2() - length;
    return static_cast<long double>(string_.tension) +
           static_cast<long double>(string_.axial_stiffness) * stretch / length;
  }
  /// Components of what the string does to the finger at P: along AB, and back to the axis.
  [[nodiscard]] long double along() const {
    return tension() * (run_2_ / side_2() - run_1_ / side_1());
  }
  [[nodiscard]] long double back() const {
    return tension() * (delta_ / side_1() + delta_ / side_2());
  }

 private:
  StringConstants string_;
  long double delta_;
  long double run_1_;
  long double run_2_;
};

}  // namespace hapticd::test
