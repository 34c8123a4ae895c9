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
void read_modes(const ModalMotion& motion, const ModeTable& modes, SoundingPart& part) noexcept {
  part.count = std::min(modes.count, static_cast<int>(kMaxPartials));
  for (std::size_t i = 0; i < static_cast<std::size_t>(part.count); ++i) {
    const double y = motion.qy[i] * motion.qy[i] + motion.vy[i] * motion.vy[i];
    const double z = motion.qz[i] * motion.qz[i] + motion.vz[i] * motion.vz[i];
    part.partials[i] = std::sqrt(y + z);
    part.phases[i] = y >= z ? arctangent2(-motion.vy[i], motion.qy[i])
                            : arctangent2(-motion.vz[i], motion.qz[i]);
  }
}

/// Both planes of modes, and their speeds over 2 pi f_1 of the string's tuning, m.
struct Moving {
  PerMode qy, qz, vy, vz;
};

/// Of a mode, or a sum of some.
struct Moved {
  double qy = 0.0, qz = 0.0, vy = 0.0, vz = 0.0;
};

void add(const Moving& modes, std::size_t i, double share, Moved& sum) noexcept {
  sum.qy += share * modes.qy[i];
  sum.qz += share * modes.qz[i];
  sum.vy += share * modes.vy[i];
  sum.vz += share * modes.vz[i];
}

/// The modes, each by its `share`.
void weigh(const ModalMotion& motion, const ModeTable& modes, const PerMode& share,
           Moving& weighed) noexcept {
  for (std::size_t i = 0; i < static_cast<std::size_t>(modes.count); ++i) {
    const double speed = share[i] * (modes.omega[i] / modes.omega[0]);
    weighed.qy[i] = share[i] * motion.qy[i];
    weighed.qz[i] = share[i] * motion.qz[i];
    weighed.vy[i] = speed * motion.vy[i];
    weighed.vz[i] = speed * motion.vz[i];
  }
}

/// The sine series of what a part from a to b, both shares of the string, is bent by beyond the
/// straight line between its ends. Of mode n there is in partial j
///     2 / (b - a) integral_a^b (sin(n pi x) - line(x)) sin(j pi (x - a) / (b - a)) dx
///     = 2 n^2 / (pi j (r^2 - n^2)) (sin(n pi a) - (-1)^j sin(n pi b)),    r = j / (b - a)
/// or cos(n pi a) where r = n.
class PartialSeries {
 public:
  PartialSeries(const ModalMotion& motion, const ModeTable& modes,
                const SoundingPart& part) noexcept
      : count_(static_cast<std::size_t>(modes.count)),
        from_(part.from),
        length_(part.to - part.from) {
    PerMode at_from{};
    PerMode at_to{};
    mode_shapes(modes, part.from, at_from);
    mode_shapes(modes, part.to, at_to);
    PerMode share{};
    for (const bool odd : {true, false}) {
      for (std::size_t i = 0; i < count_; ++i) {
        squares_[i] = static_cast<double>((i + 1) * (i + 1));
        share[i] = squares_[i] * (odd ? at_from[i] + at_to[i] : at_from[i] - at_to[i]);
      }
      weigh(motion, modes, share, odd ? odd_ : even_);
    }
    share.fill(1.0);
    weigh(motion, modes, share, modes_);
  }

  /// Partial j, j > 0.
  [[nodiscard]] Moved partial(std::size_t j) const noexcept {
    const auto number = static_cast<double>(j);
    const double r = number / length_;
    const double nearest = nearest_integer(r);
    const bool meets = std::abs(r - nearest) < kTogether && nearest <= static_cast<double>(count_);
    const std::size_t together = meets ? static_cast<std::size_t>(nearest) - 1 : count_;
    const Moving& modes = j % 2 == 0 ? even_ : odd_;
    const double factor = 2.0 / (kPi * number);
    Moved sum;
    for (std::size_t i = 0; i < count_; ++i) {
      if (i != together) add(modes, i, factor / (r * r - squares_[i]), sum);
    }
    if (meets) add(modes_, together, sin_half_turns(nearest * from_ + 0.5), sum);
    return sum;
  }

 private:
  std::size_t count_;
  double from_, length_;
  PerMode squares_;
  Moving odd_, even_;  ///< what odd and even partials have of each mode, times (r^2 - n^2) pi j / 2
  Moving modes_;
};

/// Of a part.
void project(const ModalMotion& motion, const ModeTable& modes, SoundingPart& part) noexcept {
  const PartialSeries series(motion, modes, part);
  part.count = static_cast<int>(kMaxPartials);
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    const Moved moved = series.partial(j + 1);
    // Partial j of the part turns j / length times as fast as the string's first mode.
    const double slower = (part.to - part.from) / static_cast<double>(j + 1);
    part.partials[j] = std::sqrt(moved.qy * moved.qy + moved.qz * moved.qz +
                                 slower * slower * (moved.vy * moved.vy + moved.vz * moved.vz));
  }
}

/// Of the first partial of a part of `length`, a share of the string, Hz.
double frequency_of(const WaveTuning& tuning, double length) noexcept {
  const double B = tuning.inharmonicity;
  return tuning.frequency / length * std::sqrt((1.0 + B / (length * length)) / (1.0 + B));
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

double frequency_at(const WaveState& state, double place) noexcept {
  Stops stops;
  find_stops(state, stops);
  for (std::size_t k = 0; k + 1 < stops.size(); ++k) {
    const double length = stops[k + 1] - stops[k];
    if (stops[k] < place && place < stops[k + 1] && length >= kMinPart) {
      return frequency_of(state.string.tuning, length);
    }
  }
  return 0.0;
}

SoundingPart sounding_part(const WaveState& state, const WaveTable& table) noexcept {
  const WaveTuning& tuning = state.string.tuning;
  Stops stops;
  find_stops(state, stops);
  // What it is bent by is no sound, and a finite series shows some of it in every part.
  const ModalMotion motion = ringing_motion(table, state.string);
  SoundingPart loudest;
  double most = -1.0;
  for (std::size_t k = 0; k + 1 < stops.size() && table.modes.count > 0; ++k) {
    SoundingPart part;
    part.from = stops[k];
    part.to = stops[k + 1];
    const double length = part.to - part.from;
    if (length < kMinPart) continue;
    if (stops.size() == 2) {
      read_modes(motion, table.modes, part);
      part.amplitude = amplitude_of(tuning, state.ringing);
    } else {
      project(motion, table.modes, part);
      part.amplitude = same_energy(part);
    }
    part.frequency = frequency_of(tuning, length);
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
