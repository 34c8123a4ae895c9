// The scenes that come with hapticd are what they promise, and can be played without the tool ever
// entering anything.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "server/model/shapes/hand_model.h"
#include "server/scene_io/named_text.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/server/model/shapes/guqin_strings.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/skip.h"
#include "tests/support/within.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

/// The law: the tool never sinks into anything, m.
constexpr double kDeepest = -1e-6;

const std::vector<std::string> kScenes{
    "bunny",      "bunny_coarse",  "bunny_fine", "cabin",  "five_fingers", "guqin", "guqin_coarse",
    "guqin_fine", "single_string", "sphere",     "stress", "strings_100",  "wall"};

/// False for a scene whose models are made on demand only and were not.
bool can_load(const std::string& name) { return name != "guqin_fine" || fine_models_exist(); }

/// A point of the obstacles, in W.
Vector3 place_on(const ToolScene& view, SplitMix64& random) {
  const auto capsules = view.obstacles.capsules_W;
  const auto bodies = view.obstacles.bodies;
  const std::uint64_t which = random.below(capsules.size() + bodies.size());
  if (which < capsules.size()) {
    const Capsule& capsule = capsules[which];
    return capsule.p_A + random.uniform(0.0, 1.0) * (capsule.p_B - capsule.p_A);
  }
  const BodyView& body = bodies[which - capsules.size()];
  const Sphere leaf =
      body.tree.leaf(static_cast<std::int32_t>(random.below(body.tree.leaf_r.size())));
  const Vector3 out = to_vector(random.direction());
  // A ball of 1 km stands for a plane: its near side is meant.
  return transform(body.X_WB, leaf.p) +
         (leaf.r > 1.0 ? Vector3(0, 0, leaf.r) : Vector3(leaf.r * out));
}

/// The middle of obstacle `k`, capsules first, or of what of it faces up, in W.
Vector3 middle_of(const ToolScene& view, std::size_t k) {
  const auto capsules = view.obstacles.capsules_W;
  if (k < capsules.size()) return 0.5 * (capsules[k].p_A + capsules[k].p_B);
  const BodyView& body = view.obstacles.bodies[k - capsules.size()];
  const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(body.tree.leaf_r.size() / 2));
  return transform(body.X_WB, leaf.p) + Vector3(0.0, leaf.r, 0.0);
}

}  // namespace

TEST_CASE("every scene that is shipped is known, loads without a doubt and begins in the open") {
  CHECK(list_names(shipped().paths.scenes) == kScenes);
  for (const std::string& name : kScenes) {
    if (!can_load(name)) continue;
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    CHECK(loaded->message.name() == name);
    CHECK(!loaded->message.description().empty());
  }
}

TEST_CASE("the finest Guqin loads where its models were made") {
  if (!fine_models_exist()) {
    skip("the models of guqin_fine are made with HAPTICD_FINE_MODELS");
    return;
  }
  CHECK(load_shipped("guqin_fine")->scene->body_spheres() > 17'000);
}

TEST_CASE("in no scene does the tool enter anything on its whole path, at any speed of the hand") {
  SplitMix64 random(7);
  for (std::int64_t stroke = 0; stroke < scaled(100); ++stroke) {
    const std::string& name = kScenes[static_cast<std::size_t>(stroke) % kScenes.size()];
    if (!can_load(name)) continue;
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    const ToolScene view = loaded->scene->tool_scene(0);
    PathRun run(*loaded->scene);
    Pose X_WH = run.X_WG();
    // A leaf of the tool is led to a place on an obstacle, and 5 mm beyond.
    const Sphere leaf =
        view.tool.leaf(static_cast<std::int32_t>(random.below(view.tool.leaf_r.size())));
    const Vector3 goal = place_on(view, random) - X_WH.q * leaf.p;
    const double step = std::pow(10.0, random.uniform(-3.5, -1.0));
    const Vector3 way = goal - X_WH.p;
    const double length = way.norm();
    const int ticks = static_cast<int>(std::min(20.0, length / step + 3.0));
    const Vector3 start = goal - way * std::min(1.0, step * ticks / length);
    // Getting there takes a few ticks that are not judged.
    for (int k = 0; k < 3; ++k) run.tick(moved_to(X_WH, start));
    for (int k = 1; k <= ticks; ++k) {
      const double share = static_cast<double>(k) / ticks;
      X_WH = moved_to(X_WH, start + share * (goal - start + way * (5e-3 / length)));
      if (k % 4 == 0) {
        REQUIRE(run.judged_tick(X_WH) >= kDeepest);
      } else {
        run.tick(X_WH);
      }
    }
    CHECK(!run.touched().empty());
  }
}

TEST_CASE(
    "led into the middle of anything the tool follows, and stands still for two ticks at most") {
  for (const std::string name : {"bunny", "guqin", "stress"}) {
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    const ToolScene view = loaded->scene->tool_scene(0);
    const std::size_t capsules = view.obstacles.capsules_W.size();
    for (std::size_t k = 0; k < capsules + view.obstacles.bodies.size(); ++k) {
      CAPTURE(k);
      PathRun run(*loaded->scene);
      const Pose start = run.X_WG();
      const Vector3 goal = middle_of(view, k) - start.q * view.tool.leaf(0).p;
      const int approach = static_cast<int>((goal - start.p).norm() / 1e-3) + 1;
      int stuck = 0;
      int longest = 0;
      for (int tick = 1; tick <= approach + 100; ++tick) {
        const double share = std::min(1.0, static_cast<double>(tick) / approach);
        const double aside = 1e-4 * std::max(0, tick - approach);
        run.tick(moved_to(start, start.p + share * (goal - start.p) + Vector3(aside, 0.0, aside)));
        stuck = run.result().status == ContactStatus::kRefused ? stuck + 1 : 0;
        longest = std::max(longest, stuck);
      }
      CHECK(longest <= 2);
    }
  }
}

TEST_CASE("the hand reaches through the cabin and back, pushed about by ten objects or more") {
  const auto loaded = load_shipped("cabin");
  const SceneDescription& d = loaded->scene->description();
  CHECK(d.lines.size() >= 20);
  int sagging = 0;
  for (const StringDescription& cable : d.strings) {
    if (cable.sag > 0.0 && cable.parameters.model == StringContact::kYielding) ++sagging;
  }
  CHECK(sagging >= 10);
  for (const LineDescription& pipe : d.lines) CHECK(pipe.points_W.size() >= 3);

  PathRun run(*loaded->scene);
  const Pose start = run.X_WG();
  constexpr int kTicks = 1000;
  constexpr double kReach = 0.75;  // m
  const auto judge_every = static_cast<int>(1.0 + 1.0 / static_cast<double>(scaled(400)) * 1000.0);
  double deepest_G = 0.0;
  for (int tick = 1; tick <= 2 * kTicks; ++tick) {
    const double share = tick <= kTicks ? 1.0 * tick / kTicks : 2.0 - 1.0 * tick / kTicks;
    const double sway = 0.03 * std::sin(20.0 * share);
    const Pose X_WH = moved_to(start, start.p + Vector3(sway, 0.7 * sway, -kReach * share));
    if (tick % judge_every == 0) {
      REQUIRE(run.judged_tick(X_WH) >= kDeepest);
    } else {
      run.tick(X_WH);
    }
    deepest_G = std::min(deepest_G, run.X_WG().p.z() - start.p.z());
  }
  MESSAGE("touched ", run.touched().size(), " objects, reached ", -deepest_G, " m");
  CHECK(run.touched().size() >= 10);
  CHECK(-deepest_G >= 0.9 * kReach);
  // Back in the open, the tool is at the hand.
  CHECK((run.X_WG().p - start.p).norm() <= 1e-9);
}

TEST_CASE("every part of the bunny's frame can be touched") {
  const auto loaded = load_shipped("bunny");
  PathRun run(*loaded->scene);
  const Pose start = run.X_WG();
  const auto visit = [&](const Vector3& goal) {
    const Vector3 from = run.X_WG().p;
    for (int tick = 1; tick <= 300; ++tick) {
      run.tick(moved_to(start, from + (tick / 300.0) * (goal - from)));
    }
  };
  for (const Vector3& goal :
       {Vector3(0, 0.08, 0.0), Vector3(0, 0.2, 0), Vector3(0.12, 0.2, 0), Vector3(0.12, 0.08, 0),
        Vector3(0, 0.2, 0.0), Vector3(-0.12, 0.2, 0), Vector3(-0.12, 0.08, 0), Vector3(0, 0.2, 0),
        Vector3(0, 0.2, 0.15), Vector3(0, 0.02, 0.15), Vector3(0, 0.02, 0.07)}) {
    visit(goal);
  }
  for (const std::string name : {"line_1", "line_2", "pillar_1", "pillar_2", "plate"}) {
    CAPTURE(name);
    CHECK(run.touched().contains(name));
  }
}

TEST_CASE("the Guqin's strings are those of its model, and its bounds are those promised") {
  for (const std::string name : {"guqin", "guqin_coarse", "guqin_fine", "stress"}) {
    if (!can_load(name)) continue;
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    const SceneDescription& d = loaded->scene->description();
    const auto strings = guqin_strings({});
    REQUIRE(d.strings.size() == strings.size());
    for (std::size_t i = 0; i < strings.size(); ++i) {
      const StringParameters& p = d.strings[i].parameters;
      CHECK((to_vector(p.p_WA) - strings[i].p_WA).norm() <= 1e-6);
      CHECK((to_vector(p.p_WB) - strings[i].p_WB).norm() <= 1e-6);
      CHECK(p.radius == within(strings[i].radius, 1e-4));
      CHECK(derive_string(p).frequency == within(strings[i].frequency, 1e-6));
    }
  }
  const auto guqin = load_shipped("guqin");
  for (const BodyDescription& body : guqin->scene->description().bodies) {
    CHECK(body.shape.tree->outer <= 250e-6);
    CHECK(body.shape.tree->inner == 0.0);
  }
  int pads = 0;
  for (const PartDescription& part : guqin->scene->description().tools[0].parts) {
    if (!part.name.ends_with("_tip")) continue;
    CHECK(part.shape.tree->outer <= 60e-6);
    ++pads;
  }
  CHECK(pads == kFingers);
}

/// Cents by which `string`, held onto the board at `lambda`, is sharp of the open string's share.
double sharp_by(const StringConstants& string, const GuqinString& at, double lambda) {
  const GuqinParameters guqin;
  const Vector3 p = at.p_WA + lambda * (at.p_WB - at.p_WA);
  const double tilt = p.z() / guqin.crown_radius;
  const double depth =
      p.y() - guqin_top(guqin, p.x(), p.z()) - at.radius / std::sqrt(1.0 - tilt * tilt);
  const double stretched =
      std::hypot(lambda * string.length, depth) + std::hypot((1.0 - lambda) * string.length, depth);
  const double tension =
      string.tension + string.axial_stiffness * (stretched / string.length - 1.0);
  return 600.0 * std::log2(tension / string.tension);
}

TEST_CASE(
    "the Guqin's strings are of twisted silk, and stopped in the middle they sound an octave") {
  // deploy/docs/making_scenes.md: threads of 3.7 GPa and 1340 kg/m^3, turned by 30 degrees.
  constexpr double kModulusOverDensity = 3.7e9 * 0.75 / 1340.0;
  const auto strings = guqin_strings({});
  for (const std::string name : {"guqin", "guqin_coarse", "five_fingers", "stress"}) {
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    const SceneDescription& d = loaded->scene->description();
    for (std::size_t i = 0; i < strings.size(); ++i) {
      CAPTURE(i);
      const StringParameters& p = d.strings[i].parameters;
      const StringConstants string = derive_string(p);
      CHECK(string.axial_stiffness == within(p.linear_density * kModulusOverDensity, 3e-3));
      CHECK(sharp_by(string, strings[i], 0.5) >= 0.0);
      CHECK(sharp_by(string, strings[i], 0.5) <= 6.0);
      // Losses of modes 1 and 10 are those of a nylon string, eta_A 1.2 /s and eta_F 4e-4.
      const double first = 0.5 * (1.2 + 4e-4 * 2.0 * kPi * string.frequency);
      CHECK(1.0 / string.decay == within(first, 0.03));
    }
  }
}

TEST_CASE("stress has the bunny of 1000 spheres, a body of more than 10 000, and seven strings") {
  const auto loaded = load_shipped("stress");
  CHECK(loaded->scene->tool_spheres(0) >= 900);
  CHECK(loaded->scene->tool_spheres(0) <= 1000);
  CHECK(loaded->scene->body_spheres() >= 10'000);
  CHECK(loaded->scene->string_pieces() == 7);
}

}  // namespace hapticd::test
