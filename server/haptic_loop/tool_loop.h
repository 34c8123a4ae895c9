// One tool's part of a tick: its device read and judged, the map to the world, and the wrench
// passed through the safety stage and written. Frames: D of the tool's device, W. RT: yes, about
// 0.5 us a tool.
#pragma once

#include <cstdint>

#include "core/safety/output_stage.h"
#include "core/safety/pose_guard.h"
#include "core/simulation/touch_detector.h"
#include "server/haptic_loop/guided_push.h"
#include "server/haptic_loop/known_spring.h"
#include "server/haptic_loop/played_scene.h"

namespace hapticd {

/// A tool as the loop knows it.
struct ToolLoop {
  // Of the tick under way.
  DeviceSample sample;
  JudgedPose judged;
  PlacedHand placed;
  Wrench F_H_D;         ///< rendered, for the safety stage
  DeviceSpring wanted;  ///< likewise, for a device that renders it by itself
  SafetyOutput written;
  DeviceSpring spring;  ///< granted
  bool sample_came = false;
  bool device_lost = false;
  bool write_failed = false;
  bool wrench_not_finite = false;

  // From tick to tick.
  ToolOrders asked;  ///< recentring until it is done, a push for one tick
  PoseGuard guard;
  SafetyState safety;
  WorkspaceState workspace;
  bool clear_faults = false;  ///< its device is to forget what it has latched
  GuidedPush push;
  KnownSpring spring_under_test;
  TouchDetector touches;
  ContactReport contacts;
  bool contact_free = false;  ///< nothing touched or pushed the tool in the last tick rendered
  bool rendered = false;      ///< there was one
};

/// When a tick is.
struct LoopTime {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;
  std::int64_t dt_ns = 0;  ///< since the tick before
  double dt_s = 0.0;
  std::int64_t period_ns = 1'000'000;
};

/// Reads the device of `played` and finds where H is. `guards_armed`: as if the device could push a
/// person.
HD_REALTIME void read_tool(PlayedTool& played, const LoopTime& time, bool guards_armed,
                           ToolLoop& tool) noexcept;

/// Measured delays beyond this are no delays, s.
inline constexpr double kMaxDelay_s = 1.0;

/// Lets the stiffness clamp of `played` reckon with the delay that `sample` brings; true when that
/// is another than before, and settings are to be applied anew. Delays that make no sense, and NaN,
/// change nothing.
HD_REALTIME bool learn_delay(const DeviceSample& sample, PlayedTool& played) noexcept;

/// What `stiffness` is to the hand at the device of `map`, forces being multiplied by `gain`.
[[nodiscard]] HD_REALTIME DeviceSpring spring_at_device(const WorkspaceMap& map,
                                                        const ContactStiffness& stiffness,
                                                        double gain) noexcept;

/// Brings what was rendered to the device: tool.F_H_D, with what is pushed instead, and
/// tool.wanted.
HD_REALTIME void take_rendered(const PlayedTool& played, const RenderedTool& rendered,
                               ToolLoop& tool) noexcept;

/// True where the clutch has brought the tool so far off that its device's last pose, with which it
/// could begin, is out of reach.
[[nodiscard]] HD_REALTIME bool lost_its_way(const PlayedTool& played,
                                            const ToolLoop& tool) noexcept;

/// Passes tool.F_H_D through the safety stage, faded as `loop` says, and grants tool.wanted; zero
/// where the state bears no force. `budget`: what strings may still give to the hand, J.
HD_REALTIME void limit_tool(const PlayedTool& played, const LoopTime& time, const LoopOutput& loop,
                            double budget, ToolLoop& tool) noexcept;

/// Writes what the safety stage has passed.
HD_REALTIME void write_tool(PlayedTool& played, const LoopTime& time, ToolLoop& tool) noexcept;

/// What of the last read and write of the tool is wrong; kNone when nothing is.
[[nodiscard]] HD_REALTIME Cause fault_of(const ToolLoop& tool, bool pushes,
                                         bool guards_armed) noexcept;

}  // namespace hapticd
