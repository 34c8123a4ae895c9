// A string of a tick that is not asleep. Plain data. Frame: W. SI. RT: yes.
#pragma once

#include <cstdint>

#include "core/math/vector.h"

namespace hapticd {

/// Strings of a scene, at most.
inline constexpr int kMaxStrings = 1024;

/// Where on the ladder of models a string is.
enum class StringPhase : std::uint8_t {
  kAsleep,       ///< at rest; it costs nothing
  kStatic,       ///< bent by a finger
  kFundamental,  ///< the fundamental rings
  kModes,        ///< and further modes
};

/// One string after a tick.
struct StringTick {
  std::int32_t string = 0;  ///< number among the scene's capsules
  std::int32_t tool = 0;    ///< that plays it: all that follows is this tool's
  StringPhase phase = StringPhase::kAsleep;
  bool touched = false;
  bool armed = false;            ///< letting go plucks it
  double lambda = 0.5;           ///< of the touch, or of the release
  double radius_growth = 0.0;    ///< to draw beyond R: delta while touched, the envelope after, m
  Array3 deflection_W{};         ///< of its vertex, m
  double vibration_force = 0.0;  ///< F_v along the touch normal, N
  double energy = 0.0;           ///< of its vibration, J
};

/// Where a tool holds a string that it or another one bends, beyond kMinToldBend.
struct StringBendTick {
  std::int32_t string = 0;  ///< number among the scene's capsules
  std::int32_t tool = 0;    ///< that holds it
  double lambda = 0.5;      ///< along the string
  Array3 deflection_W{};    ///< from the straight string, m
};

/// Less counts as straight, m: nobody sees it.
inline constexpr double kMinToldBend = 1e-9;

}  // namespace hapticd
