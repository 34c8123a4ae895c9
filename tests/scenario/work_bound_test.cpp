// The bound on the work of a tick that holds where nobody says otherwise, under a hand that goes
// where it likes: anywhere within the objects, at 0.3 and 1 m/s. Truths: the counts; an exhaustive
// search along the committed path, or at the end of the tick, for what the tool is in; the same
// hand without a bound.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/contact/tick_work.h"
#include "core/math/rotation.h"
#include "core/scene/quality.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"
#include "tests/support/string_shape.h"
#include "tests/truth/contact_oracle.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

/// The law: the tool never sinks into anything, m.
constexpr double kDeepest = -1e-6;
/// Units of work that half a tick of 1 ms is worth under the virtual clock: 500 us and the 2 % that
/// are allowed beyond, at 1.4 ns each.
constexpr std::int64_t kBound = 364'285;
/// What the work of a tick may be of its bound: nearly always, of all but 1 in 1000; and ever, when
/// its last linearisation is far dearer than those before it. So no tick takes all of its period.
constexpr double kUsually = 1.05;
constexpr double kEver = 1.5;
/// How deep the hand goes beyond a surface, m.
constexpr double kDepth = 0.03;
constexpr double kTick_s = 1e-3;
/// Energy that strings and soft pads hold beside the coupling, at most, J.
constexpr double kHeld = 0.1;

/// Goals of a hand: it moves from each to the next, turning, at one speed.
struct Wander {
  std::vector<Pose> goals;  ///< the first is where it begins
  double speed = 0.3;       ///< m/s
};

/// A pose with a leaf of the tool kDepth beyond the surface of an obstacle, turned by up to half a
/// radian about each axis.
Pose deep_in(const ToolScene& view, const Quaternion& upright, SplitMix64& random) {
  const auto capsules = view.obstacles.capsules_W;
  const auto bodies = view.obstacles.bodies;
  const std::uint64_t which = random.below(capsules.size() + bodies.size());
  const Vector3 in = to_vector(random.direction());
  Vector3 place = Vector3::Zero();
  if (which < capsules.size()) {
    const Capsule& capsule = capsules[which];
    place = capsule.p_A + random.uniform(0.0, 1.0) * (capsule.p_B - capsule.p_A);
  } else {
    const BodyView& body = bodies[which - capsules.size()];
    const Sphere leaf =
        body.tree.leaf(static_cast<std::int32_t>(random.below(body.tree.leaf_r.size())));
    place = transform(body.X_WB, leaf.p) - leaf.r * in;
  }
  const Vector3 phi(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                    random.uniform(-0.5, 0.5));
  const Quaternion q = (exp_rotation(phi) * upright).normalized();
  const Sphere leaf =
      view.tool.leaf(static_cast<std::int32_t>(random.below(view.tool.leaf_r.size())));
  return {q, place + kDepth * in - q * leaf.p};
}

Pose between(const Pose& a, const Pose& b, double share) {
  return {a.q.slerp(share, b.q), a.p + share * (b.p - a.p)};
}

std::vector<Pose> poses_of(const Wander& wander) {
  std::vector<Pose> poses;
  for (std::size_t k = 0; k + 1 < wander.goals.size(); ++k) {
    const Pose& from = wander.goals[k];
    const Pose& to = wander.goals[k + 1];
    const int ticks = static_cast<int>((to.p - from.p).norm() / (wander.speed * kTick_s)) + 1;
    for (int tick = 1; tick <= ticks; ++tick) {
      poses.push_back(between(from, to, static_cast<double>(tick) / ticks));
    }
  }
  return poses;
}

/// As many ticks of one hand, from where the scene begins.
std::vector<Pose> wander(const Scene& scene, double speed, std::int64_t ticks, std::uint64_t seed) {
  SplitMix64 random(seed);
  const ToolScene view = scene.tool_scene(0);
  Wander way{{scene.description().tools[0].X_WG}, speed};
  std::vector<Pose> poses;
  while (static_cast<std::int64_t>(poses.size()) < ticks) {
    way.goals.push_back(deep_in(view, way.goals.front().q, random));
    const std::vector<Pose> more = poses_of({{way.goals.end()[-2], way.goals.end()[-1]}, speed});
    poses.insert(poses.end(), more.begin(), more.end());
  }
  poses.resize(static_cast<std::size_t>(ticks));
  return poses;
}

std::vector<Sphere> leaves_of(const SphereTreeView& tree) {
  std::vector<Sphere> leaves;
  leaves.reserve(tree.leaf_r.size());
  for (std::size_t k = 0; k < tree.leaf_r.size(); ++k) {
    leaves.push_back(tree.leaf(static_cast<std::int32_t>(k)));
  }
  return leaves;
}

/// Puts a level of quality in force.
void play_at(const Scene& scene, int level, PathRun& run) {
  run.restart();
  ToolScene settings = scene.tool_scene(0);
  const ContactOptions options = quality_of(level).options;
  settings.options.sub_steps = options.sub_steps;
  settings.options.stop_tolerance = options.stop_tolerance;
  run.follow(settings);
}

double work_share(const ContactResult& result) {
  return static_cast<double>(tick_work(result)) / static_cast<double>(kBound);
}

bool same(const PathRun& a, const PathRun& b) {
  return a.X_WG().p == b.X_WG().p && a.X_WG().q.coeffs() == b.X_WG().q.coeffs() &&
         a.result().F_H_W.f == b.result().F_H_W.f && a.result().F_H_W.t == b.result().F_H_W.t &&
         tick_work(a.result()) == tick_work(b.result());
}

/// The smallest gap of any tool to the bodies and the strings as they are bent, m.
long double smallest_gap(const Scene& scene, const Simulation& simulation,
                         const SimulationTick& output) {
  const ToolScene view = scene.tool_scene(0);
  std::vector<Capsule> legs;
  for (std::size_t s = 0; s < view.strings.size(); ++s) {
    const StringPoints points = string_shape(simulation, static_cast<std::int32_t>(s));
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      legs.push_back({points[k], points[k + 1], view.obstacles.capsules_W[s].r});
    }
  }
  std::vector<std::vector<Sphere>> spheres;
  std::vector<OracleBody> bodies;
  for (const BodyView& body : view.obstacles.bodies) {
    spheres.push_back(leaves_of(body.tree));
    bodies.push_back({{}, body.X_WB, body.tree.blend.width});
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k].spheres_B = spheres[k];
  long double gap = 1.0L;
  for (std::size_t k = 0; k < simulation.tool_count(); ++k) {
    const std::vector<Sphere> tool = leaves_of(scene.tool_scene(k).tool);
    gap = std::min(gap, exhaustive_minimum_gap(tool, output.tool(k).X_WG, {legs, bodies}));
  }
  return gap;
}

struct Played {
  std::string scene;
  int level;
  double speed;
};

const std::vector<Played> kPlayed{{"guqin", 3, 0.3}, {"guqin", 3, 1.0},  {"guqin", 4, 0.3},
                                  {"guqin", 4, 1.0}, {"stress", 3, 0.3}, {"stress", 3, 1.0}};

}  // namespace

TEST_CASE(
    "a hand that goes anywhere makes 999 of 1000 ticks within the bound, none of half as much "
    "again, "
    "and the tool enters nothing where it cuts") {
  std::uint64_t seed = 20;
  std::int64_t ticks = 0;
  std::int64_t contact = 0;
  std::int64_t beyond = 0;
  for (const Played& played : kPlayed) {
    CAPTURE(played.scene);
    const auto loaded = load_shipped(played.scene);
    const std::vector<Pose> hand = wander(*loaded->scene, played.speed, scaled(20'000), ++seed);
    PathRun run(*loaded->scene);
    play_at(*loaded->scene, played.level, run);
    run.allow(kBound);
    const CouplingStiffness stiffness = loaded->scene->tool_scene(0).stiffness;
    std::set<std::size_t> cut;
    double most = 0.0;
    ticks += static_cast<std::int64_t>(hand.size());
    double hardest = -1.0;
    for (std::size_t k = 0; k < hand.size(); ++k) {
      const ContactState& state = run.state();
      const double stored = coupling_energy(stiffness, hand[k].q,
                                            coupling_error(state.X_WG, hand[k], state.phi_GH_W));
      run.tick(hand[k]);
      const Wrench& F_H_W = run.result().F_H_W;
      const double given =
          0.5 * (F_H_W.f.squaredNorm() / stiffness.kt + F_H_W.t.squaredNorm() / stiffness.kr());
      if (run.result().cut_short) hardest = std::max(hardest, given - 1.1 * stored);
      most = std::max(most, work_share(run.result()));
      beyond += work_share(run.result()) > kUsually ? 1 : 0;
      contact += run.result().active_count > 0 ? 1 : 0;
      if (run.result().cut_short) cut.insert(k);
    }
    // The same once more, judged where it was cut, and in the tick after.
    play_at(*loaded->scene, played.level, run);
    run.allow(kBound);
    double deepest = 1.0;
    int judged = 0;
    for (std::size_t k = 0; k < hand.size(); ++k) {
      const bool near = cut.contains(k) || (k > 0 && cut.contains(k - 1)) || k % 200 == 0;
      if (near && judged < scaled(500)) {
        ++judged;
        deepest = std::min(deepest, run.judged_tick(hand[k]));
      } else {
        run.tick(hand[k]);
      }
    }
    MESSAGE(played.scene << " at quality " << played.level << ", " << played.speed
                         << " m/s: most work " << most << " of the bound, " << cut.size() << " of "
                         << hand.size() << " ticks cut, deepest " << deepest << " m in " << judged);
    CHECK(most <= kEver);
    CHECK(deepest >= kDeepest);
    // What is cut presses no harder than the coupling's spring, and what strings and pads hold.
    CHECK(hardest <= kHeld);
  }
  MESSAGE(beyond << " of " << ticks << " ticks beyond " << kUsually << " of the bound, " << contact
                 << " in contact");
  CHECK(beyond <= 1 + ticks / 1000);
  CHECK(contact > ticks / 20);
}

TEST_CASE("below the bound it changes no bit: the two part only at a tick of half of it or more") {
  std::uint64_t seed = 40;
  int compared = 0;
  for (const Played& played : kPlayed) {
    CAPTURE(played.scene);
    const auto loaded = load_shipped(played.scene);
    PathRun free(*loaded->scene);
    PathRun bounded(*loaded->scene);
    for (std::int64_t start = 0; start < scaled(80); ++start) {
      play_at(*loaded->scene, played.level, free);
      play_at(*loaded->scene, played.level, bounded);
      bounded.allow(kBound);
      for (const Pose& X_WH : wander(*loaded->scene, played.speed, 400, ++seed)) {
        free.tick(X_WH);
        bounded.tick(X_WH);
        if (2.2 * work_share(free.result()) > 1.0) break;
        ++compared;
        REQUIRE(same(free, bounded));
      }
    }
  }
  MESSAGE(compared << " ticks compared");
  CHECK(compared > scaled(50'000));
}

TEST_CASE("a search for the dearest tick finds none of half as much again as the bound") {
  for (const Played& played : {Played{"guqin", 3, 0.3}, Played{"guqin", 4, 1.0}}) {
    CAPTURE(played.scene);
    const auto loaded = load_shipped(played.scene);
    const ToolScene view = loaded->scene->tool_scene(0);
    const Pose start = loaded->scene->description().tools[0].X_WG;
    PathRun run(*loaded->scene);
    SplitMix64 random(60);
    // From the first goal, where the hand is at once, to the second.
    const auto dearest = [&](const Wander& wander) {
      play_at(*loaded->scene, played.level, run);
      for (int tick = 0; tick < 3; ++tick) run.tick(wander.goals.front());
      run.allow(kBound);
      double most = 0.0;
      for (const Pose& X_WH : poses_of(wander)) {
        run.tick(X_WH);
        most = std::max(most, work_share(run.result()));
      }
      return most;
    };
    const auto aside = [&](const Pose& goal, double reach) {
      const Vector3 phi = 2.0 * reach * to_vector(random.direction());
      return Pose{(exp_rotation(phi) * goal.q).normalized(),
                  goal.p + reach * random.uniform() * to_vector(random.direction())};
    };
    double worst = 0.0;
    for (std::int64_t restart = 0; restart < scaled(40); ++restart) {
      const Pose first = deep_in(view, start.q, random);
      Wander best{{first, aside(first, 0.06)}, played.speed};
      double most = dearest(best);
      for (int step = 0; step < 12; ++step) {
        Wander next = best;
        for (Pose& goal : next.goals) goal = aside(goal, random.chance(0.5) ? 2e-3 : 0.02);
        const double found = dearest(next);
        if (found < most) continue;
        most = found;
        best = next;
      }
      worst = std::max(worst, most);
    }
    MESSAGE(played.scene << " at quality " << played.level << ": the dearest found " << worst
                         << " of the bound");
    CHECK(worst <= kEver);
  }
}

TEST_CASE("five tools together share the bound, and enter nothing") {
  const auto loaded = load_shipped("five_fingers");
  const Scene& scene = *loaded->scene;
  const std::size_t tools = scene.description().tools.size();
  REQUIRE(tools == 5);
  for (const double speed : {0.3, 1.0}) {
    std::vector<std::vector<Pose>> hands;
    for (std::size_t k = 0; k < tools; ++k) {
      hands.push_back(wander(scene, speed, scaled(20'000), 100 + k));
      const Vector3 off = scene.description().tools[k].X_WG.p - scene.description().tools[0].X_WG.p;
      for (Pose& X_WH : hands.back()) X_WH.p += off;
    }
    const OwnedSimulation play = scene.simulate();
    SimulationTick output;
    double most = 0.0;
    int cut = 0;
    int judged = 0;
    long double deepest = 1.0L;
    for (std::size_t tick = 0; tick < hands[0].size(); ++tick) {
      std::array<HandPose, 5> placed;
      for (std::size_t k = 0; k < tools; ++k) {
        const Pose& X_WH = hands[k][tick];
        placed[k] = {static_cast<std::int64_t>(tick + 1) * 1'000'000, to_array(X_WH.p),
                     to_array(X_WH.q)};
      }
      output.step(*play.simulation, placed, kBound);
      double share = 0.0;
      bool any = false;
      for (std::size_t k = 0; k < tools; ++k) {
        share += work_share(output.tool(k).contact);
        any = any || output.tool(k).contact.cut_short;
      }
      most = std::max(most, share);
      cut += any ? 1 : 0;
      if ((any || tick % 500 == 0) && judged < scaled(100)) {
        ++judged;
        deepest = std::min(deepest, smallest_gap(scene, *play.simulation, output));
      }
    }
    MESSAGE("five_fingers, " << speed << " m/s: most work " << most << " of the bound, " << cut
                             << " of " << hands[0].size() << " ticks cut, deepest "
                             << static_cast<double>(deepest) << " m in " << judged);
    CHECK(most <= kEver);
    CHECK(deepest >= kDeepest);
  }
}

}  // namespace hapticd::test
