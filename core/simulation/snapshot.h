// A whole tick for those outside the loop: what State on the wire is encoded from. Written in place
// into a ring by the haptic thread. Frames and units: as in the types it is filled from; plain
// data, trivially copyable. RT: yes.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "core/instrument/string_parameters.h"
#include "core/math/limits.h"
#include "core/math/wrench.h"
#include "core/safety/loop_state.h"
#include "core/simulation/contact_report.h"

namespace hapticd {

/// Strings that one snapshot lists, at most: all of a scene.
inline constexpr std::size_t kMaxListedStrings = 1024;

/// Plain twin of Wrench.
struct WrenchReading {
  Array3 f{};  ///< N
  Array3 t{};  ///< N m
};

/// What was out of the ordinary for a tool in a tick; bit i is v1::ToolFlag i + 1.
enum ToolFlagBit : std::uint16_t {
  kSlewLimited = 1U << 0U,
  kSaturated = 1U << 1U,
  kThermalLimited = 1U << 2U,
  kPassivityLimited = 1U << 3U,
  kRecovering = 1U << 4U,
  kLagging = 1U << 5U,
  kRowsMerged = 1U << 6U,
  kStringHeldRigid = 1U << 7U,
  kInputHeld = 1U << 8U,
  kClutched = 1U << 9U,
  kDeviceSpring = 1U << 10U,
};

/// The device of a tool as it was measured for the tick.
struct DeviceReading {
  Array3 p_DH{};  ///< m
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};
  float grip_m = 0.0F;             ///< NaN: none
  float temperature_deg_c = 0.0F;  ///< NaN: none
  std::uint16_t buttons = 0;       ///< bit i = button i
  std::uint16_t flags = 0;         ///< bit i is v1::DeviceFlag i + 1
};

/// One tool after a tick.
struct ToolReading {
  std::uint32_t tool_id = 0;
  std::uint16_t flags = 0;  ///< ToolFlagBit
  /// Entries of Snapshot::contacts that are this tool's: they follow those of the tool before.
  std::int32_t contacts = 0;
  Array3 p_WH{};  ///< m
  Array4 q_WH{1.0, 0.0, 0.0, 0.0};
  Array3 p_WG{};  ///< m
  Array4 q_WG{1.0, 0.0, 0.0, 0.0};
  WrenchReading F_H_W;           ///< as written to the device
  WrenchReading F_computed_H_W;  ///< before limits and ramps
  double minimum_gap = 0.0;      ///< m
  DeviceReading device;
  std::int64_t input_age_ns = 0;
  double port_energy = 0.0;       ///< given to the hand so far, J
  double removed_energy = 0.0;    ///< taken out by the passivity controller so far, J
  double stiffness_scale = 1.0;   ///< of the clamp
  double stiffness_bound = 0.0;   ///< granted, N/m
  double delay = 0.0;             ///< the clamp was computed with, s
  double measured_delay = 0.0;    ///< by the device's driver, s; NaN: not measured
  bool plays_gesture = false;     ///< of the simulated hand
  double gesture_progress = 0.0;  ///< in [0, 1]
  std::uint32_t gesture_repeats = 0;
  std::array<char, 65> gesture_name{};  ///< ends in 0
};

/// What a string does; values are those of v1::StringPhase.
enum class ShownPhase : std::uint8_t { kTouched = 1, kPressed = 2, kRinging = 3, kDamped = 4 };

/// One string that is not asleep.
struct StringRow {
  std::int32_t piece = 0;  ///< number among the scene's capsules
  ShownPhase phase = ShownPhase::kTouched;
  double lambda = 0.0;         ///< along the piece
  double radius_growth = 0.0;  ///< beyond R, m
  Array3 deflection_W{};       ///< m
};

/// Net force of a string on a tool, from its own law.
struct StringForce {
  std::int32_t tool = 0;  ///< index in Snapshot::tools
  std::int32_t piece = 0;
  Array3 F_W{};  ///< N
};

/// Time each part of the tick took, ns, and the thread's CPU time of all of it.
struct TickTiming {
  std::uint32_t read_ns = 0;
  std::uint32_t simulation_ns = 0;
  std::uint32_t safety_ns = 0;
  std::uint32_t write_ns = 0;
  std::uint32_t publish_ns = 0;  ///< of the tick before
  std::uint32_t cpu_ns = 0;      ///< of the tick before
  std::uint64_t overruns = 0;    ///< ticks skipped so far
};

/// Work the tick took, in counts.
struct TickWork {
  std::uint32_t sub_steps = 0;
  std::uint32_t qp_iterations = 0;
  std::uint64_t sphere_tests = 0;
  std::uint64_t work = 0;         ///< all of it in one number (core/contact/tick_work.h)
  std::uint64_t work_budget = 0;  ///< it was allowed; 0: no bound
  bool cut_short = false;         ///< a tool's tick ended because the budget was used up
};

/// One tick.
struct Snapshot {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;
  std::uint32_t scene_id = 0;
  LoopState loop_state = LoopState::kDetached;
  Cause cause = Cause::kNone;
  TickTiming timing;
  TickWork work;
  std::uint32_t quality_level = 0;
  bool quality_automatic = false;
  double string_energy = 0.0;  ///< J
  double tank_energy = 0.0;    ///< J
  FixedVector<ToolReading, kMaxTools> tools;
  FixedVector<StringForce, 64 * kMaxTools> string_forces;
  ContactReport contacts;  ///< tool by tool, of each the deepest first
  FixedVector<StringRow, kMaxListedStrings> strings;
};
static_assert(std::is_trivially_copyable_v<Snapshot>);

}  // namespace hapticd
