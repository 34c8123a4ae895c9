// The states of the haptic loop as a pure state machine: what happened in a tick goes in; state,
// reason and the gain on the wrench come out. Force is on in kEngaged, where the gain climbs from 0
// to 1 in 200 ms, fades in kReleasing within 50 ms, and is zero everywhere else. Faults are latched
// with their first cause until Clear. A scene is exchanged only while the gain is 0. RT: yes, about
// 10 ns.
//
//   kDetached -> kZeroing -> kReady -> kEngaged -> kReleasing -> kReady
//   any of these -> kFault -> (Clear) kReady, kZeroing or kDetached; any -> kOver
#pragma once

#include <cstdint>

#include "core/math/realtime.h"
#include "core/tick/cause.h"
#include "core/tick/loop_state.h"

namespace hapticd {

/// Time of the ramp from no force to all of it, s. Shorter: a start that can be felt as a blow.
inline constexpr double kEngageRamp_s = 0.200;
/// Longest time of the ramp to no force at an ordinary end, s. Longer: a hand is held on to.
inline constexpr double kReleaseRamp_s = 0.050;
/// Most time by which one tick advances the ramp upwards, s: a pause must not become a jump.
inline constexpr double kMaxRampStep_s = 0.005;

/// What happened since the last tick. Requests hold for one tick, all else for as long as it lasts.
struct LoopInput {
  double dt_s = 0.0;            ///< since the last tick; negative or not finite counts as 0
  bool attached = false;        ///< a device is there
  bool calibrated = false;      ///< its zero is known
  bool contact_free = false;    ///< the tool touches nothing and the wrench before limits is zero
  bool contact_known = true;    ///< contact_free means something: a tick has been computed
  bool engages_itself = false;  ///< simulated and scripted devices
  bool stale = false;           ///< poses do not come: what force there is fades, until they do
  bool lease_lost = false;      ///< the controller this device needs is gone
  bool scene_waits = false;     ///< a new scene is ready to be taken
  bool engage = false;          ///< request
  bool disengage = false;       ///< request
  bool stop = false;            ///< request; latched as a fault in any state but kOver
  bool clear = false;           ///< request
  bool end = false;             ///< request: the daemon ends
  Cause fault = Cause::kNone;   ///< what is wrong in this tick and latches (see latches())
  Cause block = Cause::kNone;   ///< why force may not be switched on, such as kNotChecked; no fault
                                ///< unless engaged
};

/// Kept between ticks; also what a snapshot needs.
struct LoopMachine {
  LoopState state = LoopState::kDetached;
  Cause cause = Cause::kDeviceLost;  ///< why it is not engaged; kNone: nothing to say
  double gain = 0.0;                 ///< on the wrench, [0, 1]
  bool wanted = true;  ///< engage when ready: as asked, or by itself; a device that does not engage
                       ///< by itself makes it false in the first tick
  bool started = false;  ///< a first tick was seen
  bool ending = false;   ///< kOver comes when the gain is 0
};

/// What the loop does in this tick.
struct LoopOutput {
  LoopState state = LoopState::kDetached;
  Cause cause = Cause::kNone;
  double gain = 0.0;           ///< on the wrench before the safety stage, [0, 1]
  bool scene_allowed = false;  ///< a waiting scene may be taken now: the gain is 0
  bool latched = false;        ///< a fault was latched in this tick
  bool cleared = false;        ///< Clear was granted in this tick
};

/// Advances `machine` by one tick. Order of precedence: end, stop and faults, device, requests.
/// - A fault or Stop makes the gain 0 in the same tick; only the first cause is kept. Clear is
///   granted once input.fault is kNone and, after kDeviceLost, the device is attached.
/// - From kReady to kEngaged only when wanted, contact-free, calibrated, not blocked, with a lease
///   and no scene waiting. Where it is known not to be contact-free the reason is kOverlap; a
///   device that engages itself waits until it is, for another the request is over.
/// - Losing the device or its zero while the gain may be above 0 is a fault.
/// - scene_waits while engaged: releasing, then kReady with scene_allowed; force returns by itself
///   once the scene was taken, under the conditions above.
/// - stale, while engaged, takes the gain back as fast as releasing does; it climbs again as at the
///   start once poses come, and is given up where it has come to 0.
/// - lease_lost and block, while engaged, release; they hold a ready loop back.
[[nodiscard]] HD_REALTIME LoopOutput advance(const LoopInput& input, LoopMachine& machine) noexcept;

}  // namespace hapticd
