// Strings over frets and boards. Truths: the shortest way by a convex hull and the least energy by
// search, the closed form of a part's pitch, and what no finger may do to a string over a fret.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "tests/core/simulation/fretted_string.h"
#include "tests/core/simulation/wave_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Less force than this of a finger that pressed a string on a fret: the string has slipped off it,
/// N.
constexpr double kHeld = 1.0;

/// Of a string that a finger presses beside a fret, and of the surface on top of it, at most, rad:
/// half of the force over the tension, and what the string goes down on its length.
constexpr double kSteepest = 0.035;

double cents(double a, double b) { return 1200.0 * std::log2(a / b); }

std::vector<FretTop> some_frets(SplitMix64& random, double length) {
  std::vector<FretTop> frets;
  const std::uint64_t count = 1 + random.below(4);
  frets.reserve(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    frets.push_back({random.uniform(0.1, 0.9) * length, random.uniform(0.1e-3, 3e-3)});
  }
  return frets;
}

FrettedOptions some_string(SplitMix64& random) {
  FrettedOptions options;
  options.length = random.uniform(0.4, 1.2);
  options.tension = random.uniform(30.0, 100.0);
  options.axial_stiffness = std::pow(10.0, random.uniform(2.0, 4.5));
  options.frets = some_frets(random, options.length);
  return options;
}

double nearest_fret(const FrettedOptions& options, double x) {
  double nearest = options.length;
  for (const FretTop& fret : options.frets) nearest = std::min(nearest, std::abs(fret.x - x));
  return nearest;
}

/// A finger that goes from place to place about the string, evenly.
class Wanderer {
 public:
  Wanderer(SplitMix64& random, const FrettedOptions& options, double reach, double speed)
      : random_(random), options_(options), reach_(reach), speed_(speed) {
    to_ = p = {0.5 * options.length, reach + 5e-3, 0.0};
  }
  /// Between places along the string, as shares of its length.
  void stay_within(double from, double to) {
    from_ = from;
    most_ = to;
    to_.x() = p.x() = 0.5 * (from + to) * options_.length;
  }
  void step() {
    if ((to_ - p).norm() < 1e-3 * speed_) {
      const double x = std::clamp(p.x() + random_.uniform(-0.08, 0.08), from_ * options_.length,
                                  most_ * options_.length);
      // No deeper than where it would slip off the string.
      to_ = {x, reach_ - random_.uniform(-2e-3, 3e-3), 0.0};
    }
    const Vector3 way = to_ - p;
    p += way * std::min(1.0, 1e-3 * speed_ / std::max(way.norm(), 1e-12));
  }
  Vector3 p;

 private:
  SplitMix64& random_;
  const FrettedOptions& options_;
  double reach_;
  double speed_;
  double from_ = 0.1;
  double most_ = 0.9;
  Vector3 to_;
};

/// The frequency of the last tone that a finger plucks while another one holds the string at x, Hz;
/// 0: there was none, or the string has slipped off the finger.
double stopped_tone(const FrettedOptions& options, double x, double depth, double plucked_at) {
  FrettedString string(options);
  const double reach = string.reach();
  double frequency = 0.0;
  for (int tick = 0; tick < 1200; ++tick) {
    const double down = reach + 5e-3 - (depth + 5e-3) * std::min(1.0, tick / 300.0);
    const double across = std::clamp((tick - 700) / 300.0, 0.0, 1.0);
    const Vector3 pluck(plucked_at, tick < 600 ? 0.05 : 3e-3, -0.03 + 0.06 * across);
    for (const StringEvent& event : string.tick({{x, down, 0.0}, pluck}).events()) {
      if (event.kind == StringEventKind::kTone && tick > 700) frequency = event.frequency;
    }
  }
  return string.force(0).y() > kHeld ? frequency : 0.0;
}

/// A finger that presses a string beside a fret, and rubs along it to the other side.
struct Glide {
  double from = 0.0;   ///< m
  double to = 0.0;     ///< m
  double depth = 0.0;  ///< of the hand, below the string at rest, m
  double speed = 0.0;  ///< m/s
};

/// Called with the ticks of the glide: the way gone, m, the force before and now, N.
template <typename Visit>
void glide(const Glide& way, FrettedString& string, const Visit& visit) {
  const auto hand = [&](double x, double down) {
    return std::vector<Vector3>{{x, string.reach() - down, 0.0}};
  };
  for (int tick = 0; tick < 300; ++tick) {
    string.tick(hand(way.from, way.depth * std::min(1.0, tick / 200.0)));
  }
  const double step = 1e-3 * way.speed;
  const double length = std::abs(way.to - way.from);
  for (double gone = step; gone < length; gone += step) {
    const Vector3 before = string.force();
    string.tick(hand(way.from + std::copysign(gone, way.to - way.from), way.depth));
    visit(gone, before, string.force());
  }
}

}  // namespace

TEST_CASE("a string pressed over frets is as stiff as the shortest way over them") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int scene = 0; scene < scaled(300); ++scene) {
    const FrettedOptions options = some_string(random);
    const double x = random.uniform(0.1, 0.9) * options.length;
    // On top of a fret the finger's size counts.
    if (nearest_fret(options, x) < 12e-3) continue;
    CAPTURE(scene);
    CAPTURE(x);
    FrettedString string(options);
    const double depth = random.uniform(0.5e-3, 3.5e-3);
    for (int tick = 0; tick < 250; ++tick) {
      const double down = depth * std::min(1.0, tick / 200.0);
      string.tick({{x, string.reach() - down, 0.0}});
    }
    const double force = pressed_force(options, x, depth, 1000.0);
    CHECK(string.force().y() == within(force, 0.02));
    CHECK(string.sunk() <= 1e-6);
  }
}

TEST_CASE("a finger that wanders over frets is never thrown, and no string goes through one") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int scene = 0; scene < scaled(200); ++scene) {
    CAPTURE(scene);
    FrettedOptions options = some_string(random);
    options.sounds = random.chance(0.5);
    FrettedString string(options);
    const double speed = random.uniform(0.02, 0.3);
    Wanderer finger(random, options, string.reach(), speed);
    Vector3 before = Vector3::Zero();
    for (int tick = 0; tick < 1500; ++tick) {
      CAPTURE(tick);
      finger.step();
      string.tick({finger.p});
      REQUIRE_FALSE(string.recovers());
      REQUIRE(string.sunk() <= 10e-6);
      const double step = (string.force() - before).norm();
      // What the springs give for the way of a tick, and the same again at a fret.
      if (!options.sounds) REQUIRE(step <= 2.0 * speed + 0.15);
      before = string.force();
    }
  }
}

TEST_CASE("fingers that wander over frets together do not throw each other") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int scene = 0; scene < scaled(100); ++scene) {
    CAPTURE(scene);
    FrettedOptions options = some_string(random);
    options.fingers = 2 + random.below(2);
    options.sounds = random.chance(0.5);
    FrettedString string(options);
    std::vector<Wanderer> fingers;
    fingers.reserve(options.fingers);
    for (std::size_t k = 0; k < options.fingers; ++k) {
      fingers.emplace_back(random, options, string.reach(), random.uniform(0.02, 0.2));
      const double share = 0.8 / static_cast<double>(options.fingers);
      const double from = 0.1 + share * static_cast<double>(k);
      fingers.back().stay_within(from, from + share - 0.04);
    }
    for (int tick = 0; tick < 1500; ++tick) {
      CAPTURE(tick);
      std::vector<Vector3> hands;
      hands.reserve(fingers.size());
      for (Wanderer& finger : fingers) {
        finger.step();
        hands.push_back(finger.p);
      }
      string.tick(hands);
      REQUIRE(string.sunk() <= 10e-6);
      for (std::size_t k = 0; k < options.fingers; ++k) REQUIRE_FALSE(string.recovers(k));
    }
  }
}

TEST_CASE("a finger that rubs along a string rubs over its frets alike") {
  // Not of the run: in one of some 200 passes the anchor is lost all the same (model.md).
  SplitMix64 random(9491318434688699545U);
  for (int scene = 0; scene < 40; ++scene) {
    CAPTURE(scene);
    FrettedOptions options;
    options.friction = scene % 2 == 0 ? 0.3 : 0.8;
    const double fret = random.uniform(0.35, 0.65) * options.length;
    options.frets = {{fret, random.uniform(0.5e-3, 2e-3)}};
    FrettedString string(options);
    Glide way{fret - 0.03, fret + 0.03, options.frets[0].below + random.uniform(1e-3, 2.5e-3),
              random.uniform(0.02, 0.1)};
    if (random.chance(0.5)) std::swap(way.from, way.to);
    const double friction_angle = std::atan(options.friction);
    const double against = way.to > way.from ? -1.0 : 1.0;
    glide(way, string, [&](double gone, const Vector3& before, const Vector3& force) {
      CAPTURE(gone);
      // The hand's own way at the stiffness of the coupling, 1 N per mm, and what that changes of
      // the friction.
      REQUIRE((force - before).norm() <= (1.0 + options.friction) * way.speed + 0.02);
      const double angle = std::atan2(against * force.x(), force.y());
      REQUIRE(angle <= friction_angle + kSteepest);
      // It sticks until the coupling is stretched by mu N.
      if (gone > 6e-3) REQUIRE(angle >= friction_angle - kSteepest);
    });
  }
}

TEST_CASE("a string stopped behind a fret sounds as the part from the fret") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  int heard = 0;
  const std::int64_t scenes = std::max<std::int64_t>(4, scaled(60));
  for (int scene = 0; scene < scenes; ++scene) {
    CAPTURE(scene);
    FrettedOptions options;
    options.fingers = 2;
    options.sounds = true;
    options.friction = 0.8;
    options.axial_stiffness = random.chance(0.5) ? 0.0 : random.uniform(1e3, 1e4);
    const double fret = random.uniform(0.3, 0.7) * options.length;
    // Lower down, the pluck lifts the string off the fret.
    options.frets = {{fret, random.uniform(2e-3, 2.8e-3)}};
    const double x = fret + random.uniform(15e-3, 40e-3);
    const double depth = options.frets[0].below + random.uniform(3e-3, 4.5e-3);
    const double tone = stopped_tone(options, x, depth, random.uniform(0.15, 0.3) * fret);
    if (tone == 0.0) continue;
    ++heard;
    // As it is stretched over the fret: by how far the finger is in is told by its force.
    FrettedString held(options);
    const double force = pressed_force(options, x, depth, 1000.0);
    const double extension = way_over(options, x, depth - force / 1000.0) - options.length;
    const double tension = options.tension + options.axial_stiffness * extension / options.length;
    const double expected =
        options.frequency * options.length / fret * std::sqrt(tension / options.tension);
    CHECK(std::abs(cents(tone, expected)) <= 5.0);
  }
  CHECK(heard >= scenes / 2);
}

TEST_CASE("a string stopped on a board sounds from the finger") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  int heard = 0;
  const std::int64_t scenes = std::max<std::int64_t>(4, scaled(40));
  for (int scene = 0; scene < scenes; ++scene) {
    CAPTURE(scene);
    FrettedOptions options;
    options.fingers = 2;
    options.sounds = true;
    options.friction = 0.3;
    options.axial_stiffness = 0.0;
    options.board_below = random.uniform(1.5e-3, 3e-3);
    const double x = random.uniform(0.35, 0.75) * options.length;
    const double depth = options.board_below + random.uniform(1e-3, 3e-3);
    const double tone = stopped_tone(options, x, depth, random.uniform(0.15, 0.25) * x);
    if (tone == 0.0) continue;
    ++heard;
    CHECK(std::abs(cents(tone, options.frequency * options.length / x)) <= 5.0);
  }
  CHECK(heard >= scenes / 2);
}

TEST_CASE("a string that swings into a fret buzzes") {
  const auto high_share = [](double below) {
    FrettedOptions options;
    options.sounds = true;
    options.frets = {{0.5 * 0.648, below}};
    FrettedString string(options);
    // Up and off: it swings in the plane of the fret.
    for (int tick = 0; tick < 700; ++tick) {
      const double up = -string.reach() + 2e-3 * std::min(1.0, tick / 200.0);
      string.tick({{0.2, tick < 300 ? up : up - 0.4 * std::min(1.0, (tick - 300) / 50.0), 0.0}});
    }
    const WaveMemory& wave = string.simulation().memory().waves[0];
    const ModalMotion& motion = wave.state.string.motion;
    double all = 0.0;
    double high = 0.0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(wave.table.modes.count); ++k) {
      const double of = wave.table.modes.stiffness[k] *
                        (motion.qy[k] * motion.qy[k] + motion.vy[k] * motion.vy[k]);
      all += of;
      if (k >= 6) high += of;
    }
    return high / all;
  };
  CHECK(high_share(0.3e-3) > 2.0 * high_share(10e-3));
}

}  // namespace hapticd::test
