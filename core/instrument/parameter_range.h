// The range of a parameter, and what is said about a value outside of it. RT: yes, a few ns.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

/// Why a parameter is refused, or doubted: the field's name in scene.proto, what it is, what it may
/// be.
struct ParameterFault {
  const char* field;   ///< such as "tension_n"
  double value;        ///< in the field's unit
  const char* range;   ///< such as "[0, 1e6]"
  const char* remedy;  ///< one sentence for people
};

/// An interval that includes its upper end.
struct ParameterRange {
  double low;
  double high;
  bool low_included;
  const char* text;  ///< as in scene.proto
};

/// True when `value` lies in `range`; NaN does not.
[[nodiscard]] HD_REALTIME constexpr bool contains(const ParameterRange& range,
                                                  double value) noexcept {
  const bool high_enough = range.low_included ? value >= range.low : value > range.low;
  return high_enough && value <= range.high;
}

}  // namespace hapticd
