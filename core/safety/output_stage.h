// The last stage before a device; nothing is written that did not pass it, and it cannot be
// switched off: finite? -> passivity controller -> slew -> thermal limit -> saturation along the
// direction -> time to live. Wrench F_H_D: what the device does to the hand, about H, in the
// device's base D. Every limit after the slew only shortens, which never breaks the slew: decrease
// is free. RT: yes, about 100 ns.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/math/realtime.h"
#include "core/math/wrench.h"
#include "core/safety/passivity.h"
#include "core/safety/thermal_limit.h"
#include "core/safety/wrench_limit.h"

namespace hapticd {

/// Growth of force and torque, N/s and N m/s (2.2 N/ms, 0.05 N m/ms). Larger: a contact can strike
/// harder; smaller: hard surfaces and fast taps feel soft.
inline constexpr double kForceSlew = 2200.0;
inline constexpr double kTorqueSlew = 50.0;
/// Longest time growth is granted for in one tick, s: a pause must not become a jump.
inline constexpr double kMaxSlewStep_s = 0.005;
/// Computed wrenches beyond this are shortened to it before anything multiplies them, N and N m.
inline constexpr double kMaxComputedWrench = 1e6;

/// Device data. All finite (but where said) and >= 0, else nothing is written but zero.
struct SafetyLimits {
  WrenchLimits peak;
  /// Root mean square over the window, N and N m; infinite: no such limit.
  double continuous_force = std::numeric_limits<double>::infinity();
  double continuous_torque = std::numeric_limits<double>::infinity();
  double thermal_window_s = 10.0;
  PassivityLimits passivity;
  std::int64_t time_to_live_ns = 5'000'000;  ///< an older command is not obeyed
};

/// One tick.
struct SafetyInput {
  std::int64_t now_ns = 0;
  double dt_s = 0.0;     ///< since the last call: how long the last wrench was held
  double hold_s = 1e-3;  ///< nominal period: how long this one will be held
  bool enable = false;   ///< loop state kEngaged or kReleasing; else the wrench is zero
  double gain = 0.0;     ///< of the loop's ramp, clamped to [0, 1]
  Wrench F_H_D;          ///< as computed
  Twist V_DH_D;          ///< measured
  Twist displacement_D;  ///< measured since the last call, m and rad
  /// What the strings may give as vibration, J: the sum of their tanks, divided by the workspace
  /// scale (the port is the device's side of the map).
  double budget = 0.0;
  int flight = 0;  ///< ticks by which a wrench may reach the hand late, see PassivityControl
};

/// What was done, bit by bit.
enum SafetyFlag : std::uint32_t {
  kSafetyNotFinite = 1U << 0U,  ///< input was not finite: zero was written; a fault (kNotFinite)
  kSafetyPassivity = 1U << 1U,
  kSafetySlew = 1U << 2U,
  kSafetyThermal = 1U << 3U,
  kSafetySaturated = 1U << 4U,
};

/// What goes to the device.
struct SafetyOutput {
  Array3 f_H_D{};  ///< N
  Array3 t_H_D{};  ///< N m
  bool enable = false;
  std::int64_t expires_ns = 0;
  std::uint32_t flags = 0;  ///< SafetyFlag
};

/// Kept between ticks; plain, for snapshots and hashes.
struct SafetyState {
  Array3 f_H_D{};  ///< written last
  Array3 t_H_D{};
  PortEnergy port;
  ThermalLoad force_load;
  ThermalLoad torque_load;
};

static_assert(std::is_trivially_copyable_v<SafetyState>);
static_assert(std::is_trivially_copyable_v<SafetyOutput>);

/// Limits the wrench of one tick. Whatever the input, the output is finite, within the peak, has
/// grown no faster than the slew, and is zero unless enabled and every input is finite. What is
/// owed at the port is owed until it is repaid or forgiven, also without enable.
[[nodiscard]] HD_REALTIME SafetyOutput limit(const SafetyInput& input, const SafetyLimits& limits,
                                             SafetyState& state) noexcept;

/// True when every number of `limits` is in its range.
[[nodiscard]] HD_REALTIME bool usable(const SafetyLimits& limits) noexcept;

}  // namespace hapticd
