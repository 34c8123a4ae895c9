// Why there is no force, or why it was cut. The numbers are those of Cause in event.proto, so that
// translating is a cast. Also which causes only count on a device that cannot push a person, such
// as the simulated one. RT: yes.
#pragma once

#include <cstdint>

namespace hapticd {

/// Same numbers as hapticd::v1::Cause.
enum class Cause : std::uint8_t {
  kNone = 0,
  kStopped = 1,          ///< a client's Stop
  kNotFinite = 2,        ///< a pose, velocity or wrench was not finite, or a quaternion useless
  kInputStale = 3,       ///< no new sample for more than the ticks that may be bridged
  kInputStuck = 4,       ///< the device repeats itself while its own counter advances
  kVelocityTrip = 5,     ///< the handle moves faster than the profile allows
  kOverrun = 6,          ///< too many late ticks in a second
  kGuardian = 7,         ///< the loop stalled and the guardian wrote zero
  kLeaseLost = 8,        ///< the lease of a scripted device's controller ran out
  kDeviceLost = 9,       ///< unplugged, or never there
  kDeviceFault = 10,     ///< the device itself reports a fault
  kDeviceWrite = 11,     ///< forces do not reach the device
  kDeviceWatchdog = 12,  ///< the device's own watchdog has fired
  kEmergencyStop = 13,   ///< its emergency stop is pressed
  kDeadMan = 14,         ///< the dead-man switch is open
  kNotCalibrated = 15,   ///< its zero is not known
  kNotChecked = 16,      ///< the guided first check has not been passed
  kOverlap = 17,        ///< the tool touches or overlaps the scene, so force may not be switched on
  kEventOverflow = 18,  ///< more events than their ring holds
  kReplayDiffers = 19,  ///< a replay differs from its recording
  kInjected = 20,       ///< asked for, to see what happens
  kReleased = 21,       ///< the session's own end, or Disengage
};

/// Largest number of a Cause.
inline constexpr int kMaxCause = 21;

/// True when `cause` makes a fault of this device. A late loop or a fast hand is a danger only
/// where motors push a person; elsewhere, unless `armed` (to test the guards), those three are
/// counted and reported by whoever saw them.
[[nodiscard]] constexpr bool latches(Cause cause, bool can_push_a_person, bool armed) noexcept {
  switch (cause) {
    case Cause::kNone:
      return false;
    case Cause::kGuardian:
    case Cause::kOverrun:
    case Cause::kVelocityTrip:
      return can_push_a_person || armed;
    default:
      return true;
  }
}

}  // namespace hapticd
