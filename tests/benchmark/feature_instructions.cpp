// Plays one scene of a ladder that begins with nothing and gains one feature at a time, and steps
// its ticks in a function whose instructions callgrind counts: what each feature costs, and that
// what a scene does not have costs nothing. Run by tests/benchmark/count_features. usage:
// feature_instructions [CASE]; without one it lists them.
#include <cstdio>
#include <cstring>
#include <string>

#include "core/math/elementary.h"
#include "core/scene/scene.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

constexpr int kTicks = 500;
/// Height at which the finger just touches a string at y = 0, m.
constexpr double kTouch = 5e-3 + 0.34e-3;

/// What the finger does.
enum class Play {
  kFar,      ///< 50 mm above
  kPress,    ///< 2 mm into the first string, or the body, 0.5 mm up and down
  kRinging,  ///< 50 mm above a string it has just plucked
};

/// A rung of the ladder.
struct Case {
  const char* name;
  Play play;
  int strings = 0;    ///< along x, 20 mm apart in z
  bool body = false;  ///< 2000 spheres, 0.1 m below the strings; where there are none, in touch
  int modes = 0;
  bool vibration = false;
  bool friction = false;
  bool torque = false;
  bool hand = false;  ///< of 36 spheres instead of one
};

constexpr Case kCases[] = {
    {"empty", Play::kFar},
    {"far_body", Play::kFar, 0, true},
    {"far_string", Play::kFar, 1},
    {"far_7_strings", Play::kFar, 7},
    {"far_107_strings", Play::kFar, 107},
    {"press_body", Play::kPress, 0, true},
    {"press", Play::kPress, 1},
    {"press_far_body", Play::kPress, 1, true},
    {"press_7_strings", Play::kPress, 7},
    {"press_107_strings", Play::kPress, 107},
    {"hand_7_strings", Play::kPress, 7, false, 0, false, false, false, true},
    {"hand_107_strings", Play::kPress, 107, false, 0, false, false, false, true},
    {"press_torque", Play::kPress, 1, false, 0, false, false, true},
    {"press_vibration", Play::kPress, 1, false, 0, true},
    {"press_friction", Play::kPress, 1, false, 0, false, true},
    {"press_modes16", Play::kPress, 1, false, 16, true},
    {"plucked_silent", Play::kRinging, 1},
    {"plucked_vibration", Play::kRinging, 1, false, 0, true},
    {"plucked_modes16", Play::kRinging, 1, false, 16, true},
};

Scene scene_of(const Case& c) {
  SceneDescription scene = finger_scene({0.33, 0.1, 0.0});
  if (c.hand) scene.tools[0].parts = {part_of(hand_spheres())};
  scene.torque = c.torque;
  scene.instrument.vibration = c.vibration;
  scene.instrument.friction = c.friction;
  scene.instrument.modes = c.modes;
  for (int k = 0; k < c.strings; ++k) {
    StringDescription string =
        string_between(Vector3(0.0, 0.0, 0.02 * k), Vector3(1.1, 0.0, 0.02 * k));
    string.parameters.frequency = 98.0;
    string.parameters.friction_coefficient = 0.3;
    // So that it neither sleeps nor decays within the ticks counted.
    string.parameters.decay = 1000.0;
    string.parameters.touch_decay = 1000.0;
    scene.strings.push_back(string);
  }
  if (c.body) {
    BodyDescription body;
    body.name = "slab";
    body.shape = shape_of(slab_spheres(80, 25));
    body.X_WB.p = {0.33, c.strings > 0 ? -0.1 : 2e-3, 0.0};
    scene.bodies.push_back(body);
  }
  return Scene(std::move(scene));
}

/// A simulation and the time in it.
struct Run {
  OwnedSimulation play;
  SimulationTick output;
  std::int64_t t_ns = 0;

  void tick(double y) {
    t_ns += 1'000'000;
    output.step(*play.simulation, {t_ns, {0.33, y, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  }
};

}  // namespace

/// Callgrind collects between its entry and its return.
[[gnu::noinline]] void counted_tick(Run& run, double y) { run.tick(y); }

namespace {

int play(const Case& c) {
  const Scene scene = scene_of(c);
  Run run{scene.simulate(0), {}};
  // A palm is thicker than a finger.
  const double palm = c.hand ? 9e-3 : 0.0;
  const double low = kTouch + palm - (c.play == Play::kFar ? -0.05 : 2.5e-3);
  for (int k = 0; k < 100; ++k) run.tick(0.1 + (low - 0.1) * k / 100.0);
  if (c.play == Play::kRinging) {
    for (int k = 0; k < 10; ++k) run.tick(low + 5e-3 * k);
  }
  for (int k = 0; k < kTicks; ++k) {
    const double wave = sin_cos(2.0 * kPi * k / 250.0).sin;
    const double middle = (c.play == Play::kPress ? kTouch - 2e-3 : kTouch + 0.05) + palm;
    counted_tick(run, middle + 0.5e-3 * wave);
  }
  // What the case is named after must have happened.
  const ContactResult& result = run.output.tool(0).contact;
  const bool pressing = result.active_count > 0;
  if (pressing != (c.play == Play::kPress)) return 1;
  const bool awake = !run.output.strings().empty();
  if (awake != (c.strings > 0 && (pressing || c.vibration))) return 1;
  std::printf("%d ticks\n", kTicks);
  return 0;
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  for (const Case& c : kCases) {
    if (argc < 2) std::printf("%s\n", c.name);
    if (argc < 2 || std::strcmp(argv[1], c.name) != 0) continue;
    if (play(c) == 0) return 0;
    std::fprintf(stderr, "%s: the finger does not do what it is named after\n", c.name);
    return 1;
  }
  return argc < 2 ? 0 : 2;
}
