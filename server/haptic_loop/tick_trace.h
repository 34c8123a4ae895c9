// One tick as the recorder needs it: exactly what the step was given and what came out, plain, on
// its way from the haptic thread to the telemetry thread through a ring. It becomes a TickRecord of
// recording.proto; doubles keep their bits. Frames as named. RT: yes, a copy of 2 KiB.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/math/limits.h"
#include "core/math/vector.h"
#include "core/safety/loop_state.h"
#include "core/tick/cause.h"
#include "server/haptic_loop/guided_push.h"

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
};

/// How many of them there are.
inline constexpr int kOrderBits = 9;

/// One tool's part of a tick.
struct ToolTrace {
  std::uint32_t tool_id = 0;
  std::uint16_t buttons = 0;
  std::uint16_t flags = 0;           ///< bit i = hapticd::v1::ToolFlag i + 1
  bool sample_came = false;          ///< p_DH, q_DH are of this tick, valid or not
  bool held = false;                 ///< X_WH is a held pose
  bool has_velocity = false;         ///< v_DH_D, w_DH_D were measured by the device
  bool lost = false;                 ///< the device is gone
  bool write_failed = false;         ///< the command did not reach it
  bool recentre = false;             ///< asked for, and not yet done
  bool clutch_open = false;          ///< asked for
  PushAxis push = 0;                 ///< of the guided check, asked for; hapticd::v1::Axis
  std::uint16_t device_flags = 0;    ///< kDevice... bits of the sample
  std::int64_t sample_t_ns = 0;      ///< instant of the sample, as the device said
  std::uint64_t sample_counter = 0;  ///< likewise
  std::uint64_t age_ns = 0;          ///< of the sample
  double stiffness_scale = 1.0;      ///< of the clamp, (0, 1]
  double measured_delay_s = std::numeric_limits<double>::quiet_NaN();  ///< as DeviceSample's
  Array3 p_DH{};                                                       ///< as it came, m
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};
  Array3 v_DH_D{};  ///< where has_velocity, m/s
  Array3 w_DH_D{};  ///< rad/s
  Array3 p_WH{};    ///< after the workspace map, m
  Array4 q_WH{1.0, 0.0, 0.0, 0.0};
  Array3 v_WH_W{};  ///< m/s
  Array3 w_WH_W{};  ///< rad/s
  Array3 p_WG{};    ///< m
  Array4 q_WG{1.0, 0.0, 0.0, 0.0};
  Array3 f_computed_H_W{};  ///< before the safety stage, N
  Array3 t_computed_H_W{};  ///< N m
  Array3 f_H_W{};           ///< written, N
  Array3 t_H_W{};           ///< N m
};

/// One tick. See TickRecord for each field.
struct TickTrace {
  std::uint64_t tick = 0;
  std::uint64_t t_ns = 0;
  std::uint64_t dt_ns = 0;
  std::uint64_t state_hash = 0;  ///< 0: not computed
  std::uint64_t sphere_tests = 0;
  std::uint64_t qp_iterations = 0;
  std::uint64_t work_budget = 0;  ///< as TickInput's
  std::uint64_t skipped = 0;      ///< periods passed over since the tick before
  std::uint64_t change = 0;       ///< number of the change of settings that begins; 0: none
  std::uint16_t orders = 0;       ///< OrderBit
  bool first = false;             ///< first tick of the loop
  std::uint32_t substeps = 0;
  std::uint32_t level = 0;  ///< quality
  std::uint32_t scene_id = 0;
  std::uint32_t cpu_ns = 0;
  LoopState loop_state = LoopState::kDetached;
  Cause cause = Cause::kNone;
  std::int32_t tool_count = 0;  ///< of `tools`, [0, kMaxTools]
  std::array<ToolTrace, kMaxTools> tools{};
};

static_assert(std::is_trivially_copyable_v<TickTrace>);

}  // namespace hapticd
