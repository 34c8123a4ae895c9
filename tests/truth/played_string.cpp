// Plucks, stops and pitch on a grid.
#include "tests/truth/played_string.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace hapticd {
namespace {

constexpr double kPi = std::numbers::pi;

/// sum of signal * window * exp(-i omega t), t = 0 in the middle of the window.
std::complex<double> component(std::span<const double> signal, double step, double omega) {
  std::complex<double> sum = 0.0;
  const auto size = static_cast<double>(signal.size());
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const double s = (static_cast<double>(i) + 0.5) / size;
    const double window = 0.5 - 0.5 * std::cos(2.0 * kPi * s);
    sum += signal[i] * window * std::polar(1.0, -omega * (s - 0.5) * size * step);
  }
  return sum;
}

}  // namespace

GridTone pluck(const GridString& string, const GridPluck& pluck, int cells) {
  StringGrid grid(string, cells);
  grid.add(pluck.finger);
  // Begins just out of touch, and ends where the bent string is out of reach.
  const double start = -1.05 * pluck.finger.radius;
  constexpr double kFurthest = 0.1;
  GridTone tone;
  bool touched = false;
  while (grid.time() * pluck.speed < kFurthest) {
    const double y = start + pluck.speed * (grid.time() + grid.step_s());
    grid.step({{pluck.lambda, {y, pluck.height}}});
    const Across u = grid.displacement(pluck.lambda);
    tone.deflection = std::max(tone.deflection, u.norm());
    if (grid.finger(0).normal > 0.0) {
      touched = true;
      tone.time = grid.time();
    }
    // A string that swings after the finger by all it was bent no longer comes up to it.
    if (touched && y > u.x() + tone.deflection + pluck.finger.radius) break;
  }
  const StringGrid::Mode mode = grid.mode(1, 2.0 * kPi * string.frequency);
  tone.amplitude = std::sqrt(mode.q.squaredNorm() + mode.v.squaredNorm());
  tone.energy = grid.energy();
  return tone;
}

GridStop stop_at_fret(const GridString& string, const GridFret& fret, int cells) {
  StringGrid grid(string, cells);
  GridFinger finger;
  finger.stiffness = 2e4;
  finger.damping = 1.0;
  finger.friction = fret.friction;
  finger.bristle = 2e4;
  grid.add(finger);
  grid.add(GridFinger{});
  const bool fretted = std::isfinite(fret.below);
  if (fretted) {
    GridPlane top;
    top.lambda = fret.fret / string.length;
    top.offset = -fret.below;
    top.friction = 0.5;
    grid.add(top);
  }
  const double at = fret.pluck_at / string.length;
  const double held = fret.finger / string.length;
  // The straight line from the end to the fret, or to the finger, at the pluck.
  const double slope = fretted ? fret.below / fret.fret : fret.depth / fret.finger;
  const std::array<FingerPath, 2> paths{
      FingerPath([&](double time) {
        return FingerPlace{held, {0.0, finger.radius - fret.depth * std::min(1.0, time / 0.05)}};
      }),
      FingerPath([&](double time) {
        const double y = -0.02 + 0.5 * std::max(0.0, time - 0.15);
        return FingerPlace{at, {y, 4e-3 - slope * fret.pluck_at}};
      })};
  play(grid, paths, 0.3);
  std::vector<double> swing;
  GridStop stop;
  play(grid, paths, 0.5, [&] {
    swing.push_back(grid.displacement(0.4 * fret.fret / string.length).x());
    if (fretted) stop.fret_force += grid.plane(0).normal;
    stop.finger_force += grid.finger(0).normal;
    stop.tension += grid.tension();
  });
  stop.fret_force /= static_cast<double>(swing.size());
  stop.finger_force /= static_cast<double>(swing.size());
  stop.tension /= static_cast<double>(swing.size());
  const double sounding = fretted ? fret.fret : fret.finger;
  const double expected =
      string.frequency * string.length / sounding * std::sqrt(stop.tension / string.tension);
  stop.frequency = frequency(swing, grid.step_s(), expected);
  return stop;
}

GridPartials touch_harmonic(const GridString& string, const GridHarmonic& harmonic, int cells) {
  StringGrid grid(string, cells);
  constexpr double kSkin_m = 1e-3;
  GridFinger skin;
  skin.radius += kSkin_m;
  skin.stiffness = harmonic.force / kSkin_m;
  skin.damping = harmonic.damping;
  grid.add(skin);
  grid.add(GridFinger{});
  // The pluck passes the string at the time of its own length of way.
  constexpr double kStart_m = -8e-3;
  const double lift_time = -kStart_m / harmonic.pluck_speed + harmonic.lift_after;
  const std::array<FingerPath, 2> paths{
      FingerPath([&](double time) {
        const double lifted = harmonic.lift_speed * std::max(0.0, time - lift_time);
        return FingerPlace{static_cast<double>(harmonic.node) / harmonic.part,
                           {0.0, skin.radius - kSkin_m + lifted}};
      }),
      FingerPath([&](double time) {
        return FingerPlace{harmonic.pluck_lambda, {kStart_m + harmonic.pluck_speed * time, 3e-3}};
      })};
  play(grid, paths, lift_time + 0.1);
  GridPartials partials;
  double loudest = 0.0;
  const auto level = [&](int n) {
    const StringGrid::Mode mode = grid.mode(n, 2.0 * kPi * n * string.frequency);
    return std::sqrt(mode.q.squaredNorm() + mode.v.squaredNorm());
  };
  constexpr int kPartials = 24;
  for (int n = 1; n <= kPartials; ++n) {
    if (n % harmonic.part != 0) loudest = std::max(loudest, level(n));
  }
  partials.others = 20.0 * std::log10(loudest / level(harmonic.part));
  std::vector<double> swing;
  play(grid, paths, 0.5, [&] { swing.push_back(grid.displacement(0.5 / harmonic.part).x()); });
  partials.frequency = frequency(swing, grid.step_s(), harmonic.part * string.frequency);
  return partials;
}

void play(StringGrid& grid, std::span<const FingerPath> paths, double seconds,
          const std::function<void()>& look) {
  std::vector<FingerPlace> places(paths.size());
  const double end = grid.time() + seconds;
  while (grid.time() < end) {
    for (std::size_t i = 0; i < paths.size(); ++i) {
      places[i] = paths[i](grid.time() + grid.step_s());
    }
    grid.step(places);
    look();
  }
}

double frequency(std::span<const double> signal, double step, double guess) {
  const std::size_t half = signal.size() / 2;
  const double apart = static_cast<double>(half) * step;
  double f = guess;
  for (int round = 0; round < 4; ++round) {
    const double omega = 2.0 * kPi * f;
    const std::complex<double> first = component(signal.first(half), step, omega);
    const std::complex<double> second = component(signal.subspan(half, half), step, omega);
    // Each phase is about its own middle.
    const double gained = std::arg(second * std::conj(first) * std::polar(1.0, -omega * apart));
    f += gained / (2.0 * kPi * apart);
  }
  return f;
}

double held_force(const GridString& string, double lambda, double deflection) {
  const double curve = 1.0 / (lambda * string.length) + 1.0 / ((1.0 - lambda) * string.length);
  const double longer = 0.5 * deflection * deflection * curve;
  return (string.tension + string.axial_stiffness / string.length * longer) * deflection * curve;
}

}  // namespace hapticd
