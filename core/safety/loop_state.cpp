// The states of the haptic loop. See loop_state.h. RT: yes.
#include "core/safety/loop_state.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

bool bears_force(LoopState state) noexcept {
  return state == LoopState::kEngaged || state == LoopState::kReleasing;
}

/// Where a loop without force belongs, by its device.
LoopState resting(const LoopInput& input) noexcept {
  if (!input.attached) return LoopState::kDetached;
  return input.calibrated ? LoopState::kReady : LoopState::kZeroing;
}

/// What makes a fault in this tick.
Cause present_fault(const LoopInput& input, LoopState state) noexcept {
  if (input.fault != Cause::kNone) return input.fault;
  if (bears_force(state) && !input.attached) return Cause::kDeviceLost;
  if (bears_force(state) && !input.calibrated) return Cause::kNotCalibrated;
  return input.stop ? Cause::kStopped : Cause::kNone;
}

/// What keeps a ready loop from engaging, whether asked to or not.
Cause hindrance(const LoopInput& input) noexcept {
  return input.lease_lost ? Cause::kLeaseLost : input.block;
}

void latch(Cause cause, LoopMachine& m) noexcept {
  m.state = LoopState::kFault;
  m.cause = cause;
  m.gain = 0.0;
  m.wanted = false;
}

/// Without force and without a fault: where the device is decides.
void rest(const LoopInput& input, LoopMachine& m) noexcept {
  const LoopState before = m.state;
  m.state = resting(input);
  if (m.state == LoopState::kDetached) m.cause = Cause::kDeviceLost;
  if (m.state == LoopState::kZeroing) m.cause = Cause::kNotCalibrated;
  if (m.state != LoopState::kReady) m.wanted = input.engages_itself;
  if (m.state == LoopState::kReady && before != LoopState::kReady) m.cause = Cause::kNone;
}

void try_to_engage(const LoopInput& input, LoopMachine& m) noexcept {
  const Cause hindered = hindrance(input);
  if (hindered != Cause::kNone) {
    m.cause = hindered;
    m.wanted = m.wanted && input.engages_itself;
    return;
  }
  if (m.cause != Cause::kReleased && m.cause != Cause::kOverlap) m.cause = Cause::kNone;
  if (input.stale) m.cause = Cause::kInputStale;
  if (!m.wanted || input.scene_waits || input.stale || !input.contact_known) return;
  if (!input.contact_free) {
    m.cause = Cause::kOverlap;
    m.wanted = input.engages_itself;
    return;
  }
  m.state = LoopState::kEngaged;
  m.cause = Cause::kNone;
  m.gain = 0.0;
}

void fade(double dt_s, LoopMachine& m) noexcept {
  m.gain = std::max(0.0, m.gain - dt_s / kReleaseRamp_s);
  if (m.gain > 0.0) return;
  m.state = m.ending ? LoopState::kOver : LoopState::kReady;
}

void stay_engaged(const LoopInput& input, double dt_s, LoopMachine& m) noexcept {
  const Cause hindered = hindrance(input);
  const bool stays = m.wanted && hindered == Cause::kNone && !input.scene_waits;
  if (stays && input.stale) {
    m.cause = Cause::kInputStale;
    m.gain = std::max(0.0, m.gain - dt_s / kReleaseRamp_s);
    if (!(m.gain > 0.0)) m.state = LoopState::kReady;
    return;
  }
  if (stays) {
    m.cause = Cause::kNone;
    m.gain = std::min(1.0, m.gain + std::min(dt_s, kMaxRampStep_s) / kEngageRamp_s);
    return;
  }
  m.state = LoopState::kReleasing;
  m.cause = Cause::kNone;  // an exchange of the scene is not a reason
  if (hindered != Cause::kNone) {
    m.cause = hindered;
    m.wanted = m.wanted && input.engages_itself;
  }
  if (!m.wanted && m.cause == Cause::kNone) m.cause = Cause::kReleased;
  fade(dt_s, m);
}

/// A tick without a fault.
void proceed(const LoopInput& input, double dt_s, LoopMachine& m) noexcept {
  if (!bears_force(m.state)) rest(input, m);
  const bool can_be_asked = m.state == LoopState::kReady || bears_force(m.state);
  if (input.engage && can_be_asked && !m.ending) m.wanted = true;
  if (input.disengage && can_be_asked) {
    m.wanted = false;
    m.cause = Cause::kReleased;
  }
  if (m.state == LoopState::kReady) {
    try_to_engage(input, m);
  } else if (m.state == LoopState::kEngaged) {
    stay_engaged(input, dt_s, m);
  } else if (m.state == LoopState::kReleasing) {
    fade(dt_s, m);
  }
}

}  // namespace

LoopOutput advance(const LoopInput& input, LoopMachine& m) noexcept {
  LoopOutput output;
  const double dt_s = std::isfinite(input.dt_s) ? std::max(0.0, input.dt_s) : 0.0;
  if (!m.started) {
    m.started = true;
    m.wanted = input.engages_itself;
  }
  if (m.state != LoopState::kOver) {
    m.ending = m.ending || input.end;
    if (m.ending) m.wanted = false;
    const Cause fault = present_fault(input, m.state);
    if (m.state == LoopState::kFault) {
      const bool gone = fault == Cause::kNone && (m.cause != Cause::kDeviceLost || input.attached);
      if (input.clear && gone) {
        output.cleared = true;
        m.state = LoopState::kZeroing;
        rest(input, m);
        m.wanted = input.engages_itself && !m.ending;
      }
    } else if (fault != Cause::kNone) {
      latch(fault, m);
      output.latched = true;
    } else {
      proceed(input, dt_s, m);
    }
    if (m.ending && !bears_force(m.state)) {
      if (m.state != LoopState::kFault) m.cause = Cause::kReleased;
      m.state = LoopState::kOver;
    }
  }
  output.state = m.state;
  output.cause = m.cause;
  output.gain = m.gain;
  output.scene_allowed = !bears_force(m.state) && m.state != LoopState::kOver;
  return output;
}

}  // namespace hapticd
