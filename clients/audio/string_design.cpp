// See string_design.h.
#include "clients/audio/string_design.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <numeric>

#include "clients/audio/body_design.h"

namespace hapticd::audio {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kNepersPerCent = std::numbers::ln2 / 1200.0;
/// Decay of an older tone when its string is plucked again. Shorter clicks, longer blurs.
constexpr double kChoke_s = 0.004;
/// Nearer to an end a pluck has nothing but its highest partials.
constexpr double kNearestToEnd = 0.01;
/// Partials above this share of the sample rate are left out.
constexpr double kMaxShare = 0.45;
/// Up to here the dispersion is fitted; beyond, partials are close enough to the law to be theirs.
constexpr double kDispersionUpTo_hz = 1500.0;
constexpr double kMaxDispersion = 0.95;

/// Phase delay of b / (1 + a z^-1), frames.
double loss_delay(double pole, double omega) {
  return -std::atan2(pole * std::sin(omega), 1.0 + pole * std::cos(omega)) / omega;
}

/// Phase delay of one section of the dispersion, frames.
double section_delay(double c, double omega) {
  return 1.0 - 2.0 * std::atan2(c * std::sin(omega), 1.0 + c * std::cos(omega)) / omega;
}

double filters_delay(const StringLoop& loop, double omega) {
  return loss_delay(loop.loss_pole, omega) + loop.sections * section_delay(loop.dispersion, omega);
}

/// The root inside the unit circle of rest a^2 + 2 half a + rest = 0, both above 0; -1 where it is
/// on the circle.
double pole(double half, double rest) {
  return half > rest ? -rest / (half + std::sqrt(half * half - rest * rest)) : -1.0;
}

/// The one-pole filter whose gain per round trip makes the fundamental decay in decay_s and the
/// high partials kHighDecayRatio times as fast.
void design_loss(const ToneSound& tone, double rate_hz, StringLoop& loop) {
  const double high_hz =
      std::min(std::max(kHighFrequency_hz, 4.0 * tone.frequency_hz), kMaxShare * rate_hz);
  const double low = std::cos(kTurn / loop.period);
  const double high = std::cos(kTurn * high_hz / rate_hz);
  const double round_trip_s = 1.0 / tone.frequency_hz;
  const double gain = std::exp(-round_trip_s / tone.decay_s);
  // |H(high)|^2 / |H(low)|^2 = r; and at 0 Hz no more than halfway from the gain to 1, or the loop
  // would swing itself up there.
  const double r = std::exp(-2.0 * (kHighDecayRatio - 1.0) * round_trip_s / tone.decay_s);
  loop.loss_pole =
      std::max(pole(low - r * high, 1.0 - r), pole(1.0 / gain - low, 1.0 / gain - 1.0));
  loop.loss_gain =
      gain * std::sqrt(1.0 + 2.0 * loop.loss_pole * low + loop.loss_pole * loop.loss_pole);
}

/// Allpass sections that make one high partial as sharp as the law of a stiff string says.
void design_dispersion(const ToneSound& tone, double rate_hz, StringLoop& loop) {
  const double b = tone.inharmonicity;
  const double partial = std::clamp(std::floor(kDispersionUpTo_hz / tone.frequency_hz), 2.0, 24.0);
  const double stretch = std::sqrt((1.0 + b * partial * partial) / (1.0 + b));
  const double omega_1 = kTurn / loop.period;
  const double omega_n = partial * omega_1 * stretch;
  if (b <= 0.0 || omega_n >= kTurn * kMaxShare || tone.frequency_hz * 40.0 > rate_hz) return;
  loop.sections = kMaxSections;
  const double wanted = loop.period * (1.0 - 1.0 / stretch);
  // What the line itself needs, at the highest pitch of the glide, bounds the sections.
  const double room = loop.period * std::exp(-tone.glide_cents * kNepersPerCent) - kMinDelay - 1.0;
  double weak = 0.0;
  double strong = -kMaxDispersion;
  for (int halving = 0; halving < 60; ++halving) {
    loop.dispersion = 0.5 * (weak + strong);
    const double got = filters_delay(loop, omega_1) - filters_delay(loop, omega_n);
    (got < wanted && filters_delay(loop, omega_1) < room ? weak : strong) = loop.dispersion;
  }
}

/// One period of what the finger leaves behind, as it pulls at the bridge: partial n of the
/// displacement counts n times.
void design_excitation(const ToneSound& tone, double onset_period, Excitation& excitation) {
  const double lambda = std::clamp(tone.lambda, kNearestToEnd, 1.0 - kNearestToEnd);
  const int room = static_cast<int>(kMaxShare * onset_period);
  const int given = static_cast<int>(tone.partials.size());
  excitation.partials =
      std::clamp(given > 0 ? given : kMaxPartials, 1, std::min(kMaxPartials, std::max(room, 1)));
  for (int n = 1; n <= excitation.partials; ++n) {
    const double angle = n * std::numbers::pi;
    const double blunt = angle * kFingerWidth;
    const double amplitude =
        given > 0 ? static_cast<double>(tone.partials[static_cast<std::size_t>(n - 1)]) * n
                  : std::sin(angle * lambda) / n * std::exp(-0.5 * blunt * blunt);
    excitation.amplitude[static_cast<std::size_t>(n - 1)] = static_cast<float>(amplitude);
  }
  excitation.cosine = std::cos(kTurn / onset_period);
  excitation.sine = std::sin(kTurn / onset_period);
  excitation.frames = static_cast<int>(std::ceil(onset_period));
}

/// Root mean square of the first kLevelWindow_s behind the body, for a gain of 1.
double expected_rms(const Strike& strike, const Sound& sound) {
  double power = 0.0;
  for (int n = 1; n <= strike.excitation.partials; ++n) {
    const double frequency_hz = n * sound.rate_hz / strike.loop.period;
    const double amplitude =
        static_cast<double>(strike.excitation.amplitude[static_cast<std::size_t>(n - 1)]) *
        body_gain(sound.body, kTurn * frequency_hz / sound.rate_hz);
    // Within a round trip nothing is lost; the window has this many of them.
    const double period_s = strike.loop.period / sound.rate_hz;
    const double losses = 2.0 * period_s / loop_decay_s(strike.loop, frequency_hz, sound.rate_hz);
    const double rounds = kLevelWindow_s / period_s;
    power +=
        0.5 * amplitude * amplitude * std::expm1(-losses * rounds) / (rounds * std::expm1(-losses));
  }
  return std::sqrt(power);
}

/// The first partials as they begin, in metres, with the decays of the loop.
void design_partials(const ToneSound& tone, double rate_hz, Strike& strike) {
  const auto& forces = strike.excitation.amplitude;
  const double size = std::sqrt(std::inner_product(
      forces.begin(), forces.end(), forces.begin(), 0.0, std::plus<>(),
      [](float a, float b) { return static_cast<double>(a) * static_cast<double>(b); }));
  const double metres = (tone.amplitude_m > 0.0 ? tone.amplitude_m : 1.0) / size;
  strike.sines = !tone.partials.empty() && tone.partials.size() <= kToldPartials;
  strike.per_metre = 1.0 / metres;
  strike.log_hz = std::log(tone.frequency_hz);
  ToldPartials& partials = strike.partials;
  partials.count = std::min(strike.excitation.partials, kToldPartials);
  partials.omega = kTurn / strike.loop.period;
  partials.inharmonicity = tone.inharmonicity;
  for (int k = 0; k < kToldPartials; ++k) {
    const auto n = static_cast<std::size_t>(k);
    const double frequency_hz = std::min((k + 1) * tone.frequency_hz, kMaxShare * rate_hz);
    partials.amplitude[n] = metres * std::abs(static_cast<double>(forces[n])) / (k + 1);
    partials.keep[n] = keep_per_frame(loop_decay_s(strike.loop, frequency_hz, rate_hz), rate_hz);
  }
}

/// Amplitudes relative to each other: what is beyond this, either way, is not a tone.
constexpr double kMaxPartial = 1e12;

bool in_range(const ToneSound& tone) {
  const bool partials_good = std::all_of(
      tone.partials.begin(), tone.partials.end(),
      [](float partial) { return std::abs(static_cast<double>(partial)) <= kMaxPartial; });
  return partials_good && tone.frequency_hz > 0.0 && tone.frequency_hz <= 2e4 &&
         tone.decay_s > 0.0 && tone.decay_s <= 1000.0 && tone.level >= 0.0 && tone.level <= 1.0 &&
         tone.lambda >= 0.0 && tone.lambda <= 1.0 && tone.glide_cents >= 0.0 &&
         tone.glide_cents <= 1200.0 && tone.glide_decay_s >= 0.0 && tone.glide_decay_s <= 1000.0 &&
         tone.inharmonicity >= 0.0 && tone.inharmonicity <= 0.1 &&
         tone.partials.size() <= kMaxPartials;
}

MidiNote note_of(const ToneSound& tone) {
  const double number = 69.0 + 12.0 * std::log2(tone.frequency_hz / 440.0);
  return {static_cast<std::uint8_t>(tone.string % 16),
          static_cast<std::uint8_t>(std::lround(std::clamp(number, 0.0, 127.0))),
          static_cast<std::uint8_t>(std::lround(1.0 + 126.0 * tone.level))};
}

}  // namespace

double keep_per_frame(double decay_s, double rate_hz) {
  return std::exp(-1.0 / (decay_s * rate_hz));
}

double energy_amplitude(std::span<const float> partials) {
  double sum = 0.0;
  double n = 0.0;
  for (const float partial : partials) {
    n += 1.0;
    sum += std::pow(n * static_cast<double>(partial), 2);
  }
  return std::sqrt(sum);
}

double loop_decay_s(const StringLoop& loop, double frequency_hz, double rate_hz) {
  const double omega = kTurn * frequency_hz / rate_hz;
  const double gain = loop.loss_gain / std::abs(1.0 + loop.loss_pole * std::polar(1.0, -omega));
  return loop.period / rate_hz / -std::log(gain);
}

Strike outline(const ToneSound& tone, const Sound& sound) {
  Strike strike;
  strike.string = tone.string;
  strike.choke = keep_per_frame(kChoke_s, sound.rate_hz);
  if (tone.glide_decay_s > 0.0) {
    strike.glide.size = tone.glide_cents * kNepersPerCent;
    strike.glide.keep = std::exp(-kGlideStep / (tone.glide_decay_s * sound.rate_hz));
  }
  strike.frames = std::llround(kLifeInDecays * tone.decay_s * sound.rate_hz);
  strike.note = note_of(tone);
  return strike;
}

std::optional<Strike> design_string(const ToneSound& tone, const Sound& sound) {
  if (!in_range(tone)) return std::nullopt;
  Strike strike = outline(tone, sound);
  StringLoop& loop = strike.loop;
  loop.period = sound.rate_hz / tone.frequency_hz;
  const double onset_period = loop.period / strike.glide.ratio();
  if (loop.period > kMaxPeriod || onset_period < 2.0 * kMinDelay) return std::nullopt;
  design_loss(tone, sound.rate_hz, loop);
  design_dispersion(tone, sound.rate_hz, loop);
  const double omega = kTurn / loop.period;
  loop.filter_delay = filters_delay(loop, omega);
  if (onset_period - loop.filter_delay < kMinDelay) return std::nullopt;
  design_excitation(tone, onset_period, strike.excitation);
  const double rms = expected_rms(strike, sound);
  if (!(rms > 1.0 / kMaxPartial)) return std::nullopt;
  strike.gain = sound.gain * tone.level * kLevelRms / rms;
  design_partials(tone, sound.rate_hz, strike);
  return strike;
}

}  // namespace hapticd::audio
