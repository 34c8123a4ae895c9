// Coulomb friction between tool and strings: it sticks up to mu N, slips with mu N, lets go with
// the contact, never pulls, and no closed motion of the hand gains energy by it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Share of mu N that friction may be off: it stands across the true normal, the force of a bent
/// string leans from it by the slope of its legs.
constexpr double kFrictionError = 0.01;

/// What the trapezoid rule may add to the work of a loop, as a share of all that moved.
constexpr double kTrapezoidError = 2e-5;

StringParameters rough_string(double mu, StringContact model) {
  StringParameters string = string_at();
  string.friction_coefficient = mu;
  string.model = model;
  return string;
}

RenderingScene rough_scene(const StringParameters& string, double anchor_stiffness) {
  RenderingScene scene = scene_of({string});
  scene.instrument.friction = true;
  scene.instrument.anchor_stiffness = anchor_stiffness;
  return scene;
}

/// Force of one string, split by the direction of its contact force.
struct Split {
  double normal;
  double tangential;
};

Split split(const PressedString& contact) {
  const double normal = contact.F_W.dot(contact.nhat_W);
  return {normal, (contact.F_W - normal * contact.nhat_W).norm()};
}

/// Energy the hand got over a motion, by the trapezoid rule, J, and all that went either way.
struct HandWork {
  double gained = 0.0;
  double moved = 0.0;
  Vector3 f_before{0.0, 0.0, 0.0};
  Vector3 p_before{0.0, 0.0, 0.0};

  void add(const Vector3& f, const Vector3& p) {
    const double work = 0.5 * (f + f_before).dot(p - p_before);
    gained += work;
    moved += std::abs(work);
    f_before = f;
    p_before = p;
  }
};

struct Loop {
  StringParameters string = string_at();
  InstrumentOptions instrument;
  std::vector<Vector3> corners_W;  ///< first and last are the same and free of contact
};

/// Corners near and in a string anywhere between its ends.
Loop random_loop(std::uint64_t seed) {
  SplitMix64 random(seed);
  Loop loop;
  loop.string.model = random.chance(0.5) ? StringContact::kStraight : StringContact::kYielding;
  loop.string.tension = 5.0 * std::pow(60.0, random.uniform());
  loop.string.youngs_modulus = random.chance(0.3) ? 0.0 : 1.9e11;
  loop.string.contact_stiffness = random.chance(0.5) ? 1000.0 : 400.0;
  loop.instrument.friction = true;
  // Without the lateral force a string gives what it gains while a finger glides along it, up to
  // the slope of its halves, 0.04 here: friction has to be more.
  loop.instrument.lateral_force = random.chance(0.5);
  loop.string.friction_coefficient = loop.instrument.lateral_force
                                         ? 1.5 * std::pow(500.0, -random.uniform())
                                         : random.uniform(0.1, 1.5);
  loop.instrument.anchor_stiffness = 300.0 * std::pow(30.0, random.uniform());
  const double s = kTipRadius + loop.string.radius;
  const double x = random.uniform(0.1, 1.0);
  const double depth = random.uniform(0.5e-3, 4e-3);
  const double width = random.uniform(1e-3, 20e-3);
  loop.corners_W.emplace_back(x, s + 1e-3, 0.0);
  const auto corners = 3 + random.below(6);
  for (std::uint64_t i = 0; i < corners; ++i) {
    const double dx = random.uniform(-width, width);
    const double y = s - random.uniform(0.05, 1.0) * depth;
    loop.corners_W.emplace_back(x + dx, y, random.uniform(-1.5e-3, 1.5e-3));
  }
  loop.corners_W.emplace_back(x + random.uniform(-width, width), s + 1e-3, 0.0);
  loop.corners_W.push_back(loop.corners_W.front());
  return loop;
}

/// Plays the loop once, 20 um per tick.
HandWork play(const Loop& loop, std::int64_t& ticks) {
  constexpr double kStep = 20e-6;
  RenderingScene scene = scene_of({loop.string});
  scene.instrument = loop.instrument;
  ToolRun run(scene, pose_at(loop.corners_W.front()));
  HandWork work;
  work.p_before = loop.corners_W.front();
  for (std::size_t k = 1; k < loop.corners_W.size(); ++k) {
    const Vector3& from = loop.corners_W[k - 1];
    const Vector3& to = loop.corners_W[k];
    const int count = 1 + static_cast<int>((to - from).norm() / kStep);
    glide(run, from, to, count, [&](const Vector3& p_WH) {
      const StringTick tick = rendered(run);
      for (const PressedString& contact : tick.strings) CHECK(split(contact).normal >= 0.0);
      work.add(tick.F_H_W.f, p_WH);
      ++ticks;
    });
  }
  return work;
}

/// Ticks of a sideways slide of the hand at a constant depth.
struct Slide {
  int slipping = 0;  ///< the tool followed the hand over the string
  int sticking = 0;  ///< friction stayed below mu N
};

/// Presses 3 mm deep, moves the hand by `way`, 10 um per tick, and judges friction in every tick.
Slide slide(const RenderingScene& scene, double mu, const Vector3& way) {
  ToolRun run(scene, pose_at({0.55, 0.02, 0.0}));
  const double s = rest_distance(0.34e-3);
  const Vector3 pressed(0.55, s - 3e-3, 0.0);
  glide(run, {0.55, s + 1e-3, 0.0}, pressed, 100);
  run.hold(pose_at(pressed), 20);
  Slide slide;
  double x_before = run.state.X_WG.p.x();
  glide(run, pressed, pressed + way, 600, [&](const Vector3& /*p_WH*/) {
    const StringTick tick = rendered(run);
    if (tick.strings.empty()) return;
    const Split force = split(tick.strings[0]);
    const double limit = mu * force.normal;
    CHECK(force.tangential <= limit * (1.0 + kFrictionError) + 1e-9);
    const bool follows = run.state.X_WG.p.x() - x_before > 9e-6;
    x_before = run.state.X_WG.p.x();
    if (follows) CHECK(force.tangential >= limit * (1.0 - kFrictionError));
    slide.slipping += follows ? 1 : 0;
    slide.sticking += force.tangential < limit * (1.0 - kFrictionError) ? 1 : 0;
  });
  return slide;
}

/// Five laps of the loop that would draw on a spring which stiffens with the press: aside while the
/// press is light, back while it is firm. A first lap, not counted, brings the string into it.
HandWork play_laps(StringParameters string, double x, const Vector3& aside) {
  string.tension = 1.0;
  RenderingScene scene = rough_scene(string, 1000.0);
  scene.instrument.lateral_force = true;
  ToolRun run(scene, pose_at({x, 0.02, 0.0}));
  const double s = rest_distance(string.radius);
  const Vector3 light(x, s - 1e-3, 0.0);
  const Vector3 firm(x, s - 4e-3, 0.0);
  const std::vector<Vector3> corners{light, light + aside, firm + aside, firm, light};
  glide(run, {x, s + 1e-3, 0.0}, light, 100);
  HandWork work;
  work.p_before = light;
  work.f_before = rendered(run).F_H_W.f;
  for (int lap = 0; lap < 6; ++lap) {
    for (std::size_t k = 1; k < corners.size(); ++k) {
      glide(run, corners[k - 1], corners[k], 150,
            [&](const Vector3& p_WH) { work.add(rendered(run).F_H_W.f, p_WH); });
    }
    if (lap == 0) work.gained = work.moved = 0.0;
  }
  return work;
}

}  // namespace

TEST_CASE("friction sticks up to mu N and slips with mu N, along the string and across it") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    for (const double mu : {0.1, 0.3, 1.0}) {
      for (const double anchor : {300.0, 1000.0, 1e4}) {
        CAPTURE(static_cast<int>(model));
        CAPTURE(mu);
        CAPTURE(anchor);
        const RenderingScene scene = rough_scene(rough_string(mu, model), anchor);
        const Slide along = slide(scene, mu, {6e-3, 0.0, 0.0});
        CHECK(along.sticking > 2);
        if (mu < 1.0) CHECK(along.slipping > 50);
        CHECK(slide(scene, mu, {0.0, 0.0, 6e-3}).sticking > 2);
      }
    }
  }
}

TEST_CASE("what breaks a finger away along a string is mu N, approached and not exceeded") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    for (const double mu : {0.05, 0.2, 0.5}) {
      CAPTURE(static_cast<int>(model));
      CAPTURE(mu);
      const RenderingScene scene = rough_scene(rough_string(mu, model), 2000.0);
      ToolRun run(scene, pose_at({0.4, 0.02, 0.0}));
      const double s = rest_distance(0.34e-3);
      glide(run, {0.4, s + 1e-3, 0.0}, {0.4, s - 3e-3, 0.0}, 100);
      double greatest = 0.0;
      glide(run, {0.4, s - 3e-3, 0.0}, {0.402, s - 3e-3, 0.0}, 400, [&](const Vector3& /*p_WH*/) {
        const Vector3 f = rendered(run).F_H_W.f;
        greatest = std::max(greatest, -f.x() / f.y());
      });
      // Where a tick of the glide adds a fifth of mu N, the tick of the slip may be short of it.
      CHECK(greatest == within(mu, mu < 0.1 ? 3.0 * kFrictionError : kFrictionError));
    }
  }
}

TEST_CASE(
    "with friction a finger holds a string at newtons where without it slips off at half one") {
  const auto greatest_force = [](bool friction, double mu) {
    RenderingScene scene = rough_scene(rough_string(mu, StringContact::kYielding), 1000.0);
    scene.instrument.friction = friction;
    ToolRun run(scene, pose_at({0.55, 0.02, 0.5e-3}));
    const double s = rest_distance(0.34e-3);
    double greatest = 0.0;
    glide(run, {0.55, s + 1e-3, 0.5e-3}, {0.55, s - 20e-3, 0.5e-3}, 1000,
          [&](const Vector3&) { greatest = std::max(greatest, run.result.F_H_W.f.norm()); });
    return greatest;
  };
  // Without: until F = k0 (r + R) = 4 T / L times 5.34 mm, 0.58 N, less for the offset.
  const double slippery = greatest_force(false, 0.5);
  CHECK(slippery > 0.40);
  CHECK(slippery < 0.58);
  CHECK(greatest_force(true, 0.2) > 1.0);
  CHECK(greatest_force(true, 0.5) > 3.0);
  CHECK(greatest_force(true, 0.0) == slippery);
}

TEST_CASE("a friction coefficient of zero gives the forces of no friction") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    const RenderingScene with = rough_scene(rough_string(0.0, model), 1000.0);
    RenderingScene without = rough_scene(rough_string(0.7, model), 1000.0);
    without.instrument.friction = false;
    ToolRun a(with, pose_at({0.4, 0.02, 0.0}));
    ToolRun b(without, pose_at({0.4, 0.02, 0.0}));
    double largest = 0.0;
    double difference = 0.0;
    for (int tick = 0; tick < 400; ++tick) {
      const double t = 1e-3 * tick;
      const Pose X_WH = pose_at({0.4 + 0.05 * t, 0.008 - 0.02 * t, 0.002 * std::sin(20 * t)});
      a.tick(X_WH);
      b.tick(X_WH);
      const Vector3 f_a = rendered(a).F_H_W.f;
      const Vector3 f_b = rendered(b).F_H_W.f;
      largest = std::max(largest, f_a.norm());
      difference = std::max(difference, (f_a - f_b).norm());
      if (model == StringContact::kStraight) CHECK(b.state.touched.empty());
    }
    CHECK(largest > 0.1);
    CHECK(difference <= 1e-12 * largest);
  }
}

TEST_CASE("friction vanishes with the contact and starts anew with the next") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    const RenderingScene scene = rough_scene(rough_string(0.8, model), 1000.0);
    ToolRun run(scene, pose_at({0.4, 0.02, 0.0}));
    const double s = rest_distance(0.34e-3);
    for (int touch = 0; touch < 3; ++touch) {
      const double x = 0.4 + 0.01 * touch;
      glide(run, {x, s + 1e-3, 0.0}, {x, s - 2e-3, 0.0}, 60);
      // Straight down: whatever stuck before, nothing pulls sideways now.
      CHECK(std::abs(run.result.F_H_W.f.x()) <= 1e-3 * run.result.F_H_W.f.y());
      glide(run, {x, s - 2e-3, 0.0}, {x + 1e-3, s - 2e-3, 0.0}, 50);
      CHECK(run.result.F_H_W.f.x() < -0.02);
      glide(run, {x + 1e-3, s - 2e-3, 0.0}, {x + 1e-3, s + 1e-3, 0.0}, 60);
      CHECK(run.result.F_H_W.f.norm() == 0.0);
      CHECK(run.state.touched.empty());
    }
  }
}

TEST_CASE("no closed motion of the hand over rough strings gains energy") {
  std::int64_t ticks = 0;
  const std::int64_t wanted = scaled(1'000'000);
  double best = -1.0;
  int loops = 0;
  for (std::uint64_t seed = 1; ticks < wanted; ++seed) {
    const HandWork work = play(random_loop(seed), ticks);
    ++loops;
    if (!(work.moved > 1e-7)) continue;
    CAPTURE(seed);
    CHECK(work.gained <= kTrapezoidError * work.moved);
    best = std::max(best, work.gained / work.moved);
  }
  MESSAGE(loops << " loops, " << ticks << " ticks; the hand got back at best " << 100.0 * best
                << " % of what it moved");
}

TEST_CASE("stretching the anchor at a light press and relaxing it at a firm one gains nothing") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    for (const double x : {0.15, 0.55}) {
      for (const double mu : {0.3, 1.0}) {
        for (const double across : {0.0, 1.0}) {
          CAPTURE(static_cast<int>(model));
          CAPTURE(x);
          CAPTURE(mu);
          CAPTURE(across);
          const Vector3 aside = 0.8e-3 * mu * Vector3(1.0 - across, 0.0, across);
          const HandWork work = play_laps(rough_string(mu, model), x, aside);
          CHECK(work.gained <= kTrapezoidError * work.moved);
        }
      }
    }
  }
}

}  // namespace hapticd::test
