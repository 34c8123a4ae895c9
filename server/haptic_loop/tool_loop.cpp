// See tool_loop.h. RT: yes.
#include "server/haptic_loop/tool_loop.h"

#include <algorithm>
#include <utility>

#include "core/safety/device_spring.h"
#include "core/safety/passivity.h"
#include "core/safety/stiffness_clamp.h"
#include "server/haptic_loop/device_limits.h"

namespace hapticd {
namespace {

/// Time without a pose from a client, beyond what is bridged, in which force only fades, ns: what
/// networks and garbage collectors take, and the ramp out (kReleaseRamp_s).
constexpr std::int64_t kPoseGap_ns = 50'000'000;
/// A pose that repeats to the bit for so long under force is a stuck sensor, ns (GuardLimits).
constexpr std::int64_t kStuckAfter_ns = 250'000'000;
/// Of the largest force and of the allowance of energy, what measuring may take. Larger: limits
/// that interfere spoil it; smaller: friction and the encoder's steps do.
constexpr double kForceShare = 0.8;
constexpr double kEnergyShare = 0.5;
/// Of the allowance, what the spring stores: under a wrench that may be late the port counts
/// several times that while a handle of little damping rings.
constexpr double kStoredShare = 0.04;

/// The spring of an unknown device, and a pull that no limit shortens: the passivity controller
/// keeps back what each wrench on its way may give at the largest acceleration.
SpringStrength measuring_strength(const PlayedTool& played) noexcept {
  const StiffnessLimits& device = played.stiffness_limits;
  const PassivityLimits& port = played.limits.passivity;
  const double ticks = 0.5 * (kMostFlight + 1) * (kMostFlight + 2);
  const double risk = port.acceleration * device.period_s * device.period_s * ticks;  // m
  const double by_energy = kEnergyShare * port.allowance / std::max(risk, 1e-6);
  return {std::min(unknown_bound(device), played.grant.bound),
          std::min(kForceShare * played.limits.peak.force, by_energy),
          kStoredShare * port.allowance};
}

}  // namespace

void read_tool(PlayedTool& played, const LoopTime& time, bool guards_armed,
               ToolLoop& tool) noexcept {
  PlayedDevice& device = played.device;
  if (device.facets.poses != nullptr) device.facets.poses->set_tick(time.tick);
  DeviceSample& sample = tool.sample;
  const ReadOutcome outcome = device.device->read(time.t_ns, sample);
  tool.device_lost = outcome == ReadOutcome::kLost;
  tool.sample_came = outcome == ReadOutcome::kFresh;
  const DeviceProfile& profile = device.device->profile();
  GuardLimits limits;
  limits.reach = reach_of(played.map, tool.workspace);
  limits.velocity_trip = profile.velocity_trip;
  limits.loses_unseen = device.traits.has_no_clock;
  limits.report_interval_ns = limits.loses_unseen ? report_interval_ns(profile) : 0;
  limits.stale_ticks =
      bridged_ticks(profile.report_rate, 1e9 / static_cast<double>(time.period_ns));
  if (device.traits.follows_data && !guards_armed) {
    limits.may_wait = true;
    limits.fading_ticks = static_cast<int>(kPoseGap_ns / time.period_ns);
  }
  const bool has_sensors = device.traits.can_push_a_person || guards_armed;
  // A handle that nobody touches may lie still against the spring.
  const bool has_hand = tool.spring_under_test.axis == 0;
  limits.stuck_after_ns = has_sensors && has_hand ? kStuckAfter_ns : 0;
  tool.judged = judge(tool.sample_came ? &sample : nullptr, to_vector(tool.safety.f_H_D).norm(),
                      limits, tool.guard);
  if (!tool.guard.has_pose) {
    tool.placed = {};
    return;
  }
  tool.placed = place(played.map, played.X_WG_home,
                      {tool.judged.X_DH, tool.judged.V_DH_D, sample.buttons, tool.asked.clutch_open,
                       tool.asked.recentre, time.dt_s},
                      tool.workspace);
}

bool learn_delay(const DeviceSample& sample, PlayedTool& played) noexcept {
  const double delay_s = sample.measured_delay_s;
  const bool sensible = delay_s >= 0.0 && delay_s <= kMaxDelay_s;
  if (!sensible || delay_s == played.stiffness_limits.delay_s) return false;
  played.stiffness_limits.delay_s = delay_s;
  return true;
}

// Columns of the map give the hand's motion in the world for a unit of it at the device.
DeviceSpring spring_at_device(const WorkspaceMap& map, const ContactStiffness& stiffness,
                              double gain) noexcept {
  Matrix3 along;
  Matrix3 about;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Vector3 unit = Vector3::Unit(i);
    along.col(i) = to_world(map, Twist{unit, Vector3::Zero()}).v;
    about.col(i) = to_world(map, Twist{Vector3::Zero(), unit}).w;
  }
  // Forces are turned only, motions scaled too.
  const Matrix3 K_D = gain / map.scale * along.transpose() * stiffness.K_W * along;
  const Matrix3 Kr_D = gain * about.transpose() * stiffness.Kr_W * about;
  return {{K_D(0, 0), K_D(1, 1), K_D(2, 2), K_D(0, 1), K_D(0, 2), K_D(1, 2)},
          {Kr_D(0, 0), Kr_D(1, 1), Kr_D(2, 2)}};
}

void take_rendered(const PlayedTool& played, const RenderedTool& rendered,
                   ToolLoop& tool) noexcept {
  const Wrench& computed = rendered.F_computed_H_W;
  tool.contact_free = rendered.contact.active_count == 0 &&
                      rendered.contact.status != ContactStatus::kRecovering &&
                      computed.f.isZero(0.0) && computed.t.isZero(0.0);
  tool.rendered = true;
  const double gain = played.force_gain * tool.placed.wrench_share;
  // Numbers that are lost are for the safety stage to see.
  const bool lost = !computed.f.allFinite() || !computed.t.allFinite();
  const Wrench& F_H_W = lost ? computed : rendered.F_H_W;
  const Wrench F_H_D =
      with_push(tool.push, to_device(played.map, Wrench{F_H_W.f * gain, F_H_W.t * gain}));
  tool.F_H_D =
      with_spring(tool.spring_under_test, measuring_strength(played), tool.judged.X_DH.p, F_H_D);
  const bool is_guided = tool.push.axis != 0 || tool.spring_under_test.axis != 0;
  const bool wanted = played.device.device->profile().affine && !is_guided;
  tool.wanted = wanted ? spring_at_device(played.map, rendered.stiffness, gain) : DeviceSpring{};
}

bool lost_its_way(const PlayedTool& played, const ToolLoop& tool) noexcept {
  const double far = to_vector(tool.sample.p_DH).norm();
  return far > reach_of(played.map, tool.workspace) &&
         far <= reach_of(played.map, WorkspaceState{});
}

void limit_tool(const PlayedTool& played, const LoopTime& time, const LoopOutput& loop,
                double budget, ToolLoop& tool) noexcept {
  SafetyInput input;
  input.now_ns = time.t_ns;
  input.dt_s = time.dt_s;
  input.hold_s = 1e-9 * static_cast<double>(time.period_ns);
  const bool force = loop.state == LoopState::kEngaged || loop.state == LoopState::kReleasing;
  input.enable = tool.judged.usable && force;
  input.gain = loop.gain;
  input.F_H_D = tool.F_H_D;
  input.V_DH_D = tool.judged.V_DH_D;
  input.displacement_D = tool.judged.displacement_D;
  input.budget = budget / played.map.scale;
  input.flight = flight_of(played.stiffness_limits);
  tool.written = limit(input, played.limits, tool.safety);
  tool.wrench_not_finite = (tool.written.flags & kSafetyNotFinite) != 0;
  const DeviceProfile& profile = played.device.device->profile();
  tool.spring = DeviceSpring{};
  if (!profile.affine) return;
  // A command holds until the next but one, should that be lost.
  const double horizon_s = played.stiffness_limits.delay_s + 2.0 * input.hold_s;
  tool.spring = grant_spring(tool.wanted, {tool.written, loop.gain, input.V_DH_D, horizon_s,
                                           played.limits.peak, profile.stiffness_max});
}

void write_tool(PlayedTool& played, const LoopTime& time, ToolLoop& tool) noexcept {
  DeviceCommand command;
  command.f_H_D = tool.written.f_H_D;
  command.t_H_D = tool.written.t_H_D;
  command.enable = tool.written.enable;
  command.expires_ns = tool.written.expires_ns;
  command.sample_counter = tool.sample.counter;
  command.spring = tool.spring;
  command.clear_faults = tool.clear_faults;
  tool.write_failed = !played.device.device->write(time.t_ns, command) && !tool.device_lost;
}

// A watchdog fires when ticks come late, and as with late ticks: where nobody can be pushed, a
// machine that stood still for a moment is no reason to stop playing.
Cause fault_of(const ToolLoop& tool, bool pushes, bool guards_armed) noexcept {
  const bool cut_off = (tool.sample.flags & kDeviceWatchdogFired) != 0;
  const std::pair<bool, Cause> wrong[] = {
      {tool.judged.fault != Cause::kNone, tool.judged.fault},
      {tool.wrench_not_finite, Cause::kNotFinite},
      {tool.write_failed, Cause::kDeviceWrite},
      {(tool.sample.flags & kDeviceEmergencyStop) != 0, Cause::kEmergencyStop},
      {(tool.sample.flags & kDeviceReportsFault) != 0, Cause::kDeviceFault},
      {cut_off && (pushes || guards_armed), Cause::kDeviceWatchdog},
  };
  for (const auto& [is, cause] : wrong) {
    if (is && latches(cause, pushes, guards_armed)) return cause;
  }
  return Cause::kNone;
}

}  // namespace hapticd
