// What a finger feels of a string that rings or that it runs into, through the whole tick. Truth:
// finite differences of the string, met by the same hand through a spring as stiff as the coupling.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/core/simulation/wave_path.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr int kCells = 900;
/// Ticks of a touch before a hand that has come to rest counts as a finger that holds, which is
/// stiffer than the coupling.
constexpr std::size_t kPlucking = 80;
/// What a hand that comes fast may draw of a ringing it does not know, J: of a string that rings
/// with little more than that, less is felt.
constexpr double kDrawn = 15e-6;
/// A string that rings with less hardly rings, J.
constexpr double kFaintRinging = 20e-6;

/// A pluck, and a touch of what rings.
struct Stroke {
  WaveScene scene;
  double pluck_at = 0.25;
  double touch_at = 0.4;
  double wait = 0.3;    ///< from the pluck to the touch, about, s
  double speed = 0.2;   ///< of the touch, m/s
  double depth = 1e-3;  ///< of the hand under where it touches the string at rest, m
};

/// Where and when the hand touches.
struct Touching {
  HandPath path;
  std::size_t from = 0;  ///< tick in which it would touch the string at rest
};

Touching touch_after_pluck(const Stroke& stroke) {
  const double reach = stroke.scene.reach();
  HandPath path({stroke.pluck_at, {3e-3, -12e-3}});
  path.go({stroke.pluck_at, {3e-3, 60e-3}}, 1.0);
  path.go({stroke.pluck_at, {30e-3, 60e-3}}, 1.0);
  path.go({stroke.touch_at, {30e-3, 0.0}}, 5.0).stay(stroke.wait);
  path.go({stroke.touch_at, {reach + 10e-3, 0.0}}, 1.0);
  const double before = path.end();
  path.go({stroke.touch_at, {reach - stroke.depth, 0.0}}, stroke.speed).stay(0.6);
  return {path, static_cast<std::size_t>((before + 10e-3 / stroke.speed) * 1e3)};
}

/// What the truth feels, a mean of the past tick, as it is at the tick's end: what the static law
/// changes by in half a tick is added.
std::vector<Across> at_end(const std::vector<Across>& means, const std::vector<Across>& law) {
  std::vector<Across> now = means;
  for (std::size_t k = 1; k < now.size(); ++k) now[k] += 0.5 * (law[k] - law[k - 1]);
  return now;
}

double rms(const std::vector<double>& values) {
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

/// What vibrates of a force along y in `ticks` ticks from `from` on.
std::vector<double> beyond(const std::vector<Across>& all, const std::vector<Across>& law,
                           std::size_t from, std::size_t ticks) {
  std::vector<double> rest;
  for (std::size_t k = from; k < std::min(from + ticks, all.size()); ++k) {
    rest.push_back(all[k].x() - law[k].x());
  }
  return rest;
}

Stroke random_stroke(SplitMix64& random) {
  Stroke stroke;
  stroke.scene.tension = random.uniform(15.0, 80.0);
  stroke.scene.frequency = random.uniform(60.0, 200.0);
  stroke.scene.kt = random.uniform(400.0, 2000.0);
  stroke.pluck_at = random.uniform(0.08, 0.5);
  stroke.touch_at = random.uniform(0.1, 0.9);
  stroke.wait = random.uniform(0.05, 0.4);
  stroke.speed = random.uniform(0.05, 0.5);
  stroke.depth = random.uniform(0.5e-3, 3e-3);
  return stroke;
}

TEST_CASE("a finger on a ringing string feels it swing as finite differences have it") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t strokes = scaled(100);
  std::int64_t beyond_bound = 0;  // by some strokes; no more than one in fifty
  for (std::int64_t i = 0; i < strokes; ++i) {
    const Stroke stroke = random_stroke(random);
    CAPTURE(stroke.scene.tension);
    CAPTURE(stroke.scene.frequency);
    CAPTURE(stroke.scene.kt);
    CAPTURE(stroke.pluck_at);
    CAPTURE(stroke.touch_at);
    CAPTURE(stroke.wait);
    CAPTURE(stroke.speed);
    CAPTURE(stroke.depth);
    const Touching touching = touch_after_pluck(stroke);
    Instrument instrument = wave_instrument(stroke.scene);
    const FeltForces played = feel(instrument, touching.path);
    const FeltForces truth = feel(stroke.scene, touching.path, kCells);
    const std::size_t from = touching.from;
    const double felt = rms(beyond(played.all, played.law, from, kPlucking));
    const double due = rms(beyond(at_end(truth.all, played.law), played.law, from, kPlucking));
    // 3 mN are less than any hand feels. What the tank may lend bounds what is felt of a string
    // that hardly rings.
    const double energy = truth.energy[from - 3];
    const bool rings = energy >= kFaintRinging;
    beyond_bound += rings && std::abs(felt - due) > 0.1 * due + 3e-3 ? 1 : 0;
    CHECK(felt <= (rings ? 1.2 : 1.1) * due + 3e-3);
    CHECK(felt >= std::clamp(0.9 - 1.5 * kDrawn / energy, 0.5, 0.8) * due - 3e-3);
    // It dies away.
    const double later = rms(beyond(played.all, played.law, played.all.size() - 50, 50));
    CHECK(later < felt);
  }
  CHECK(beyond_bound <= std::max<std::int64_t>(2, strokes / 50));
}

/// A finger that runs into a string at rest, and no deeper than where it would slip off.
HandPath run_into(const WaveScene& scene, double lambda, double speed) {
  const double reach = scene.reach();
  HandPath path({lambda, {reach + 10e-3, 0.3e-3}});
  path.go({lambda, {reach - std::min(0.75 * reach, 21e-3 * speed), 0.3e-3}}, speed);
  return path;
}

TEST_CASE("a finger that runs into a string at rest feels its mass") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t runs = scaled(300);
  for (std::int64_t i = 0; i < runs; ++i) {
    WaveScene scene;
    scene.tension = random.uniform(15.0, 80.0);
    scene.frequency = random.uniform(60.0, 200.0);
    scene.kt = random.uniform(400.0, 2000.0);
    const double lambda = random.uniform(0.1, 0.9);
    const double speed = random.uniform(0.05, 0.5);
    CAPTURE(scene.tension);
    CAPTURE(scene.frequency);
    CAPTURE(scene.kt);
    CAPTURE(lambda);
    CAPTURE(speed);
    const HandPath path = run_into(scene, lambda, speed);
    Instrument instrument = wave_instrument(scene);
    const FeltForces played = feel(instrument, path);
    const FeltForces truth = feel(scene, path, kCells);
    std::size_t first = 0;
    while (truth.all[first].x() == 0.0) ++first;
    const std::vector<Across> none(truth.all.size(), Across::Zero());
    const std::vector<double> felt = beyond(played.all, none, first, 20);
    const std::vector<double> due = beyond(at_end(truth.all, played.law), none, first, 20);
    CHECK(rms(felt) >= 0.9 * rms(due));
    CHECK(rms(felt) <= 1.1 * rms(due));
  }
}

}  // namespace
}  // namespace hapticd::test
