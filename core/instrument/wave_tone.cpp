// See wave_tone.h. RT: yes.
#include "core/instrument/wave_tone.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// A mode turns with a partial of a part where their numbers along the string differ by less.
constexpr double kTogether = 1e-6;
/// Of loudness: 20 dB.
constexpr double kStays = 100.0;
/// Parts shorter than this share of the string do not sound.
constexpr double kMinPart = 0.02;

using Stops = FixedVector<double, kMaxTools + kMaxWaveRests + 2>;

/// Ends and stops, from A to B.
void find_stops(const WaveState& state, Stops& stops) noexcept {
  const auto add = [&](double lambda) {
    stops.push_back(lambda);
    for (std::size_t i = stops.size() - 1; i > 0 && stops[i] < stops[i - 1]; --i) {
      std::swap(stops[i], stops[i - 1]);
    }
  };
  add(0.0);
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    const WaveContact& contact = state.string.contacts[k];
    if (contact.near && state.grips[k].share >= kStopShare) add(contact.path.lambda_to);
  }
  for (const WaveRest& rest : state.string.rests) {
    if (rest.number >= 0 && rest.share >= kStopShare) add(rest.path.lambda_to);
  }
  add(1.0);
}

/// The open string: its modes are its partials.
void read_modes(const WaveState& state, const ModeTable& modes, SoundingPart& part) noexcept {
  part.count = std::min(modes.count, static_cast<int>(kMaxPartials));
  const ModalMotion& motion = state.string.motion;
  for (std::size_t i = 0; i < static_cast<std::size_t>(part.count); ++i) {
    const double y = motion.qy[i] * motion.qy[i] + motion.vy[i] * motion.vy[i];
    const double z = motion.qz[i] * motion.qz[i] + motion.vz[i] * motion.vz[i];
    part.partials[i] = std::sqrt(y + z);
    part.phases[i] = y >= z ? arctangent2(-motion.vy[i], motion.qy[i])
                            : arctangent2(-motion.vz[i], motion.qz[i]);
  }
}

/// How much of mode n is in partial j of a part that goes from a to b, both shares of the string:
///     2 / (b - a) integral_a^b (sin(n pi x) - the straight line between its ends) sin(j pi (x - a)
///     / (b - a)) dx = 2 n^2 / (pi j (r^2 - n^2)) (sin(n pi a) - (-1)^j sin(n pi b)),    r = j / (b
///     - a)
class PartialShares {
 public:
  PartialShares(const ModeTable& modes, const SoundingPart& part) noexcept
      : count_(static_cast<std::size_t>(modes.count)),
        from_(part.from),
        length_(part.to - part.from) {
    mode_shapes(modes, part.from, at_from_);
    mode_shapes(modes, part.to, at_to_);
  }

  /// Of partial j, j > 0, in every mode.
  void read(std::size_t j, PerMode& shares) const noexcept {
    const auto number = static_cast<double>(j);
    const double r = number / length_;
    const double factor = 2.0 / (kPi * number);
    const double sign = j % 2 == 0 ? -1.0 : 1.0;
    for (std::size_t i = 0; i < count_; ++i) {
      const auto n = static_cast<double>(i + 1);
      const double apart = r * r - n * n;
      const bool together = std::abs(r - n) < kTogether;
      shares[i] = together ? sin_half_turns(n * from_ + 0.5)
                           : factor * n * n / apart * (at_from_[i] + sign * at_to_[i]);
    }
  }

 private:
  std::size_t count_;
  double from_, length_;
  PerMode at_from_{}, at_to_{};
};

/// (a . y)^2 + (a . z)^2.
double across(const PerMode& a, const PerMode& y, const PerMode& z, std::size_t count) noexcept {
  double sum_y = 0.0;
  double sum_z = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    sum_y += a[i] * y[i];
    sum_z += a[i] * z[i];
  }
  return sum_y * sum_y + sum_z * sum_z;
}

/// Of a part: the sine series of what it is bent by beyond the straight line between its ends.
void project(const WaveState& state, const ModeTable& modes, SoundingPart& part) noexcept {
  const auto count = static_cast<std::size_t>(modes.count);
  const ModalMotion& motion = state.string.motion;
  // Speeds over 2 pi f_1, m.
  PerMode vy{};
  PerMode vz{};
  for (std::size_t i = 0; i < count; ++i) {
    const double faster = modes.omega[i] / modes.omega[0];
    vy[i] = faster * motion.vy[i];
    vz[i] = faster * motion.vz[i];
  }
  const PartialShares series(modes, part);
  PerMode shares{};
  part.count = static_cast<int>(kMaxPartials);
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    series.read(j + 1, shares);
    // Partial j of the part turns j / length times as fast as the string's first mode.
    const double slower = (part.to - part.from) / static_cast<double>(j + 1);
    part.partials[j] = std::sqrt(across(shares, motion.qy, motion.qz, count) +
                                 slower * slower * across(shares, vy, vz, count));
  }
}

/// sqrt(sum n^2 A_n^2): the amplitude of a fundamental with the same energy.
double same_energy(const SoundingPart& part) noexcept {
  double sum = 0.0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(part.count); ++j) {
    const double a = static_cast<double>(j + 1) * part.partials[j];
    sum += a * a;
  }
  return std::sqrt(sum);
}

}  // namespace

double amplitude_of(const WaveTuning& tuning, double energy) noexcept {
  if (!(tuning.tension > 0.0)) return 0.0;
  return std::sqrt(4.0 * tuning.length * energy / (kPi * kPi * tuning.tension));
}

SoundingPart sounding_part(const WaveState& state, const WaveTable& table) noexcept {
  const WaveTuning& tuning = state.string.tuning;
  Stops stops;
  find_stops(state, stops);
  SoundingPart loudest;
  double most = -1.0;
  for (std::size_t k = 0; k + 1 < stops.size() && table.modes.count > 0; ++k) {
    SoundingPart part;
    part.from = stops[k];
    part.to = stops[k + 1];
    const double length = part.to - part.from;
    if (length < kMinPart) continue;
    if (stops.size() == 2) {
      read_modes(state, table.modes, part);
      part.amplitude = amplitude_of(tuning, state.ringing);
    } else {
      project(state, table.modes, part);
      part.amplitude = same_energy(part);
    }
    part.frequency =
        tuning.frequency / length *
        std::sqrt((1.0 + tuning.inharmonicity / (length * length)) / (1.0 + tuning.inharmonicity));
    // Its energy, but for what all parts have in common.
    double loudness = part.amplitude * part.amplitude / length;
    // Clients stay with the part that was plucked, or that they were told of, until another is 20
    // dB louder.
    const double place = state.sounding.place;
    if (part.from < place && place < part.to) loudness *= kStays;
    if (loudness <= most) continue;
    most = loudness;
    loudest = part;
  }
  return loudest;
}

}  // namespace hapticd
