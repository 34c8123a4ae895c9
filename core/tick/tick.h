// The record of a tick: one struct that the stages fill in turn, the recorder and the network read,
// and a replay is given. Each part is written by one stage, once a tick. Plain data, trivially
// copyable; SI; frames as named (D device base, W world, H hand, G tool). Copies of it travel by
// TickRing, which takes the used part of each column. RT: yes; 110 kB.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/math/plain.h"
#include "core/tick/cause.h"
#include "core/tick/contact_tick.h"
#include "core/tick/device_sample.h"
#include "core/tick/loop_state.h"
#include "core/tick/push_axis.h"
#include "core/tick/stage_clock.h"
#include "core/tick/string_tick.h"

namespace hapticd {

/// What reached the loop from outside in a tick, beside samples; bit i is v1::Order i + 1.
enum OrderBit : std::uint16_t {
  kOrderEngage = 1U << 0U,
  kOrderDisengage = 1U << 1U,
  kOrderStop = 1U << 2U,
  kOrderClear = 1U << 3U,
  kOrderEnd = 1U << 4U,
  kOrderLeaseLost = 1U << 5U,
  kOrderSceneWaits = 1U << 6U,
  kOrderStalled = 1U << 7U,
  kOrderEventLost = 1U << 8U,
  kOrderDeadMan = 1U << 9U,
};

/// How many of them there are.
inline constexpr int kOrderBits = 10;

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

/// What was asked of a tool from outside. Written by the loop.
struct ToolOrders {
  bool recentre = false;     ///< and not yet done
  bool clutch_open = false;  ///< for as long as it lasts
  PushAxis push = 0;         ///< of the guided check; 0: none
  PushAxis measure = 0;      ///< its damping along this axis; 0: none
};

/// Energy at the port of a tool's device, so far. Written by the passivity observer.
struct PortTick {
  double given = 0.0;    ///< to the hand, J
  double removed = 0.0;  ///< by the passivity controller, J
};

/// What the stiffness clamp grants. Written by it.
struct StiffnessTick {
  double scale = 1.0;  ///< on kt, kr, kc, k_v, (0, 1]
  double bound = 0.0;  ///< N/m
  double delay = 0.0;  ///< it was computed with, s
};

/// The gesture of a simulated hand. Written by it.
struct GestureTick {
  bool plays = false;
  double progress = 0.0;  ///< of this repetition, [0, 1]
  std::uint32_t repeats = 0;
  std::array<char, 65> name{};  ///< ends in 0
};

/// Where the hand is in a tick: a judged pose, brought to W. Finite, within kMaxPosition. Written
/// by who steps the simulation.
struct HandPose {
  std::int64_t t_ns = 0;            ///< when the sample was made, monotonic
  Array3 p_WH{};                    ///< m
  Array4 q_WH{1.0, 0.0, 0.0, 0.0};  ///< |q| in [0.5, 2]
};

/// One tool. Written by the loop, but for what is said below to be another stage's.
struct ToolTick {
  std::uint32_t tool_id = 0;
  std::uint16_t flags = 0;  ///< ToolFlagBit
  /// Entries of Tick::contacts that are this tool's: they follow those of the tool before.
  std::int32_t contacts = 0;
  ToolOrders asked;

  DeviceSample sample;        ///< the newest, of whichever tick
  bool came = false;          ///< it is of this tick, valid or not
  bool lost = false;          ///< the device is gone
  bool write_failed = false;  ///< the command did not reach it
  bool held = false;          ///< X_WH is a held pose

  HandPose placed;  ///< to be rendered

  // Written by the simulation.
  PlainPose X_WH;   ///< that of `placed`, normalised
  PlainTwist V_WH;  ///< in W
  PlainPose X_WG;
  ContactOutcome contact;
  PlainWrench F_computed_H_W;  ///< before limits and ramps, about the origin of G

  PlainWrench F_written_H_W;  ///< as the device got it, turned to W
  Array3 f_written_H_D{};     ///< its force as the device got it, N; not recorded
  PortTick port;
  StiffnessTick stiffness;
  GestureTick gesture;
};

/// Net force of a string on a tool, from its own law. Written by the simulation.
struct StringForceTick {
  std::int32_t tool = 0;    ///< index in Tick::tools
  std::int32_t string = 0;  ///< number among the scene's capsules
  Array3 F_W{};             ///< N
};

/// Quality and work that the tick was allowed. Written by the loop.
struct BudgetTick {
  std::uint32_t level = 0;  ///< of quality
  bool automatic = false;   ///< it follows a budget
  std::uint64_t work = 0;   ///< of all tools; 0: no bound
};

/// Work that it took, all tools together. Written by the simulation.
struct WorkTick {
  std::uint32_t sub_steps = 0;
  std::uint32_t qp_iterations = 0;
  std::uint64_t sphere_tests = 0;
  std::uint64_t work = 0;  ///< all of it in one number (core/contact/tick_work.h)
  bool cut_short = false;  ///< a tool's tick ended because the budget was used up
};

/// Time that each part of the tick took, ns. Written by the loop; never part of what is
/// bit-identical.
struct TimesTick {
  StageTimes stages{};         ///< that of kPublish is of the tick before; 0 in virtual time
  std::uint32_t cpu_ns = 0;    ///< thread's CPU time of the whole tick before
  std::uint64_t overruns = 0;  ///< ticks skipped so far
};

/// All of a tick that is no column. Written by the loop, but for work and energies.
struct TickHead {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;
  std::int64_t dt_ns = 0;     ///< since the tick before
  std::uint64_t skipped = 0;  ///< periods passed over since the tick before
  std::uint64_t change = 0;   ///< number of the change of settings that begins; 0: none
  std::uint32_t scene_id = 0;
  std::uint16_t orders = 0;  ///< OrderBit
  bool first = false;        ///< of the loop
  bool settling = false;     ///< a change of settings is under way
  LoopState state = LoopState::kDetached;
  Cause cause = Cause::kNone;
  BudgetTick budget;
  WorkTick work;
  TimesTick times;
  double string_energy = 0.0;       ///< of all that vibrates, J; written by the simulation
  double tank_energy = 0.0;         ///< that strings may still give to hands, J; likewise
  std::int32_t contacts_total = 0;  ///< with those that found no place
};

/// One tick. The strings' columns are written by the simulation, the contacts by the loop.
struct Tick : TickHead {
  FixedVector<ToolTick, kMaxTools> tools;
  FixedVector<ContactTick, kMaxReportedContacts> contacts;  ///< tool by tool, deepest first
  FixedVector<StringTick, kMaxStrings> strings;             ///< those not asleep
  /// Vertices of all strings, from A to B in each.
  FixedVector<StringBendTick, kMaxDeflectingStrings * kMaxTools> string_bends;
  FixedVector<StringForceTick, kMaxDeflectingStrings * kMaxTools> string_forces;
};
static_assert(std::is_trivially_copyable_v<Tick>);

}  // namespace hapticd
