// See wave_watch.h. RT: yes.
#include "core/instrument/wave_watch.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/deflection.h"
#include "core/instrument/mode_series.h"
#include "core/instrument/wave_tone.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// A touch ends after so long without force, ns: one that let go of a bent string, and one that the
/// ringing string strikes again and again.
constexpr std::int64_t kPluckedAfter_ns = 2'000'000;
constexpr std::int64_t kLeftAfter_ns = 30'000'000;
/// A touch may be over before the static law has followed it, ns: it arms by its force, too.
constexpr std::int64_t kStrike_ns = 20'000'000;
/// But only of a hand that is so fast, m/s: the string may strike a finger that holds still.
constexpr double kStrikeSpeed = 0.15;
/// A tone leaves more energy than there was, by this factor (1 dB),
constexpr double kLouder = 1.2589254117941673;
/// and more than that of this amplitude, m.
constexpr double kLeastTone = 20e-6;
/// Of the share of time with force, s.
constexpr double kShareTime = 0.02;
/// 1200 / log 2, and the largest glide an event can hold, cents.
constexpr double kCentsPerNeper = 1731.2340490667561;
constexpr double kMaxGlide = 1200.0;
/// The envelope is told anew where it is off by this share, and no sooner than this, ns.
constexpr double kEnvelopeError = 0.1;
constexpr std::int64_t kEnvelopePause_ns = 20'000'000;

StringEvent* append(const WatchedWave& wave, StringEventKind kind, std::int64_t t_ns,
                    StringEvents& events) noexcept {
  StringEvent* const event = events.append();
  if (event == nullptr) return nullptr;
  *event = StringEvent{};
  event->t_ns = t_ns;
  event->string = wave.index;
  event->kind = kind;
  return event;
}

double norm(const Transverse& a) noexcept { return std::sqrt(a.y * a.y + a.z * a.z); }

/// Energy of a string that is held `deflection` off its axis, J.
double bent_energy(const WatchedWave& wave, double lambda, double deflection) noexcept {
  const double run = lambda * (1.0 - lambda) * wave.string.length;
  return run > 0.0 ? 0.5 * wave.string.tension * deflection * deflection / run : 0.0;
}

/// How far `force` (N) bends it at lambda at rest, m.
double deflection_under(const WatchedWave& wave, double lambda, double force) noexcept {
  return force * lambda * (1.0 - lambda) * wave.string.length / wave.string.tension;
}

void tell_touch(const WatchedWave& wave, const WaveGrip& grip, std::int64_t t_ns,
                StringEvents& events) noexcept {
  const bool ringing = grip.energy_before > bent_energy(wave, 0.5, kLeastTone);
  StringEvent* event = append(wave, StringEventKind::kTouch, t_ns, events);
  if (event != nullptr) {
    event->ringing = ringing;
    event->lambda = grip.lambda;
    event->normal_speed = grip.normal_speed;
    event->tangential_speed = grip.tangential_speed;
    event->force = grip.largest_force;
  }
  event = append(wave, StringEventKind::kRadius, t_ns, events);
  if (event == nullptr) return;
  if (ringing) {
    event->radius_phase = RadiusPhase::kDamp;
    event->amplitude = amplitude_of(wave.state.string.tuning, grip.energy_before);
    event->decay = wave.string.touch_decay;
    event->frequency = wave.string.frequency;
  } else {
    event->radius_phase = RadiusPhase::kPress;
    event->deflection = grip.deflection;
  }
}

void tell_armed(const WatchedWave& wave, const WaveGrip& grip, double force, std::int64_t t_ns,
                StringEvents& events) noexcept {
  StringEvent* const event = append(wave, StringEventKind::kPress, t_ns, events);
  if (event == nullptr) return;
  event->lambda = grip.lambda;
  event->force = force;
  event->deflection = grip.deflection;
}

/// The envelope from t_ns on.
void tell_envelope(const WatchedWave& wave, RadiusPhase phase, std::int64_t t_ns,
                   StringEvents& events) noexcept {
  ToldEnvelope& told = wave.state.told;
  told = {t_ns, amplitude_of(wave.state.string.tuning, wave.state.ringing),
          phase == RadiusPhase::kDamp ? wave.string.touch_decay : wave.string.decay};
  StringEvent* const event = append(wave, StringEventKind::kRadius, t_ns, events);
  if (event == nullptr) return;
  event->radius_phase = phase;
  event->amplitude = told.amplitude;
  event->decay = told.decay;
  if (told.amplitude > 0.0) event->frequency = wave.string.frequency;
}

double tone_level(const WatchedWave& wave, double lambda, double amplitude) noexcept {
  const ToneOptions& options = wave.options.tones;
  const double level =
      options.level == ToneLevel::kForce
          ? deflection_force(wave.string, lambda, amplitude) / options.reference_force
          : amplitude / options.reference_amplitude;
  return std::clamp(options.gain * level, 0.0, 1.0);
}

void tell_tone(const WatchedWave& wave, const WaveGrip& grip, double since,
               StringEvents& events) noexcept {
  wave.state.sounding.place = grip.lambda;
  wave.state.sounding.plucked = true;
  const SoundingPart part = sounding_part(wave.state, wave.table);
  StringEvent* const event = append(wave, StringEventKind::kTone, grip.felt_ns, events);
  if (event == nullptr) return;
  event->lambda = grip.lambda;
  event->normal_speed = grip.normal_speed;
  event->tangential_speed = grip.tangential_speed;
  event->amplitude = part.amplitude * exponential(since / wave.string.decay);
  event->level = tone_level(wave, grip.lambda, event->amplitude);
  const double raised = wave.state.string.tuning.tension / wave.state.held_tension;
  event->frequency = part.frequency / std::sqrt(raised);
  event->decay = wave.string.decay;
  if (raised > 1.0) {
    event->glide_cents = std::min(kMaxGlide, 0.5 * kCentsPerNeper * logarithm(raised));
    event->glide_decay = 0.5 * wave.string.decay;
  }
  event->partial_count = part.count;
  const auto count = static_cast<std::size_t>(part.count);
  const double largest = *std::max_element(part.partials.begin(), part.partials.begin() + count);
  for (std::size_t k = 0; k < count && largest > 0.0; ++k) {
    event->partials[k] = static_cast<float>(part.partials[k] / largest);
  }
}

/// What an armed touch has left.
void release(const WatchedWave& wave, const WaveGrip& grip, std::int64_t t_ns,
             StringEvents& events) noexcept {
  WaveState& state = wave.state;
  const double least = bent_energy(wave, 0.5, kLeastTone);
  if (!(state.ringing > kLouder * grip.energy_before) || !(state.ringing > least)) return;
  state.released = state.ringing;
  const double refractory_ns = 1e9 * wave.options.release.refractory;
  const auto pause = static_cast<double>(grip.felt_ns - state.sounded_ns);
  if (!wave.options.tones.enabled || (state.sounded && pause < refractory_ns)) return;
  state.sounded = true;
  state.sounded_ns = grip.felt_ns;
  tell_tone(wave, grip, 1e-9 * static_cast<double>(t_ns - grip.felt_ns), events);
}

void end_touch(const WatchedWave& wave, WaveGrip& grip, std::int64_t t_ns,
               StringEvents& events) noexcept {
  const StringEventKind kind = grip.armed ? StringEventKind::kRelease : StringEventKind::kLeave;
  StringEvent* const event = append(wave, kind, grip.felt_ns, events);
  if (event != nullptr) {
    event->lambda = grip.lambda;
    event->normal_speed = grip.normal_speed;
    event->tangential_speed = grip.tangential_speed;
    event->force = grip.largest_force;
    if (grip.armed) event->deflection = grip.deflection;
  }
  if (grip.armed) release(wave, grip, t_ns, events);
  tell_envelope(wave, RadiusPhase::kRelease, t_ns, events);
  grip = WaveGrip{};
}

bool touched(const WaveState& state) noexcept {
  return std::any_of(state.grips.begin(), state.grips.end(),
                     [](const WaveGrip& grip) { return grip.touching; });
}

}  // namespace

void watch_grip(const WatchedWave& wave, const WaveTick& tick, const WaveGripTick& now,
                StringEvents& events) noexcept {
  WaveState& state = wave.state;
  WaveGrip& grip = state.grips[now.tool];
  WaveContact& contact = state.string.contacts[now.tool];
  const StringContactPath& path = contact.path;
  const std::int64_t t_ns = tick.from_ns + tick.steps * tick.step_ns;
  const double dt = 1e-9 * static_cast<double>(tick.steps * tick.step_ns);
  const bool presses = contact.near && path.touched > 0;
  const double share = presses ? static_cast<double>(path.touched) / tick.steps : 0.0;
  grip.share += (share - grip.share) * std::min(1.0, dt / kShareTime);
  if (presses) {
    grip.felt_ns = tick.from_ns + (path.last + 1) * tick.step_ns;
    grip.lambda = path.lambda_to;
    grip.deflection = std::max(now.deflection, 0.0);
    grip.normal_speed = now.normal_speed;
    grip.tangential_speed = now.tangential_speed;
    grip.largest_force = std::max(grip.largest_force, norm(path.force));
    state.player = static_cast<std::int32_t>(now.tool);
    if (!grip.touching) {
      grip.touching = true;
      grip.began_ns = tick.from_ns + path.first * tick.step_ns;
      tell_touch(wave, grip, grip.began_ns, events);
    }
    const bool strikes =
        t_ns - grip.began_ns <= kStrike_ns && contact.speed > kStrikeSpeed &&
        deflection_under(wave, grip.lambda, norm(path.force)) > wave.options.release.arm_deflection;
    const bool bent = strikes || now.deflection > wave.options.release.arm_deflection;
    if (!grip.armed && bent) {
      grip.armed = true;
      tell_armed(wave, grip, norm(path.force), grip.felt_ns, events);
    }
    return;
  }
  if (!grip.touching) {
    grip.energy_before = state.ringing;
    return;
  }
  // A string that a finger throws off while it goes on pressing comes back to it.
  if (now.pressed) grip.pressed_ns = t_ns;
  const std::int64_t pause = t_ns - std::max(grip.felt_ns, grip.pressed_ns);
  if (pause >= kPluckedAfter_ns) contact.load = {};
  if (pause >= (grip.armed ? kPluckedAfter_ns : kLeftAfter_ns)) {
    state.ringing = ringing_energy(wave.table, state.string);
    end_touch(wave, grip, t_ns, events);
  }
}

void watch_envelope(const WatchedWave& wave, std::int64_t t_ns, StringEvents& events) noexcept {
  const ToldEnvelope& told = wave.state.told;
  if (t_ns - told.t_ns < kEnvelopePause_ns) return;
  const double expected =
      told.decay > 0.0 ? told.amplitude * decay_over(t_ns - told.t_ns, told.decay) : 0.0;
  const double is = amplitude_of(wave.state.string.tuning, wave.state.ringing);
  if (std::abs(is - expected) <= kEnvelopeError * std::max(is, expected)) return;
  if (std::max(is, expected) < kLeastTone) return;
  tell_envelope(wave, touched(wave.state) ? RadiusPhase::kDamp : RadiusPhase::kRelease, t_ns,
                events);
}

void tell_silence(const WatchedWave& wave, std::int64_t t_ns, StringEvents& events) noexcept {
  if (wave.state.told.amplitude == 0.0) return;
  wave.state.ringing = 0.0;
  tell_envelope(wave, RadiusPhase::kRelease, t_ns, events);
}

}  // namespace hapticd
