// The ladder of one string: what it does after the contact stage has pressed or left it. A tick, in
// this order: book the work of the force held so far; see what the touch did; let the
// string ring to the end of the tick; climb or descend; draw the next force from the tank. RT: yes.
#include "core/instrument/quasi_static_string.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/mode_series.h"
#include "core/instrument/string_report.h"

namespace hapticd {
namespace {

/// A force is held at least this long, s: the period of the fastest loop. Longer than a tick makes
/// the tank more careful; 0 would let a tick that came early draw all of it.
constexpr double kMinHold = 0.25e-3;

/// Time in which releases grant the whole of what the last one may give, s: a hand does not pluck
/// one string more often than some ten times a second.
constexpr double kGrantTime = 0.1;

/// All that one call works on.
struct Tick {
  const QuasiStaticString& model;
  const StringConstants& string;
  const InstrumentOptions& options;
  const StringTouch& touch;
  StringState& state;
  const StringReport& report;
};

/// Of the hand away from the string over the tick, m.
double motion(const Tick& tick) noexcept {
  return tick.touch.way.value_or(tick.touch.distance - tick.touch.distance_before);
}

bool rings(const StringState& state) noexcept { return state.level == StringPhase::kFundamental; }

bool may_ring(const Tick& tick) noexcept { return tick.options.vibration && tick.model.rings(); }

/// What the string can do without ringing: under a finger it is bent, else it sleeps.
StringPhase silent_level(const Tick& tick) noexcept {
  const bool bent = tick.state.detector.touching && tick.model.bends();
  return bent ? StringPhase::kStatic : StringPhase::kAsleep;
}

void fall_silent(const Tick& tick) noexcept {
  tick.state.vibration = Vibration{};
  tick.state.tank = EnergyTank{};
  tick.state.level = silent_level(tick);
}

/// The envelope at the place of the release, m.
double ringing_amplitude(const StringState& state) noexcept {
  return rings(state) ? state.vibration.amplitude : 0.0;
}

/// Advances energy and phase to t_ns.
void advance_fundamental(const Tick& tick, std::int64_t t_ns) noexcept {
  advance_vibration(tick.string, tick.options.pitch_glide, t_ns, tick.state.vibration);
}

/// Takes what the force held over the tick has given to the hand from the tank. The vibration
/// follows Eq. 9 whatever it has given.
void book_work(const Tick& tick, bool slipped) noexcept {
  EnergyTank& tank = tick.state.tank;
  if (!rings(tick.state) || tank.held_force == 0.0) return;
  double moved = motion(tick);
  // A distance that jumped as the string slipped off is not motion of the hand: it may cost, but it
  // must not pay.
  if (slipped && !tick.touch.way && tank.held_force * moved < 0.0) moved = 0.0;
  settle_tank(moved, tank);
}

void begin_touch(const Tick& tick, std::int64_t t_ns) noexcept {
  StringState& state = tick.state;
  if (!rings(state)) {
    state.level = silent_level(tick);
    report_touch(tick.report, tick.touch, false, t_ns);
    if (state.level == StringPhase::kStatic) {
      report_press_radius(tick.report, state.detector.deflection, t_ns);
    }
    return;
  }
  advance_fundamental(tick, t_ns);
  set_decay(tick.string.touch_decay, state.vibration);
  report_touch(tick.report, tick.touch, true, t_ns);
  report_ringing_radius(tick.report, RadiusPhase::kDamp,
                        {ringing_amplitude(state), tick.string.touch_decay, t_ns});
}

/// A touch that was not armed leaves the string as it is.
void leave(const Tick& tick, std::int64_t t_ns) noexcept {
  StringState& state = tick.state;
  report_end(tick.report, StringEventKind::kLeave, t_ns);
  if (!rings(state)) {
    const bool bent = state.level == StringPhase::kStatic;
    state.level = StringPhase::kAsleep;
    if (bent) report_ringing_radius(tick.report, RadiusPhase::kRelease, {0.0, 0.0, t_ns});
    return;
  }
  // Damped up to the loss, or to where the books are if that was in an earlier tick.
  advance_fundamental(tick, t_ns);
  set_decay(tick.string.decay, state.vibration);
  report_ringing_radius(tick.report, RadiusPhase::kRelease,
                        {ringing_amplitude(state), tick.string.decay, state.vibration.t_ns});
}

/// Fills the tank at a release with what it takes to bend the string as far as it rings: Eq. 9 says
/// what is felt, though a hand that lets the string rise by its own motion has got that back
/// already, as static force. So a hand that plucks in time with the string would be driven, were
/// there not a bound on how often.
void fill_tank(const Tick& tick) noexcept {
  StringState& state = tick.state;
  const std::int64_t t_ns = tick.touch.time.t_ns;
  const double since = static_cast<double>(t_ns - state.granted_ns) * kSecondsPerNanosecond;
  const double share = state.granted_ns == 0 ? 1.0 : std::clamp(since / kGrantTime, 0.0, 1.0);
  state.granted_ns = t_ns;
  const ReleaseDetector& detector = state.detector;
  const double swing = std::max(detector.largest_deflection, state.vibration.amplitude);
  EnergyTank& tank = state.tank;
  tank.full = 0.5 * vibration_stiffness(tick.string, detector.lambda) * swing * swing;
  tank.energy = std::min(tank.energy + share * tank.full, tank.full);
}

/// The string rings again with `energy` (J) from the loss on, up to the end of the tick.
void start_ringing(const Tick& tick, double energy) noexcept {
  StringState& state = tick.state;
  const ReleaseDetector& detector = state.detector;
  state.vibration = start_vibration(tick.string, energy, detector.lambda, detector.lost_ns);
  state.level = StringPhase::kFundamental;
  advance_fundamental(tick, tick.touch.time.t_ns);
}

/// An armed touch has ended. Of two energies the larger stays, never their sum.
void release(const Tick& tick) noexcept {
  StringState& state = tick.state;
  ReleaseDetector& detector = state.detector;
  const std::int64_t t_ns = detector.lost_ns;
  report_end(tick.report, StringEventKind::kRelease, t_ns);

  if (may_ring(tick)) {
    const double energy = fundamental_energy(tick.string, detector.largest_deflection);
    const double left = energy * decay_over(tick.touch.time.t_ns - t_ns, 0.5 * tick.string.decay);
    if (left > state.vibration.energy) {
      start_ringing(tick, energy);
    } else if (rings(state)) {
      state.vibration.released_energy = state.vibration.energy;
    }
    if (rings(state)) fill_tank(tick);
  }
  if (!rings(state)) state.level = StringPhase::kAsleep;

  // At the instant of the release, from which the decay is counted.
  const double since = decay_over(tick.touch.time.t_ns - t_ns, tick.string.decay);
  const double amplitude = since > 0.0 ? ringing_amplitude(state) / since : 0.0;
  detector.outside = false;
  if (amplitude > 0.0 && tick.options.tones.enabled &&
      !refractory(tick.options.release, detector, t_ns)) {
    detector.sounded = true;
    detector.sounded_ns = t_ns;
    report_tone(tick.report, amplitude);
  }
  report_ringing_radius(tick.report, RadiusPhase::kRelease, {amplitude, tick.string.decay, t_ns});
}

/// What this scene permits now: options and parameters may change while a string rings.
void fit_level(const Tick& tick) noexcept {
  StringState& state = tick.state;
  if (!rings(state)) {
    state.level = silent_level(tick);
    return;
  }
  if (!may_ring(tick)) {
    fall_silent(tick);
    report_ringing_radius(tick.report, RadiusPhase::kRelease, {0.0, 0.0, tick.touch.time.t_ns});
    return;
  }
  const bool damped = state.detector.touching;
  set_decay(damped ? tick.string.touch_decay : tick.string.decay, state.vibration);
}

/// Rings to the end of the tick.
void ring_on(const Tick& tick) noexcept {
  if (rings(tick.state)) advance_fundamental(tick, tick.touch.time.t_ns);
}

/// Descends when little is left.
void sleep_when_quiet(const Tick& tick) noexcept {
  const Vibration& vibration = tick.state.vibration;
  if (!rings(tick.state)) return;
  if (vibration.energy > tick.options.sleep_energy * vibration.released_energy) return;
  fall_silent(tick);
  if (tick.state.level == StringPhase::kStatic) {
    report_press_radius(tick.report, tick.state.detector.deflection, tick.touch.time.t_ns);
  }
}

/// Eq. 9 under a finger: on a string that is pressed it adds to the static force; one that is not
/// strikes the finger while it swings out further than the gap.
double fundamental_force(const Tick& tick) noexcept {
  const StringTouch& touch = tick.touch;
  const Vibration& vibration = tick.state.vibration;
  const double a = displacement(vibration) * shape_factor(vibration, touch.lambda);
  const double k_v = vibration_stiffness(tick.string, touch.lambda);
  return touch.distance < 0.0 ? k_v * a : std::max(k_v * (a - touch.distance), 0.0);
}

/// The force to hold until the next tick: never attracts, and never gives more than the tank has.
double vibration_force(const Tick& tick) noexcept {
  StringState& state = tick.state;
  if (!rings(state) || !state.detector.touching) {
    state.tank.held_force = 0.0;
    return 0.0;
  }
  const double force = std::max(fundamental_force(tick), -std::max(tick.touch.force, 0.0));
  const double dt = static_cast<double>(tick.touch.time.dt_ns) * kSecondsPerNanosecond;
  const double along = force >= 0.0 ? 1.0 : -1.0;
  const double speed = std::max(
      {-along * tick.touch.normal_speed, along * tick.touch.hand_speed, along * motion(tick) / dt});
  const double reach = hand_reach(speed, tick.options.max_acceleration, std::max(dt, kMinHold));
  return draw_from_tank(force, reach, state.tank);
}

double radius_growth(const StringState& state) noexcept {
  const double delta = state.detector.touching ? state.detector.deflection : 0.0;
  return std::max(delta, ringing_amplitude(state));
}

/// How the touch of this tick is recognised; call before anything moves.
TouchLimits touch_limits(const Tick& tick) noexcept {
  TouchLimits limits;
  limits.release = tick.options.release;
  limits.envelope = ringing_amplitude(tick.state);
  // The shape only makes it smaller: a tool beyond all of it need not know.
  if (tick.state.detector.touching || tick.touch.distance < limits.envelope) {
    limits.envelope *= shape_factor(tick.state.vibration, tick.touch.lambda);
  }
  limits.can_arm = tick.model.bends();
  limits.max_acceleration = tick.options.max_acceleration;
  return limits;
}

}  // namespace

bool awake(const StringState& state) noexcept {
  return state.level != StringPhase::kAsleep || state.detector.touching;
}

double QuasiStaticString::reach(const StringState& state, double lambda,
                                std::int64_t t_ns) const noexcept {
  if (!hapticd::rings(state)) return 0.0;
  const double amplitude = fundamental_amplitude(string_, energy_at(state.vibration, t_ns));
  return amplitude * shape_factor(state.vibration, lambda);
}

void book_held_force(double way, StringState& state) noexcept {
  if (rings(state) && state.tank.held_force != 0.0) settle_tank(way, state.tank);
  state.tank.held_force = 0.0;
}

StringResponse QuasiStaticString::advance(const SoundingString& sounding, const StringTouch& touch,
                                          StringEvents& events) const noexcept {
  StringState& state = sounding.state;
  // Without a new sample all is held; what has happened meanwhile the next tick makes up for.
  if (touch.time.dt_ns <= 0) return {state.tank.held_force, radius_growth(state)};

  const StringReport report{sounding, events};
  const Tick tick{*this, string_, sounding.options, touch, state, report};
  fit_level(tick);

  const TouchLimits limits = touch_limits(tick);
  const bool was_pressed = state.detector.contact;
  const TouchReport change = watch_touch(limits, touch, state.detector);
  book_work(tick, was_pressed && !state.detector.contact && state.detector.slipped);

  if (change.began) begin_touch(tick, change.began_ns);
  if (change.armed) report_armed(report, touch, state.detector.deflection, change.armed_ns);
  if (change.ended && !change.released) leave(tick, change.ended_ns);
  ring_on(tick);
  if (change.released) release(tick);
  sleep_when_quiet(tick);
  const double F_v = vibration_force(tick);
  ReleaseDetector& detector = state.detector;
  if (detector.contact) detector.force = std::max(detector.force, touch.force + F_v);
  return {F_v, radius_growth(state)};
}

}  // namespace hapticd
