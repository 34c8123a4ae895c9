// See wave_sounding.h. RT: yes.
#include "core/instrument/wave_sounding.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/instrument/mode_series.h"
#include "core/instrument/wave_tone.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Between two looks at a string that is touched, ns, and at one that rings on by itself.
constexpr std::int64_t kLookEvery_ns = 4'000'000;
constexpr std::int64_t kLookSteady_ns = 50'000'000;
/// Between two messages, ns: as a rule, how far ahead of that they may run, and at least.
constexpr std::int64_t kTellEvery_ns = 10'500'000;
constexpr std::int64_t kTellAhead_ns = 10'000'000;
constexpr std::int64_t kTellSoonest_ns = 5'000'000;
/// What noise of a hand does not change a pitch by in a tick, as a logarithm: 0.3 cents.
constexpr double kBends = 0.3 / 1731.2340490667561;
/// A string is told of from this amplitude on, m, until it is 60 dB below the loudest.
constexpr double kLeastOnset = 20e-6;
constexpr double kSilence = 1e-3;
/// 1.5 cents, 1 dB and 3 dB as logarithms; a partial is heard within 20 dB of the loudest.
constexpr double kPitchError = 1.5 / 1731.2340490667561;
constexpr double kLevelError = 0.11512925464970229;
constexpr double kPartialError = 0.34538776394910684;
constexpr double kHeardShare = 0.1;
/// Loudness of a string that is touched is a mean over this time, s.
constexpr double kMeanOver = 0.02;
/// Decays that are told, s.
constexpr double kMinDecay = 2e-3;
constexpr double kMaxDecay = 1000.0;
constexpr double kCentsPerNeper = 1731.2340490667561;
/// The fastest glide that is told, cents/s: a string that is tuned or stopped anew between two
/// ticks jumps.
constexpr double kFastestGlide = 1e5;

double seconds(std::int64_t ns) noexcept { return 1e-9 * static_cast<double>(ns); }

/// Pitch that the client plays at t_ns, Hz.
double reckoned_frequency(const ToldSounding& told, std::int64_t t_ns) noexcept {
  const double since = std::min(seconds(t_ns - told.t_ns), kGlideFollowed);
  return told.frequency * exponential(told.cents_per_s * since / kCentsPerNeper);
}

/// What the client plays at t_ns.
SoundingPart reckoned(const ToldSounding& told, std::int64_t t_ns) noexcept {
  const double since = seconds(t_ns - told.t_ns);
  SoundingPart part;
  part.frequency = reckoned_frequency(told, t_ns);
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    if (told.amplitude[j] == 0.0) continue;
    part.partials[j] = told.amplitude[j] * exponential(-since / told.decay[j]);
  }
  return part;
}

double loudness(const std::array<double, kMaxPartials>& partials) noexcept {
  double sum = 0.0;
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    const double a = static_cast<double>(j + 1) * partials[j];
    sum += a * a;
  }
  return std::sqrt(sum);
}

double loudest(const std::array<double, kMaxPartials>& partials) noexcept {
  return *std::max_element(partials.begin(), partials.end());
}

/// |log(a / b)|; infinite where one is 0.
double apart(double a, double b) noexcept {
  if (!(a > 0.0) || !(b > 0.0)) return std::numeric_limits<double>::infinity();
  return std::abs(logarithm(a / b));
}

bool pitch_errs(double is, double told) noexcept { return apart(is, told) > kPitchError; }

bool level_errs(const SoundingPart& is, const SoundingPart& told, double silence) noexcept {
  const double size = loudness(is.partials);
  const double believed = loudness(told.partials);
  if (std::max(size, believed) < silence) return false;
  if (apart(size, believed) > kLevelError) return true;
  const double heard = kHeardShare * std::max(loudest(is.partials), loudest(told.partials));
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    const double most = std::max(is.partials[j], told.partials[j]);
    if (most > heard && apart(is.partials[j], told.partials[j]) > kPartialError) return true;
  }
  return false;
}

/// Decay of partial j from what it was when last looked at; its own where it does not fall faster.
double decay_of(const WatchedWave& wave, const SoundingPart& part, std::size_t j,
                double since) noexcept {
  const WaveTuning& tuning = wave.state.string.tuning;
  const double n = static_cast<double>(j + 1) / (part.to - part.from);
  const double free = 1.0 / (1.0 / tuning.decay + n * n * tuning.loss_n2);
  const double before = wave.state.sounding.heard[j];
  if (!(since > 0.0) || !(before > part.partials[j]) || !(part.partials[j] > 0.0)) return free;
  const double fall = since / logarithm(before / part.partials[j]);
  return std::clamp(std::min(free, fall), kMinDecay, kMaxDecay);
}

/// Cents a second by which the pitch, `frequency` (Hz) at t_ns, goes up: over two ticks, or over
/// the last where that has turned.
double glide_of(const ToldSounding& told, double frequency, std::int64_t t_ns) noexcept {
  std::array<double, 2> rates{};
  for (std::size_t k = 0; k < rates.size(); ++k) {
    const bool known = told.pitch[k] > 0.0 && frequency > 0.0 && t_ns > told.pitch_ns[k];
    if (known) rates[k] = logarithm(frequency / told.pitch[k]) / seconds(t_ns - told.pitch_ns[k]);
    if (!known && k > 0) rates[k] = rates[k - 1];
  }
  const bool turns = std::abs(rates[0] - rates[1]) * seconds(t_ns - told.pitch_ns[0]) > kBends;
  return std::clamp(kCentsPerNeper * (turns ? rates[0] : rates[1]), -kFastestGlide, kFastestGlide);
}

void fill(const WatchedWave& wave, const SoundingPart& part, SoundingCause cause,
          StringEvent& event) noexcept {
  const ToldSounding& told = wave.state.sounding;
  event.cause = cause;
  event.number = told.number;
  event.lambda = told.from;
  event.lambda_to = told.to;
  event.frequency = told.frequency;
  event.cents_per_s = told.cents_per_s;
  const double length = told.to - told.from;
  event.inharmonicity = wave.state.string.tuning.inharmonicity / (length * length);
  event.amplitude = part.amplitude;
  event.partial_count = part.count;
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    event.partials[j] = static_cast<float>(told.amplitude[j]);
    event.decays[j] = static_cast<float>(told.decay[j]);
    if (cause == SoundingCause::kOnset) event.phases[j] = static_cast<float>(part.phases[j]);
  }
}

void tell(const WatchedWave& wave, const SoundingPart& part, SoundingCause cause, std::int64_t t_ns,
          StringEvents& events) noexcept {
  ToldSounding& told = wave.state.sounding;
  const bool goes_on = told.sounds && !told.plucked;
  const double since = goes_on ? seconds(t_ns - told.looked_ns) : 0.0;
  const bool same_part =
      told.sounds && std::abs(part.from - told.from) < 0.01 && std::abs(part.to - told.to) < 0.01;
  const double read_after = seconds(std::max<std::int64_t>(0, wave.state.string.done_ns - t_ns));
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    told.decay[j] = decay_of(wave, part, j, same_part ? since : 0.0);
    told.amplitude[j] = part.partials[j] * exponential(read_after / told.decay[j]);
  }
  told.cents_per_s = same_part && goes_on ? glide_of(told, part.frequency, t_ns) : 0.0;
  if (!same_part) {
    told.pitch = {};
    told.pitch_ns[0] = t_ns;
  }
  told.from = part.from;
  told.to = part.to;
  told.place = 0.5 * (part.from + part.to);
  told.frequency = part.frequency;
  told.t_ns = t_ns;
  told.paced_ns = std::max(told.paced_ns, t_ns) + kTellEvery_ns;
  told.sounds = part.amplitude > 0.0;
  told.onset = std::max(told.sounds ? told.onset : 0.0, part.amplitude);
  ++told.number;
  StringEvent* const event = events.append();
  if (event == nullptr) return;
  *event = StringEvent{};
  event->t_ns = t_ns;
  event->string = wave.index;
  event->kind = StringEventKind::kSounding;
  event->tool = wave.state.player;
  fill(wave, part, cause, *event);
}

/// Somebody touches it in a way that is no stop, or has just let go: what it is bent by is no
/// sound.
bool is_being_bent(const WaveState& state) noexcept {
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    const WaveContact& contact = state.string.contacts[k];
    const bool loaded = contact.load.y != 0.0 || contact.load.z != 0.0;
    if (!contact.near || state.grips[k].share >= kStopShare) continue;
    if (contact.path.touched > 0 || loaded) return true;
  }
  return false;
}

/// No part has more energy than all of the string now: what a finger damps is damped at once.
void bound_by_ringing(const WaveState& state, SoundingPart& part) noexcept {
  const double most =
      amplitude_of(state.string.tuning, state.ringing) * std::sqrt(part.to - part.from);
  const double size = loudness(part.partials);
  if (size <= most) return;
  for (double& partial : part.partials) partial *= most / size;
}

/// The mean of its squares over some 20 ms: two parts that a soft finger couples beat. What has
/// grown twice as loud is so at once.
void smooth(const WaveState& state, std::int64_t t_ns, SoundingPart& part) noexcept {
  const ToldSounding& told = state.sounding;
  const double share = std::min(1.0, seconds(t_ns - told.looked_ns) / kMeanOver);
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    const double before = told.heard[j];
    const double now = part.partials[j];
    if (!(before > 0.0) || now > 2.0 * before) continue;
    part.partials[j] = std::sqrt(before * before + share * (now * now - before * before));
  }
  bound_by_ringing(state, part);
}

/// While its shape tells nothing: it is no louder than it rings.
void tell_damping(const WatchedWave& wave, std::int64_t t_ns, StringEvents& events) noexcept {
  const ToldSounding& told = wave.state.sounding;
  if (!told.sounds) return;
  const SoundingPart believed = reckoned(told, t_ns);
  SoundingPart part = believed;
  part.from = told.from;
  part.to = told.to;
  part.count = static_cast<int>(kMaxPartials);
  bound_by_ringing(wave.state, part);
  part.amplitude = loudness(part.partials);
  if (!level_errs(part, believed, kSilence * told.onset)) return;
  tell(wave, part, SoundingCause::kTouch, t_ns, events);
}

bool is_told_part(const SoundingPart& part, const ToldSounding& told) noexcept {
  return std::abs(part.from - told.from) + std::abs(part.to - told.to) <= 0.02;
}

/// Time to look at the string again, whose told part has `pitch` now (Hz).
bool is_due(const ToldSounding& told, double pitch, std::int64_t t_ns, bool steady) noexcept {
  const std::int64_t pause = t_ns - told.looked_ns;
  if (!told.sounds) return pause >= kLookEvery_ns;
  if (t_ns - told.t_ns < kTellSoonest_ns || t_ns < told.paced_ns - kTellAhead_ns) return false;
  if (steady) return pause >= kLookSteady_ns;
  return pause >= kLookEvery_ns || pitch_errs(pitch, reckoned_frequency(told, t_ns));
}

void keep(const SoundingPart& part, std::int64_t t_ns, ToldSounding& told) noexcept {
  told.looked_ns = t_ns;
  told.heard = part.partials;
  told.plucked = false;
}

void keep_pitch(double pitch, std::int64_t t_ns, ToldSounding& told) noexcept {
  if (t_ns == told.pitch_ns[0]) return;
  told.pitch = {pitch, told.pitch[0]};
  told.pitch_ns = {t_ns, told.pitch_ns[0]};
}

/// What clients are to be told of it now.
void look(const WatchedWave& wave, std::int64_t t_ns, bool steady, StringEvents& events) noexcept {
  WaveState& state = wave.state;
  ToldSounding& told = state.sounding;
  if (is_being_bent(state)) {
    tell_damping(wave, t_ns, events);
    return;
  }
  SoundingPart part = sounding_part(state, wave.table);
  if (!told.sounds) {
    if (part.amplitude > kLeastOnset) tell(wave, part, SoundingCause::kOnset, t_ns, events);
    keep(part, t_ns, told);
    return;
  }
  if (!steady && !told.plucked && is_told_part(part, told)) smooth(state, t_ns, part);
  const double silence = kSilence * told.onset;
  const SoundingPart believed = reckoned(told, t_ns);
  // From its Tone on, which is told some ticks after the pluck.
  const std::int64_t from_ns = told.plucked ? state.sounded_ns : t_ns;
  if (part.amplitude < silence) {
    end_sounding(wave, t_ns, events);
  } else if (!is_told_part(part, told) || pitch_errs(part.frequency, believed.frequency)) {
    tell(wave, part, SoundingCause::kGlide, from_ns, events);
  } else if (level_errs(part, believed, silence)) {
    const bool louder = loudness(part.partials) > loudness(believed.partials);
    tell(wave, part, steady || louder ? SoundingCause::kLift : SoundingCause::kTouch, from_ns,
         events);
  }
  keep(part, t_ns, told);
}

}  // namespace

void end_sounding(const WatchedWave& wave, std::int64_t t_ns, StringEvents& events) noexcept {
  if (!wave.state.sounding.sounds) return;
  SoundingPart silent;
  silent.from = wave.state.sounding.from;
  silent.to = wave.state.sounding.to;
  silent.frequency = wave.state.sounding.frequency;
  tell(wave, silent, SoundingCause::kDecay, t_ns, events);
}

void watch_sounding(const WatchedWave& wave, std::int64_t t_ns, bool steady,
                    StringEvents& events) noexcept {
  ToldSounding& told = wave.state.sounding;
  const bool moved = told.sounds && t_ns != told.pitch_ns[0];
  const double pitch = moved ? frequency_at(wave.state, told.place) : told.pitch[0];
  // A pluck is told with its Tone: what was heard before may be another part of the string.
  if (told.plucked || is_due(told, pitch, t_ns, steady)) look(wave, t_ns, steady, events);
  keep_pitch(pitch, t_ns, told);
}

}  // namespace hapticd
