// What a string keeps from tick to tick, what is needed to play it for one, and what that comes to;
// the model says how (string_model.h). One call per awake string and tick; a string asleep costs
// nothing. Frames: scalars along the touch normal. RT: yes, plain data.
#pragma once

#include "core/instrument/energy_tank.h"
#include "core/instrument/instrument_options.h"
#include "core/instrument/release_detector.h"
#include "core/instrument/string_parameters.h"
#include "core/instrument/string_touch.h"
#include "core/instrument/vibration.h"
#include "core/tick/string_event.h"
#include "core/tick/string_tick.h"

namespace hapticd {

/// State of one string from tick to tick.
struct StringState {
  StringPhase level = StringPhase::kAsleep;
  ReleaseDetector detector;
  Vibration vibration;  ///< of the fundamental
  EnergyTank tank;
  std::int64_t granted_ns = 0;  ///< when a release last filled the tank; 0: none has
};

/// A string with all it takes to sound.
struct SoundingString {
  std::int32_t index;  ///< its number, for its events
  const StringConstants& string;
  const InstrumentOptions& options;
  StringState& state;
};

/// What the string adds to the tick.
struct StringResponse {
  /// F_v along the touch normal on the tool, N; touch.force + vibration_force >= 0.
  double vibration_force = 0.0;
  /// Radius to draw beyond R, m: delta while touched, the envelope while it rings, the larger of
  /// both.
  double radius_growth = 0.0;
};

/// True while respond() has to be called although no tool is near: it rings, or is being watched
/// after a touch.
[[nodiscard]] HD_REALTIME bool awake(const StringState& state) noexcept;

/// Books what the force held so far has done over `way` (m, of the hand along the normal) and holds
/// none any more: before another tool plays the string.
HD_REALTIME void book_held_force(double way, StringState& state) noexcept;

}  // namespace hapticd
