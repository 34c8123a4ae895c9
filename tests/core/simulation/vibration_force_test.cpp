// What a vibrating string does to the hand, in random play and against a hand that moves as badly
// as a held device can: it never attracts, and it never gives more than it was given.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/math/elementary.h"
#include "tests/core/simulation/force_watch.h"
#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Rounding of a sum of forces, N.
constexpr double kForceRounding = 1e-10;

/// The wrench is of the normals where the last program was solved, not of where the tool stands: by
/// how much the step between turns them where it was the last one wanted, and where it was cut
/// short, rad. A touched string also drags sideways, which so turned seems to attract.
constexpr double kLastTurn = 1e-3;
constexpr double kCutTurn = 3e-2;

double wave(double turns) { return sin_cos(2.0 * kPi * (turns - std::floor(turns))).sin; }

/// Where a hand that plays goes next: around one of the strings.
Vector3 random_place(SplitMix64& random, int strings) {
  const double z = 0.02 * random.uniform(-0.5, strings - 0.5);
  return {random.uniform(0.05, 1.05), random.uniform(-6e-3, 9e-3), z};
}

/// 0.05 to 2 m/s.
double random_speed(SplitMix64& random) { return 0.05 * std::pow(40.0, random.uniform()); }

/// From the nearest point of a string, bent as it is, to the centre of the finger.
Vector3 true_normal(const Instrument& guqin, int string, const Vector3& p_WC, const Vector3& u_W,
                    double lambda) {
  const Capsule& capsule = guqin.capsules_W[static_cast<std::size_t>(string)];
  const Vector3 p_P = capsule.p_A + lambda * (capsule.p_B - capsule.p_A) + u_W;
  Vector3 nearest(1e3, 0.0, 0.0);
  for (const auto& [a, b] : {std::pair(capsule.p_A, p_P), std::pair(p_P, capsule.p_B)}) {
    const double share = std::clamp((p_WC - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    const Vector3 offset = p_WC - (a + share * (b - a));
    if (offset.norm() < nearest.norm()) nearest = offset;
  }
  return nearest.normalized();
}

}  // namespace

TEST_CASE("in random play no string ever attracts the finger") {
  std::int64_t vibrating_ticks = 0;
  double strongest = 0.0;
  const std::vector<Preset> presets = all_presets();
  for (std::int64_t i = scaled(200); i > 0; --i) {
    const Preset& preset = presets[static_cast<std::size_t>(i) % presets.size()];
    SplitMix64 random(static_cast<std::uint64_t>(i));
    const int strings = 1 + static_cast<int>(random.below(7));
    Instrument guqin(strings, preset.string, preset.options);
    CAPTURE(std::string(preset.name));
    guqin.tick({0.5, 0.02, 0.0});
    bool attracts = false;
    for (int move = 0; move < 40; ++move) {
      const double speed = random_speed(random);
      guqin.glide(random_place(random, strings), speed, [&](const SimulationTick& output) {
        for (const StringTick& reading : output.strings()) {
          attracts = attracts || guqin.normal_force(reading.string) < -kForceRounding ||
                     (!reading.touched && reading.vibration_force != 0.0);
          if (reading.vibration_force != 0.0) ++vibrating_ticks;
          strongest = std::max(strongest, std::abs(reading.vibration_force));
        }
      });
    }
    CHECK_FALSE(attracts);
  }
  CHECK(vibrating_ticks > 100);
  MESSAGE(vibrating_ticks << " ticks with a vibration force of up to " << strongest << " N");
}

TEST_CASE("the wrench of a single string points away from it in every tick of random play") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  const std::vector<Preset> presets = all_presets();
  for (std::int64_t i = scaled(200); i > 0; --i) {
    const Preset& preset = presets[static_cast<std::size_t>(i) % presets.size()];
    if (preset.options.friction) continue;
    SplitMix64 random(seed + static_cast<std::uint64_t>(i));
    Instrument guqin(1, preset.string, preset.options);
    CAPTURE(std::string(preset.name));
    guqin.tick({0.5, 0.02, 0.0});
    double worst = 0.0;
    for (int move = 0; move < 40; ++move) {
      const double speed = random_speed(random);
      guqin.glide(random_place(random, 1), speed, [&](const SimulationTick& output) {
        Vector3 u_W = Vector3::Zero();
        double lambda = 0.5;
        for (const TouchedString& hold :
             guqin.simulation().memory().tools[0].state.contact.touched) {
          u_W = hold.bend.u_W;
          lambda = hold.bend.lambda;
        }
        const Vector3 n = true_normal(guqin, 0, output.tool(0).X_WG.p, u_W, lambda);
        const Vector3& f_W = output.tool(0).F_computed_H_W.f;
        const bool arrived = output.tool(0).contact.status == ContactStatus::kConverged;
        const double turn = arrived ? kLastTurn : kCutTurn;
        worst = std::min(worst, f_W.dot(n) + turn * f_W.norm());
      });
    }
    CHECK(worst >= -kForceRounding);
  }
}

TEST_CASE("every touch ends once, every armed one is a release, and no release sounds twice") {
  const std::vector<Preset> presets = all_presets();
  for (std::int64_t i = scaled(200); i > 0; --i) {
    const Preset& preset = presets[static_cast<std::size_t>(i) % presets.size()];
    SplitMix64 random(static_cast<std::uint64_t>(i) + 2000);
    const int strings = 1 + static_cast<int>(random.below(7));
    Instrument guqin(strings, preset.string, preset.options);
    CAPTURE(std::string(preset.name));
    guqin.tick({0.5, 0.02, 0.0});
    for (int move = 0; move < 40; ++move) {
      guqin.glide(random_place(random, strings), random_speed(random),
                  [](const SimulationTick&) {});
    }
    guqin.glide({0.5, 0.1, 0.0}, 0.5, [](const SimulationTick&) {});
    CHECK(count(guqin.events, StringEventKind::kTouch) > 0);
    CHECK(count(guqin.events, StringEventKind::kTouch) ==
          count(guqin.events, StringEventKind::kLeave) +
              count(guqin.events, StringEventKind::kRelease));
    CHECK(count(guqin.events, StringEventKind::kPress) ==
          count(guqin.events, StringEventKind::kRelease));
    CHECK(count(guqin.events, StringEventKind::kTone) <=
          count(guqin.events, StringEventKind::kRelease));
  }
}

namespace {

/// A hand that moves at the string's frequency on the string, in `direction`.
struct Adversary {
  double amplitude;    ///< m
  double depth;        ///< of the middle of its motion below the felt surface, m
  double turns;        ///< phase
  Vector3 direction;   ///< unit
  double pluck_speed;  ///< of the pluck before, m/s
};

/// The most that the whole force has given to the hand, over the largest energy that the string was
/// bent with until then, at once and once more per 100 ms, and 50 uJ: the hand may pluck it anew in
/// every swing. The energy is that of the string's law for the hand's way; the contact's own force
/// stores what it takes, but for what a force that is held for a tick gives away, which is the
/// device loop's and is known exactly.
double energy_ratio(const Preset& preset, const Adversary& adversary) {
  Instrument guqin(1, preset.string, preset.options);
  StringParameters string = preset.string;
  string.p_WA = to_array(guqin.capsules_W[0].p_A);
  string.p_WB = to_array(guqin.capsules_W[0].p_B);
  double bent = 0.0;
  constexpr double kPlace = 0.33;
  Vector3 before(kPlace, -2e-3, -6e-3);
  const auto look = [&](const SimulationTick&) {
    before = guqin.p_WH;
    bent = std::max(bent, static_press(string, before).energy);
  };
  guqin.tick(before);
  guqin.glide({kPlace, -2e-3, 20e-3}, adversary.pluck_speed, look);
  const double clear = felt_distance(guqin) + adversary.amplitude + 10e-3;
  guqin.glide({kPlace, clear, 20e-3}, 1.0, look);
  guqin.glide({kPlace, clear, 0.0}, 1.0, look);
  const double middle = felt_distance(guqin) - adversary.depth;
  double given = 0.0;
  double most = 0.0;
  Vector3 held = Vector3::Zero();
  for (int k = 1; k < 1500; ++k) {
    // The motion itself, carried down to the string evenly in jerk.
    const double t = 1e-3 * k;
    const double s = std::min(1.0, k / 100.0);
    const double down = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    Vector3 p = adversary.amplitude * wave(preset.string.frequency * t + adversary.turns) *
                adversary.direction;
    p += Vector3(kPlace, clear + down * (middle - clear), 0.0);
    const StaticPress from = static_press(string, before);
    const StaticPress to = static_press(string, p);
    const Vector3 way = p - before;
    const double leaked = from.f_H_W.dot(way) - (from.energy - to.energy);
    const SimulationTick& output = guqin.tick(p);
    given += held.dot(way) - leaked;
    bent = std::max(bent, to.energy);
    most = std::max(most, given / (bent * (1.0 + 10.0 * t) + 50e-6));
    before = p;
    held = output.tool(0).F_computed_H_W.f;
  }
  return most;
}

}  // namespace

TEST_CASE("a hand that moves in phase with the string draws at most its energy per 100 ms") {
  double most = 0.0;
  for (Preset preset : all_presets()) {
    // Waves take more from a fast pluck than bends them: wave_passivity_test.cpp.
    if (preset.options.friction || sounds(preset)) continue;
    for (std::int64_t i = scaled(2000); i > 0; --i) {
      SplitMix64 random(static_cast<std::uint64_t>(i));
      Adversary adversary;
      adversary.amplitude = 1e-5 * std::pow(1000.0, random.uniform());
      // It stays on its side of the string: who lets it slip off has put in what it rings with.
      constexpr double kDeepest = 4.5e-3;
      adversary.depth = std::min(random.uniform(-1.0, 1.5) * (adversary.amplitude + 0.5e-3),
                                 kDeepest - adversary.amplitude);
      adversary.turns = random.uniform();
      const double lean = random.chance(0.5) ? 0.0 : random.uniform(-1.5, 1.5);
      adversary.pluck_speed = random.uniform(0.1, 2.0);
      adversary.direction = {0.0, std::cos(lean), std::sin(lean)};
      // The string is tuned so low that the hand stays below the acceleration of a held device.
      const double highest =
          std::sqrt(0.9 * preset.options.max_acceleration / adversary.amplitude) / (2.0 * kPi);
      preset.string.frequency = std::min(random.uniform(30.0, 300.0), highest);
      const double ratio = energy_ratio(preset, adversary);
      most = std::max(most, ratio);
      CAPTURE(std::string(preset.name));
      CAPTURE(adversary.amplitude);
      CAPTURE(preset.string.frequency);
      CAPTURE(lean);
      CHECK(ratio <= 1.001);
    }
  }
  MESSAGE("most that was drawn: " << most << " of the energy released");
}

}  // namespace hapticd::test
