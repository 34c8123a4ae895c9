// What a string does after the contact stage has pressed or left it: the ladder asleep - touched -
// ringing - ringing under a finger, its vibration force, its release detector and its events. One
// call per awake string and tick; a string asleep costs nothing. Frames: scalars along the touch
// normal. Source: Eq. 8-9 of the paper; the departures are named where they are.
//
// Energy: a release leaves what rings with E0; a second one leaves the larger of the two, never
// their sum. It decays by T_d, faster under a finger, and loses what F_v gives to the hand; every
// change of level keeps it. A release fills the tank with what rings, less what the hand has drawn
// of late unless it left the string by slipping off: so no hand, not even one that plucks the
// string anew in every swing, ever draws more than the largest energy it was released with. RT:
// yes; 30 ns while it rings, 70 ns while touched, 130 ns both, with modes as they cost.
#pragma once

#include "core/instrument/energy_tank.h"
#include "core/instrument/instrument_options.h"
#include "core/instrument/modal_string.h"
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
  Vibration vibration;  ///< the fundamental's view: energy, envelope, phase; kept at every level
  EnergyTank tank;
  double drawn = 0.0;         ///< what the hand has drawn from the vibration of late, J
  std::int64_t drawn_ns = 0;  ///< when it last did
};

/// A string with all it takes to sound.
struct SoundingString {
  std::int32_t index;  ///< its number, for its events
  const StringConstants& string;
  const InstrumentOptions& options;
  StringState& state;
  ModalString* modes;  ///< null where options.modes == 0
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

/// How far the vibration reaches beyond R at lambda, m; 0 when silent. A tool nearer than this
/// touches the vibrating string.
[[nodiscard]] HD_REALTIME double envelope(const StringConstants& string, const StringState& state,
                                          double lambda, std::int64_t t_ns) noexcept;

/// One tick. touch.time.dt_ns == 0: nothing changes, the last force is held. Options and constants
/// may change from tick to tick; a string that may no longer ring is still at once.
[[nodiscard]] HD_REALTIME StringResponse respond(const SoundingString& sounding,
                                                 const StringTouch& touch,
                                                 StringEvents& events) noexcept;

/// Books what the force held so far has done over `way` (m, of the hand along the normal) and holds
/// none any more: before another tool plays the string.
HD_REALTIME void book_held_force(const StringConstants& string, double way, std::int64_t t_ns,
                                 StringState& state) noexcept;

}  // namespace hapticd
