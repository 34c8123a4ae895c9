// Strings that are stopped by one tool and plucked by another, and stops that glide. Truth: the
// closed form of a string's part under its raised tension, and finite differences of the string
// under a finger as stiff as flesh.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "core/math/elementary.h"
#include "tests/core/simulation/ensemble.h"
#include "tests/core/simulation/wave_path.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kFlesh = 2e4;
/// Of a thick finger that holds, which the string does not slip off, and of one that plucks, m.
constexpr double kHoldingTip = 15e-3;
constexpr double kReach = kHoldingTip + 0.34e-3;
constexpr double kPluckingReach = kEnsembleTip + 0.34e-3;
/// Both are parts of each tool, the plucking one so far below the other, m.
constexpr double kBelow = 80e-3;

/// A stop in the air.
struct Stop {
  double lambda = 0.4;
  double depth = 5e-3;  ///< of the hand below where it touches the string at rest, m
  double axial_stiffness = 2e3;
  double tension = 30.0;
  double decay = 1.0;
};

EnsembleOptions stopped_string(const Stop& stop) {
  EnsembleOptions options;
  options.strings = 1;
  options.string.tension = stop.tension;
  options.string.axial_stiffness = stop.axial_stiffness;
  options.string.decay = stop.decay;
  options.instrument = wave_options();
  options.tool = {{Vector3::Zero(), kHoldingTip}, {Vector3(0.0, -kBelow, 0.0), kEnsembleTip}};
  options.body_y = -0.3;
  return options;
}

GridString grid_of(const Stop& stop) {
  WaveScene scene;
  scene.tension = stop.tension;
  scene.axial_stiffness = stop.axial_stiffness;
  scene.decay = stop.decay;
  return grid_of(scene);
}

/// How far the string is bent where a coupling of 1 kN/m presses it, m.
double deflection_of(const Stop& stop) {
  const GridString grid = grid_of(stop);
  double low = 0.0;
  double high = stop.depth;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const double yields = held_force(grid, stop.lambda, middle) / 1000.0;
    (middle + yields < stop.depth ? low : high) = middle;
  }
  return low;
}

/// Tension over that at rest.
double raise_of(const Stop& stop, double deflection) {
  const double run = stop.lambda * (1.0 - stop.lambda) * kWaveLength * kWaveLength;
  return 1.0 + stop.axial_stiffness * deflection * deflection / (2.0 * run) / stop.tension;
}

double cents(double f, double due) { return 1200.0 * std::log2(f / due); }

/// Displacement of the string in the state.
Across swing_at(Ensemble& ensemble, double lambda) {
  const WaveMemory& wave = ensemble.simulation().memory().waves.front();
  PerMode shapes{};
  mode_shapes(wave.table.modes, lambda, shapes);
  const Transverse u = displacement(wave.table.modes, wave.state.string.motion, shapes);
  return {u.y, u.z};
}

/// Where the plucking hand is: below the string's bent line by as much as over a straight one.
Vector3 plucker(const Stop& stop, double lambda, double deflection, double z) {
  const double bent = deflection * (1.0 - lambda) / (1.0 - stop.lambda);
  return {kWaveLength * lambda, kBelow + 3e-3 - bent, z};
}

struct Sounded {
  int tones = 0;
  double told = 0.0;    ///< by the Tone, Hz
  double swings = 0.0;  ///< the state, Hz
  double force = 0.0;   ///< on the holding finger, mean, N
};

Sounded pluck_stopped(const Stop& stop, double pluck_at) {
  Ensemble ensemble(2, stopped_string(stop));
  // So stiff against turning that a contact is as soft as the coupling, wherever it is.
  for (std::size_t k = 0; k < 2; ++k) ensemble.simulation().scene(k).stiffness.length = 1.0;
  const double deflection = deflection_of(stop);
  const double x = kWaveLength * stop.lambda;
  const Vector3 away(kWaveLength * pluck_at, kBelow + 30e-3, 60e-3);
  for (int k = 0; k <= 100; ++k) {
    ensemble.tick({{x, kReach - stop.depth * k / 100.0, 0.0}, away});
  }
  const Vector3 holds(x, kReach - stop.depth, 0.0);
  for (int k = 0; k < 400; ++k) ensemble.tick({holds, away});
  for (int k = 0; k <= 60; ++k) {
    ensemble.tick({holds, plucker(stop, pluck_at, deflection, -12e-3 - 1e-3 * (60 - k))});
  }
  ensemble.events.clear();
  for (int k = 0; k <= 70; ++k) {
    ensemble.tick({holds, plucker(stop, pluck_at, deflection, -12e-3 + 1e-3 * k)});
  }
  std::vector<double> swing;
  Sounded sounded;
  const Vector3 far = plucker(stop, pluck_at, deflection, 58e-3);
  for (int k = 0; k < 500; ++k) {
    ensemble.tick({holds, far});
    // Across the finger's push a smooth finger does not hold it.
    swing.push_back(swing_at(ensemble, 0.5 * (1.0 + stop.lambda)).x());
    sounded.force += ensemble.output().tool(0).F_computed_H_W.f.y() / 500.0;
  }
  for (const StringEvent& event : ensemble.events) {
    if (event.kind != StringEventKind::kTone) continue;
    ++sounded.tones;
    sounded.told = event.frequency;
  }
  const double due = 65.4 / (1.0 - stop.lambda) * std::sqrt(raise_of(stop, deflection));
  sounded.swings = frequency(swing, 1e-3, due);
  return sounded;
}

/// The same on the grid: pitch of the part from the stop to its end, Hz.
double truth_of(const Stop& stop, double pluck_at) {
  const GridString string = grid_of(stop);
  StringGrid grid(string, 900);
  GridFinger flesh;
  flesh.radius = kReach;
  flesh.stiffness = kFlesh;
  flesh.damping = 1.0;
  GridFinger plectrum;
  plectrum.radius = kPluckingReach;
  grid.add(flesh);
  grid.add(plectrum);
  const double deflection = deflection_of(stop);
  const double depth = deflection + held_force(string, stop.lambda, deflection) / kFlesh;
  const FingerPath paths[] = {
      [&](double time) {
        return FingerPlace{stop.lambda, {kReach - depth * std::min(1.0, time / 0.1), 0.0}};
      },
      [&](double time) {
        const Vector3 p = plucker(stop, pluck_at, deflection, -12e-3 + std::max(0.0, time - 0.3));
        return FingerPlace{pluck_at, {p.y() - kBelow, p.z()}};
      }};
  play(grid, paths, 0.37);
  std::vector<double> swing;
  play(grid, paths, 0.5,
       [&] { swing.push_back(grid.displacement(0.5 * (1.0 + stop.lambda)).x()); });
  const double due = 65.4 / (1.0 - stop.lambda) * std::sqrt(raise_of(stop, deflection));
  return frequency(swing, grid.step_s(), due);
}

TEST_CASE("a string stopped in the air sounds at the pitch of its part under its tension") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t stops = scaled(60);
  for (std::int64_t i = 0; i < stops; ++i) {
    Stop stop;
    stop.lambda = random.uniform(0.3, 0.7);
    // Less, and the plectrum lifts the string off it.
    stop.depth = random.uniform(4e-3, 10e-3);
    const double pluck_at = random.uniform(0.5 * (1.0 + stop.lambda), 0.93);
    CAPTURE(stop.lambda);
    CAPTURE(stop.depth);
    CAPTURE(pluck_at);
    const Sounded sounded = pluck_stopped(stop, pluck_at);
    const double deflection = deflection_of(stop);
    const double due = 65.4 / (1.0 - stop.lambda) * std::sqrt(raise_of(stop, deflection));
    const double truth = truth_of(stop, pluck_at);
    CAPTURE(sounded.told);
    CAPTURE(due);
    CAPTURE(truth);
    CHECK(sounded.tones == 1);
    CHECK(std::abs(cents(sounded.told, due)) <= 5.0);
    // Where the other side has a partial nearby, both beat, and there is no one pitch.
    const double other = 65.4 / stop.lambda * std::sqrt(raise_of(stop, deflection));
    const bool beats = std::abs(cents(due, other * std::round(due / other))) < 60.0;
    if (!beats) CHECK(std::abs(cents(sounded.swings, truth)) <= 5.0);
    CHECK(sounded.force == within(held_force(grid_of(stop), stop.lambda, deflection), 0.01));
  }
}

/// Of both sides of a stop, over the time: mean squares of their swing over their lengths, m.
class SwingOfSides {
 public:
  explicit SwingOfSides(double lambda) : lambda_(lambda) {}
  /// `swing(place)` is the string's displacement along y at the share `place` of its length.
  void add(const std::function<double(double)>& swing) {
    left_.push_back(swing(0.5 * lambda_));
    right_.push_back(swing(0.5 * (1.0 + lambda_)));
  }
  /// Of the samples from `from` to `to`, shares of all: as the energy of both fundamentals.
  [[nodiscard]] double energy(double from, double to) const {
    return variance(left_, from, to) / lambda_ + variance(right_, from, to) / (1.0 - lambda_);
  }

 private:
  static double variance(const std::vector<double>& values, double from, double to) {
    const auto at = [&](double share) {
      return static_cast<std::size_t>(share * static_cast<double>(values.size()));
    };
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t k = at(from); k < at(to); ++k) {
      sum += values[k];
      squares += values[k] * values[k];
    }
    const auto count = static_cast<double>(at(to) - at(from));
    return squares / count - sum * sum / (count * count);
  }
  double lambda_;
  std::vector<double> left_, right_;
};

/// What both sides lose in 1 s after a pluck beside the stop, dB.
double loss(const SwingOfSides& sides) {
  return 10.0 * std::log10(sides.energy(0.0, 0.3) / sides.energy(0.7, 1.0));
}

/// Of the part from `from` to the end of a string: its sine series over the time.
class PartialsOfPart {
 public:
  explicit PartialsOfPart(double from) : from_(from) {}
  /// `swing(place)` is the string's displacement at the share `place` of its length.
  void add(const std::function<Across(double)>& swing) {
    constexpr int kPoints = 100;
    const Across at_stop = swing(from_);
    std::array<Across, kMaxPartials> sines;
    sines.fill(Across::Zero());
    for (int k = 1; k < kPoints; ++k) {
      const double share = static_cast<double>(k) / kPoints;
      const Across u = swing(from_ + share * (1.0 - from_)) - (1.0 - share) * at_stop;
      for (std::size_t j = 0; j < kMaxPartials; ++j) {
        sines[j] += 2.0 / kPoints * std::sin(kPi * static_cast<double>(j + 1) * share) * u;
      }
    }
    samples_.push_back(sines);
  }
  /// Amplitudes, both planes together, m.
  [[nodiscard]] std::array<double, kMaxPartials> amplitudes() const {
    std::array<double, kMaxPartials> sizes{};
    const auto count = static_cast<double>(samples_.size());
    for (std::size_t j = 0; j < kMaxPartials; ++j) {
      Across mean = Across::Zero();
      double squares = 0.0;
      for (const auto& sines : samples_) {
        mean += sines[j] / count;
        squares += sines[j].squaredNorm() / count;
      }
      sizes[j] = std::sqrt(2.0 * (squares - mean.squaredNorm()));
    }
    return sizes;
  }

 private:
  double from_;
  std::vector<std::array<Across, kMaxPartials>> samples_;
};

/// Whether what a client believes at the instant of each Tone, once all that is told of it has
/// come, is the part where it was plucked, or silence.
bool believes_plucked_part(const std::vector<StringEvent>& events, double pluck_at) {
  bool tones = false;
  for (const StringEvent& tone : events) {
    if (tone.kind != StringEventKind::kTone) continue;
    tones = true;
    const StringEvent* believed = nullptr;
    for (const StringEvent& event : events) {
      if (event.kind != StringEventKind::kSounding || event.t_ns > tone.t_ns) continue;
      if (believed == nullptr || event.number > believed->number) believed = &event;
    }
    if (believed == nullptr || believed->amplitude == 0.0) continue;
    if (pluck_at < believed->lambda || pluck_at > believed->lambda_to) return false;
  }
  return tones;
}

/// A stopped string for 1 s after its pluck.
struct StoppedRing {
  bool plucked_part = false;  ///< is what a client believes of the string from the Tone on

  SwingOfSides sides;
  std::array<double, kMaxPartials> partials{};  ///< of the plucked part when looked at, m
  std::array<double, kMaxPartials> told{};      ///< what a client plays then, m
};

/// Amplitudes that a client plays at t_ns, m.
std::array<double, kMaxPartials> told_partials(const StringEvent& told, std::int64_t t_ns) {
  std::array<double, kMaxPartials> sizes{};
  for (std::size_t j = 0; j < static_cast<std::size_t>(told.partial_count); ++j) {
    const double since = 1e-9 * static_cast<double>(t_ns - told.t_ns);
    sizes[j] = static_cast<double>(told.partials[j]) *
               std::exp(-since / static_cast<double>(told.decays[j]));
  }
  return sizes;
}

/// `looked`: when clients are looked at, ticks after the pluck.
StoppedRing ring_stopped(const Stop& stop, double kt, double pluck_at, int looked) {
  Ensemble ensemble(2, stopped_string(stop));
  for (std::size_t k = 0; k < 2; ++k) {
    ensemble.simulation().scene(k).stiffness.length = 1.0;
    ensemble.simulation().scene(k).stiffness.kt = kt;
  }
  // The string is bent by stop.depth, and the hand so much deeper as its coupling yields.
  const double hand = stop.depth + held_force(grid_of(stop), stop.lambda, stop.depth) / kt;
  Vector3 holds(kWaveLength * stop.lambda, kReach, 0.0);
  const Vector3 away(kWaveLength * pluck_at, kBelow + 30e-3, 60e-3);
  for (int k = 0; k < 500; ++k) {
    holds.y() = kReach - hand * std::min(1.0, k / 100.0);
    ensemble.tick({holds, away});
  }
  for (int k = 0; k <= 130; ++k) {
    ensemble.tick({holds, plucker(stop, pluck_at, stop.depth, -72e-3 + 1e-3 * k)});
  }
  StoppedRing ring{false, SwingOfSides(stop.lambda), {}, {}};
  PartialsOfPart partials(stop.lambda);
  for (int k = 0; k < 1000; ++k) {
    ensemble.tick({holds, plucker(stop, pluck_at, stop.depth, 58e-3)});
    ring.sides.add([&](double place) { return swing_at(ensemble, place).x(); });
    if (std::abs(k - looked) <= 50) {
      partials.add([&](double place) { return swing_at(ensemble, place); });
    }
    if (k != looked) continue;
    const auto told = std::find_if(
        ensemble.events.rbegin(), ensemble.events.rend(),
        [](const StringEvent& event) { return event.kind == StringEventKind::kSounding; });
    REQUIRE(told != ensemble.events.rend());
    const WaveMemory& wave = ensemble.simulation().memory().waves.front();
    ring.told = told_partials(*told, wave.state.string.done_ns);
  }
  ring.partials = partials.amplitudes();
  ring.plucked_part = believes_plucked_part(ensemble.events, pluck_at);
  return ring;
}

/// The same on the grid, where flesh of a finger stops the string.
SwingOfSides ring_stopped_truth(const Stop& stop, double kt, double pluck_at) {
  const GridString string = grid_of(stop);
  StringGrid grid(string, 600);
  GridFinger flesh;
  flesh.radius = kReach;
  flesh.stiffness = kFlesh;
  flesh.damping = 1.0;
  GridFinger plectrum;
  plectrum.radius = kPluckingReach;
  plectrum.stiffness = kt;
  grid.add(flesh);
  grid.add(plectrum);
  const double depth = stop.depth + held_force(string, stop.lambda, stop.depth) / kFlesh;
  const FingerPath paths[] = {
      [&](double time) {
        return FingerPlace{stop.lambda, {kReach - depth * std::min(1.0, time / 0.1), 0.0}};
      },
      [&](double time) {
        const Vector3 p = plucker(stop, pluck_at, stop.depth, -72e-3 + std::max(0.0, time - 0.3));
        return FingerPlace{pluck_at, {p.y() - kBelow, p.z()}};
      }};
  play(grid, paths, 0.43);
  SwingOfSides sides(stop.lambda);
  play(grid, paths, 1.0,
       [&] { sides.add([&](double place) { return grid.displacement(place).x(); }); });
  return sides;
}

TEST_CASE("a stopped string rings as long as finite differences have it, and is told as it rings") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t stops = scaled(60);
  for (std::int64_t i = 0; i < stops; ++i) {
    Stop stop;
    stop.lambda = random.uniform(0.2, 0.7);
    stop.depth = random.uniform(3e-3, 6e-3);
    stop.tension = random.uniform(20.0, 60.0);
    stop.decay = random.uniform(0.5, 3.0);
    const double kt = random.uniform(300.0, 4000.0);
    const double pluck_at = random.uniform(0.5 * (1.0 + stop.lambda), 0.93);
    CAPTURE(stop.lambda);
    CAPTURE(stop.depth);
    CAPTURE(stop.tension);
    CAPTURE(stop.decay);
    CAPTURE(kt);
    CAPTURE(pluck_at);
    const StoppedRing played = ring_stopped(stop, kt, pluck_at, 300);
    // Two thirds along, the short side drives the second partial of the long one: what passes the
    // stop counts for most there.
    const double allowed = std::abs(stop.lambda - 2.0 / 3.0) < 0.01 ? 6.0 : 2.0;
    CHECK(std::abs(loss(played.sides) - loss(ring_stopped_truth(stop, kt, pluck_at))) <= allowed);
    CHECK(played.plucked_part);
    const double loudest = *std::max_element(played.partials.begin(), played.partials.end());
    for (std::size_t j = 0; j < kMaxPartials; ++j) {
      CAPTURE(j);
      CAPTURE(played.told[j]);
      CAPTURE(played.partials[j]);
      const double share = std::max(played.told[j], played.partials[j]) / loudest;
      if (share < 0.1) continue;
      // It is told anew when it is 3 dB off; what is quiet beats with what couples it to others.
      CHECK(std::abs(20.0 * std::log10(played.told[j] / played.partials[j])) <=
            (share < 0.3 ? 9.0 : 4.0));
    }
  }
}

TEST_CASE("what a stopped string is bent by is not told as sound") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t stops = scaled(60);
  for (std::int64_t i = 0; i < stops; ++i) {
    Stop stop;
    stop.lambda = random.uniform(0.2, 0.7);
    stop.depth = random.uniform(3e-3, 6e-3);
    stop.tension = random.uniform(20.0, 60.0);
    stop.decay = random.uniform(0.22, 0.35);
    CAPTURE(stop.lambda);
    CAPTURE(stop.depth);
    CAPTURE(stop.tension);
    CAPTURE(stop.decay);
    // It has fallen by 22 to 36 dB.
    const StoppedRing played = ring_stopped(stop, 1000.0, 0.5 * (1.0 + stop.lambda), 900);
    const auto size = [](const std::array<double, kMaxPartials>& partials) {
      return std::sqrt(std::inner_product(partials.begin(), partials.end(), partials.begin(), 0.0));
    };
    CAPTURE(size(played.told));
    CAPTURE(size(played.partials));
    CHECK(size(played.told) <= 1.5 * size(played.partials));
    CHECK(size(played.told) >= 0.67 * size(played.partials));
  }
}

/// Of a stop that glides, 0.1 s each: what the state swings at and what is due, Hz.
struct GlidePitch {
  double swings = 0.0;
  double due = 0.0;
};

std::vector<GlidePitch> glide_after_pluck(const Stop& from, double to, double seconds) {
  Ensemble ensemble(2, stopped_string(from));
  for (std::size_t k = 0; k < 2; ++k) ensemble.simulation().scene(k).stiffness.length = 1.0;
  const double pluck_at = 0.9;
  const double deflection = deflection_of(from);
  Vector3 holds(kWaveLength * from.lambda, kReach, 0.0);
  const Vector3 away(kWaveLength * pluck_at, kBelow + 30e-3, -20e-3);
  for (int k = 1; k <= 300; ++k) {
    holds.y() = kReach - from.depth * std::min(1.0, k / 100.0);
    ensemble.tick({holds, away});
  }
  for (int k = 0; k <= 80; ++k) {
    ensemble.tick({holds, plucker(from, pluck_at, deflection, -20e-3 + 1e-3 * k)});
  }
  const Vector3 far = plucker(from, pluck_at, deflection, 60e-3);
  const int ticks = static_cast<int>(seconds * 1e3);
  std::vector<GlidePitch> pitches;
  std::vector<double> swing;
  for (int k = 1; k <= ticks; ++k) {
    Stop now = from;
    now.lambda = from.lambda + (to - from.lambda) * k / ticks;
    holds.x() = kWaveLength * now.lambda;
    ensemble.tick({holds, far});
    swing.push_back(swing_at(ensemble, 0.5 * (1.0 + now.lambda)).x());
    if (swing.size() < 100) continue;
    Stop middle = from;
    middle.lambda = now.lambda - 50.0 * (to - from.lambda) / ticks;
    const double raise = raise_of(middle, deflection_of(middle));
    const double due = 65.4 / (1.0 - middle.lambda) * std::sqrt(raise);
    // The string is the less bent the further the place is along the part.
    double mean = 0.0;
    for (const double y : swing) mean += y / 100.0;
    for (double& y : swing) y -= mean;
    pitches.push_back({frequency(swing, 1e-3, due), due});
    swing.clear();
  }
  return pitches;
}

TEST_CASE("a stop that glides takes the pitch along") {
  for (const double way : {80e-3, -80e-3, 200e-3}) {
    Stop stop;
    stop.depth = 5e-3;
    for (const GlidePitch& pitch : glide_after_pluck(stop, stop.lambda + way / kWaveLength, 0.6)) {
      CAPTURE(way);
      CAPTURE(pitch.swings);
      CAPTURE(pitch.due);
      CHECK(std::abs(cents(pitch.swings, pitch.due)) <= 15.0);
    }
  }
}

}  // namespace
}  // namespace hapticd::test
