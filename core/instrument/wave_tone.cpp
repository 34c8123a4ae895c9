// See wave_tone.h. RT: yes.
#include "core/instrument/wave_tone.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Places along a part at which its shape is looked at.
constexpr int kPlaces = 48;
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

/// Displacement and speed over 2 pi f_1 of the string's tuning, m.
struct Moving {
  Transverse u, v;
};

Moving moving_at(const WaveState& state, const ModeTable& modes, double lambda) noexcept {
  PerMode shapes{};
  mode_shapes(modes, lambda, shapes);
  const ModalMotion& motion = state.string.motion;
  Moving at;
  for (std::size_t i = 0; i < static_cast<std::size_t>(modes.count); ++i) {
    const double speed = shapes[i] * (modes.omega[i] / modes.omega[0]);
    at.u.y += shapes[i] * motion.qy[i];
    at.u.z += shapes[i] * motion.qz[i];
    at.v.y += speed * motion.vy[i];
    at.v.z += speed * motion.vz[i];
  }
  return at;
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

/// Of a part: the sine series of what it is bent by beyond the straight line between its ends.
void project(const WaveState& state, const ModeTable& modes, SoundingPart& part) noexcept {
  const double length = part.to - part.from;
  const Moving a = moving_at(state, modes, part.from);
  const Moving b = moving_at(state, modes, part.to);
  std::array<Moving, kMaxPartials> sums{};
  for (int k = 1; k < kPlaces; ++k) {
    const double share = static_cast<double>(k) / kPlaces;
    Moving at = moving_at(state, modes, part.from + share * length);
    const auto beyond = [&](Transverse& x, const Transverse& from, const Transverse& to) {
      x.y -= from.y + share * (to.y - from.y);
      x.z -= from.z + share * (to.z - from.z);
    };
    beyond(at.u, a.u, b.u);
    beyond(at.v, a.v, b.v);
    for (std::size_t j = 0; j < kMaxPartials; ++j) {
      const double shape = sin_half_turns(static_cast<double>(j + 1) * share);
      const auto add = [&](Transverse& sum, const Transverse& x) {
        sum.y += shape * x.y;
        sum.z += shape * x.z;
      };
      add(sums[j].u, at.u);
      add(sums[j].v, at.v);
    }
  }
  part.count = static_cast<int>(kMaxPartials);
  for (std::size_t j = 0; j < kMaxPartials; ++j) {
    // Partial j of the part turns j / length times as fast as the string's first mode.
    const double slower = length / static_cast<double>(j + 1);
    const auto squared = [](const Transverse& x) { return x.y * x.y + x.z * x.z; };
    part.partials[j] =
        2.0 / kPlaces * std::sqrt(squared(sums[j].u) + slower * slower * squared(sums[j].v));
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
