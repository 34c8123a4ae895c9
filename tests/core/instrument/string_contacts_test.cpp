// Strings under contacts, against finite differences of another method, statics, and their own
// energy.
#include "core/instrument/string_contacts.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"
#include "tests/truth/played_string.h"

namespace hapticd::test {
namespace {

constexpr int kSteps = kSubSteps;
constexpr StringLoss kLossless{1e18, 0.0};

StringConstants constants(double length, double tension, double frequency) {
  StringParameters string;
  string.p_WB = {length, 0.0, 0.0};
  string.tension = tension;
  string.frequency = frequency;
  return derive_string(string);
}

/// Displacement at the contact.
Transverse at(const ModeTable& table, const ModalMotion& motion, double lambda) {
  PerMode shapes{};
  mode_shapes(table, lambda, shapes);
  return displacement(table, motion, shapes);
}

/// Level of mode 1 after a pluck, m, and how far the string was bent.
std::array<double, 2> plucked(const StringConstants& string, const GridPluck& pluck) {
  const ModeTable table = mode_table(string, kLossless, 32);
  ModalMotion motion;
  StringContactPaths contacts;
  StringContactPath finger;
  finger.lambda_from = finger.lambda_to = pluck.lambda;
  finger.radius = pluck.finger.radius;
  finger.stiffness = pluck.finger.stiffness;
  finger.d_to = {-1.05 * finger.radius, pluck.height};
  contacts.push_back(finger);
  bool touched = false;
  double bent = 0.0;
  for (double y = finger.d_to.y; y < 0.1;) {
    StringContactPath& path = contacts[0];
    y += 1e-3 * pluck.speed;
    path.d_from = path.d_to;
    path.d_to.y = y;
    CHECK(play(string, table, kSteps, contacts, motion) <= 1);
    const Transverse u = at(table, motion, pluck.lambda);
    bent = std::max(bent, std::hypot(u.y, u.z));
    touched = touched || path.touched > 0;
    if (touched && y > u.y + bent + finger.radius) break;
  }
  return {
      std::hypot(std::hypot(motion.qy[0], motion.vy[0]), std::hypot(motion.qz[0], motion.vz[0])),
      bent};
}

void check_level(const GridString& string, const GridPluck& pluck_of) {
  CAPTURE(string.frequency);
  CAPTURE(pluck_of.lambda);
  CAPTURE(pluck_of.speed);
  const GridTone truth = pluck(string, pluck_of, 1100);
  const auto [level, bent] =
      plucked(constants(string.length, string.tension, string.frequency), pluck_of);
  // In decibels where it is heard; where the pluck leaves next to nothing, of what was bent.
  const bool heard = truth.amplitude > 0.2 * truth.deflection;
  if (heard) CHECK(std::abs(20.0 * std::log10(level / truth.amplitude)) <= 0.1);
  CHECK(std::abs(level - truth.amplitude) <= 0.005 * bent);
}

GridString lossless(double length, double tension, double frequency) {
  GridString string;
  string.length = length;
  string.tension = tension;
  string.frequency = frequency;
  string.loss = 0.0;
  string.loss_n2 = 0.0;
  return string;
}

TEST_CASE("plucks are as loud as finite differences find them, at every speed and place") {
  for (const double frequency : {65.4, 146.8}) {
    for (const double lambda : {0.1, 0.25, 0.5}) {
      for (const double speed : {0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5}) {
        check_level(lossless(1.1, 30.0, frequency),
                    {.lambda = lambda, .speed = speed, .height = 3e-3, .finger = {}});
      }
    }
  }
}

TEST_CASE("and so are plucks that nobody chose") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < scaled(100); ++i) {
    GridPluck pluck;
    pluck.lambda = random.uniform(0.05, 0.95);
    pluck.speed = random.uniform(0.2, 2.0);
    pluck.finger.radius = random.uniform(2e-3, 8e-3);
    pluck.height = pluck.finger.radius * random.uniform(0.3, 0.8);
    pluck.finger.stiffness = random.uniform(500.0, 3000.0);
    check_level(
        lossless(random.uniform(0.5, 1.3), random.uniform(20.0, 80.0), random.uniform(60.0, 250.0)),
        pluck);
  }
}

TEST_CASE("a finger that holds a string still bears the string in series with its flesh") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < 10; ++i) {
    const double length = random.uniform(0.3, 1.5);
    const double tension = random.uniform(10.0, 100.0);
    const StringConstants string = constants(length, tension, random.uniform(50.0, 300.0));
    const ModeTable table = mode_table(string, {0.02, 0.0}, 32);
    ModalMotion motion;
    StringContactPaths contacts;
    StringContactPath finger;
    finger.radius = 5e-3;
    finger.stiffness = random.uniform(500.0, 2e4);
    finger.lambda_from = finger.lambda_to = random.uniform(0.05, 0.95);
    const double depth = random.uniform(1e-3, 4.9e-3);
    finger.d_from = finger.d_to = {0.0, finger.radius - depth};
    contacts.push_back(finger);
    for (int tick = 0; tick < 1500; ++tick) play(string, table, kSteps, contacts, motion);
    const double lambda = finger.lambda_to;
    const double compliance = lambda * (1.0 - lambda) * length / tension;
    CHECK(-contacts[0].force.z == within(depth / (compliance + 1.0 / finger.stiffness), 1e-9));
    CHECK(std::abs(contacts[0].force.y) <= 1e-9);
  }
}

/// Fingers and boards that go at random about a string.
struct RandomPlay {
  RandomPlay(SplitMix64& of, bool loses) : random(of), lossy(loses) {
    string = constants(random.uniform(0.2, 2.0), std::pow(10.0, random.uniform(-1.0, 2.5)),
                       std::pow(10.0, random.uniform(1.3, 3.2)));
    table = mode_table(string, lossy ? StringLoss{} : kLossless, 32);
    const std::uint64_t count = 1 + random.below(4);
    for (std::uint64_t i = 0; i < count; ++i) add(random.chance(0.3));
  }

  void add(bool plane) {
    StringContactPath path;
    path.shape = plane ? StringContactShape::kPlane : StringContactShape::kRound;
    path.lambda_from = path.lambda_to = random.uniform(0.02, 0.98);
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    path.d_from = path.d_to = plane ? Transverse{0.0, -random.uniform(0.0, 5e-3)}
                                    : Transverse{8e-3 * std::cos(angle), 8e-3 * std::sin(angle)};
    path.radius = random.uniform(1e-3, 7e-3);
    path.stiffness = std::pow(10.0, random.uniform(2.0, 7.0));
    if (lossy) {
      path.damping = random.chance(0.5) ? random.uniform(0.0, 5.0) : 0.0;
      path.friction = random.uniform(0.0, 1.5);
    }
    contacts.push_back(path);
  }

  void tick() {
    for (StringContactPath& path : contacts) {
      path.d_from = path.d_to;
      path.lambda_from = path.lambda_to;
      if (path.shape == StringContactShape::kPlane) continue;
      path.d_to.y += random.uniform(-1.0, 1.0) * 1e-3;
      path.d_to.z += random.uniform(-1.0, 1.0) * 1e-3;
      const double slid = slides ? random.uniform(-5e-3, 5e-3) : 0.0;
      path.lambda_to = std::clamp(path.lambda_to + slid, 0.01, 0.99);
    }
    fallbacks += play(string, table, kSteps, contacts, motion);
    held = energy(table, motion);
    for (const StringContactPath& path : contacts) {
      put_in += path.work;
      held += path.stored;
    }
    most = std::max({most, held, std::abs(put_in)});
  }

  SplitMix64& random;
  bool lossy;
  bool slides = random.chance(0.5);
  StringConstants string;
  ModeTable table;
  ModalMotion motion;
  StringContactPaths contacts;
  double held = 0.0, put_in = 0.0, most = 0.0;
  int fallbacks = 0;
};

/// What forces that are solved to 1 pN may work on a tick's way of a millimetre, J.
constexpr double kSolved = 1e-15;

TEST_CASE("what the paths put in is in string and contacts, and losses only take") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  // Friction between contacts that lie close together may have no answer that sweeps find; what
  // falls back does so for many sub-steps of few scenes.
  const std::int64_t scenes = scaled(4000);
  std::int64_t fell_back = 0;
  for (std::int64_t scene = 0; scene < scenes; ++scene) {
    CAPTURE(scene);
    RandomPlay play(random, scene % 2 == 1);
    for (int tick = 0; tick < 200; ++tick) {
      play.tick();
      REQUIRE(std::isfinite(play.held));
      const double gained = play.held - play.put_in;
      REQUIRE(gained <= 1e-9 * play.most + kSolved);
      // Tangent planes lose, too.
      if (!play.lossy && play.fallbacks == 0) REQUIRE(gained >= -1e-9 * play.most - kSolved);
    }
    fell_back += play.fallbacks > 0 ? 1 : 0;
  }
  CHECK(fell_back <= 2 + scenes / 50);
}

TEST_CASE("friction is within its cone, sub-step means of a tick included") {
  const StringConstants string = constants(1.1, 30.0, 65.4);
  const ModeTable table = mode_table(string, {}, 32);
  ModalMotion motion;
  StringContactPaths contacts;
  StringContactPath board;
  board.shape = StringContactShape::kPlane;
  board.lambda_from = board.lambda_to = 0.4;
  board.friction = 0.5;
  board.stiffness = 1e5;
  contacts.push_back(board);
  bool slipped = false;
  for (int tick = 0; tick < 400; ++tick) {
    // Comes up under the string, then goes aside.
    const double up = 2e-3 * std::min(1.0, tick / 100.0);
    contacts[0].d_from = contacts[0].d_to;
    contacts[0].d_to = {tick < 200 ? 0.0 : 1e-4 * (tick - 200), up};
    play(string, table, kSteps, contacts, motion);
    const Transverse force = contacts[0].force;
    CHECK(std::abs(force.y) <= 0.5 * force.z * (1.0 + 1e-9) + 1e-12);
    slipped = slipped || (force.z > 0.01 && std::abs(force.y) >= 0.499 * force.z);
  }
  CHECK(slipped);
}

TEST_CASE("numbers at the ends of their ranges leave the string finite") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  constexpr std::array kStiffness{1e-3, 1e3, 1e12};
  constexpr std::array kLambda{0.0, 1e-9, 0.5, 1.0};
  constexpr std::array kRadius{1e-6, 5e-3, 1.0};
  for (int scene = 0; scene < scaled(300); ++scene) {
    const StringConstants string = constants(std::pow(10.0, random.uniform(-2.0, 7.0)),
                                             std::pow(10.0, random.uniform(-6.0, 6.0)),
                                             std::pow(10.0, random.uniform(-2.0, 3.3)));
    const ModeTable table = mode_table(string, {}, kMaxModes);
    ModalMotion motion;
    StringContactPaths contacts;
    for (int i = 0; i < 2; ++i) {
      StringContactPath path;
      path.stiffness = kStiffness[random.below(kStiffness.size())];
      path.lambda_from = kLambda[random.below(kLambda.size())];
      path.lambda_to = kLambda[random.below(kLambda.size())];
      path.radius = kRadius[random.below(kRadius.size())];
      path.friction = 10.0;
      contacts.push_back(path);
    }
    for (int tick = 0; tick < 20; ++tick) {
      // On the string's own axis, too.
      for (StringContactPath& path : contacts) {
        path.d_from = path.d_to;
        path.d_to = {random.chance(0.3) ? 0.0 : random.uniform(-0.1, 0.1), 0.0};
        path.lambda_from = path.lambda_to;
      }
      play(string, table, kSteps, contacts, motion);
      REQUIRE(std::isfinite(energy(table, motion)));
      for (const StringContactPath& path : contacts) REQUIRE(std::isfinite(path.force.y));
    }
  }
}

}  // namespace
}  // namespace hapticd::test
