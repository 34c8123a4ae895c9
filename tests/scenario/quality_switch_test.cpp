// Levels of quality and work budgets that are switched while a simulated hand presses and slides on
// the Guqin: device plant, arm and scene coupled as in the loop, so that a step of force would move
// the hand. Truths: the bound of a contact switch (the hand's own motion), and where a force
// changes by more, the exact statics from where the tool was: it slips on the way to a rest that is
// there.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "core/scene/quality.h"
#include "device/simulated/simulated_device.h"
#include "server/scene_io/profile_loader.h"
#include "tests/scenario/shipped_gesture.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/support/random.h"
#include "tests/support/simulation_tick.h"
#include "tests/truth/scene_statics.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kTicks = 4000;
/// Ticks between two switches.
constexpr std::int64_t kSwitchEvery = 25;
/// Change of force per tick that a contact switch may always make, N, and its share of kt |v| dt.
constexpr double kFreeChange = 0.15;
constexpr double kExcess = 1.1;

/// What was felt of a gesture.
struct Felt {
  double worst = 0.0;  ///< change of force over what is allowed
  int judged = 0;      ///< ticks with force
  int slips = 0;       ///< ticks that the exact statics was asked about
  int cut_short = 0;
  double greatest_force = 0.0;
};

/// Distance of `f` from the straight way between `a` and `b`, N.
double off_the_way(const Vector3& f, const Vector3& a, const Vector3& b) {
  const double square = (b - a).squaredNorm();
  const double share = square > 0.0 ? std::clamp((f - a).dot(b - a) / square, 0.0, 1.0) : 0.0;
  return (f - a - share * (b - a)).norm();
}

Felt play_switched(const Scene& scene, const std::string& gesture, std::uint64_t seed) {
  const ProfileResult profile =
      load_profile("premium_3_0_6dof", {HAPTICD_SOURCE_DIR "/deploy/devices"});
  REQUIRE(profile.loaded.has_value());
  SimulatedDevice device(profile.loaded->profile,
                         {.X_DH = scene.description().tools[0].X_WG, .arm = ArmKind::kLight});
  const GestureMotion motion = shipped_gesture(gesture, scene.description());
  device.play(motion.track(), 1);
  OwnedSimulation tool = scene.simulate(0);
  const SceneStatics exact(tool.simulation->scene(0));
  SimulationTick output;
  SplitMix64 random(seed);
  Felt felt;
  Vector3 f{0, 0, 0};
  Vector3 p{0, 0, 0};
  std::int64_t work = 0;
  for (std::int64_t tick = 0; tick < kTicks; ++tick) {
    if (tick % kSwitchEvery == 0) {
      ToolScene& played = tool.simulation->scene(0);
      played.options = quality_of(static_cast<int>(random.below(kQualityLevels))).options;
      work = random.chance(0.5) ? 0 : 1;
    }
    DeviceSample sample;
    device.read(tick * kTick_ns, sample);
    const HandPose hand{sample.t_ns, sample.p_DH, sample.q_DH};
    const ContactState before = tool.simulation->memory().tools[0].state.contact;
    output.step(*tool.simulation, {&hand, 1}, work);
    const Wrench& F_H_W = output.tool(0).F_H_W;
    device.write(tick * kTick_ns,
                 {.f_H_D = to_array(F_H_W.f), .t_H_D = to_array(F_H_W.t), .enable = true});
    const Vector3 f_now = output.tool(0).F_computed_H_W.f;
    const double way = tick == 0 ? 0.0 : (to_vector(sample.p_DH) - p).norm();
    const double kt = tool.simulation->scene(0).stiffness.kt;
    const double allowed = std::max(kFreeChange, kExcess * kt * way);
    double change = (f_now - f).norm();
    if (change > allowed) {
      ++felt.slips;
      const StaticRest rest = exact.rest(output.tool(0).X_WH, before);
      change = off_the_way(f_now, f, rest.F_H_W.f);
    }
    if (f_now.norm() > 0.0) ++felt.judged;
    felt.worst = std::max(felt.worst, change / allowed);
    if (output.tool(0).contact.cut_short) ++felt.cut_short;
    felt.greatest_force = std::max(felt.greatest_force, f_now.norm());
    f = f_now;
    p = to_vector(sample.p_DH);
  }
  return felt;
}

}  // namespace

TEST_CASE("switching levels and budgets under a hand that presses and slides makes no force step") {
  const auto loaded = load_shipped("guqin");
  std::uint64_t seed = 1;
  for (const char* gesture : {"slide_on_body", "press_and_hold", "slide_along"}) {
    CAPTURE(std::string(gesture));
    const Felt felt = play_switched(*loaded->scene, gesture, seed++);
    MESSAGE(std::string(gesture) << ": greatest change of force over what a contact may make "
                                 << felt.worst << " in " << felt.judged << " ticks, " << felt.slips
                                 << " of them slips, " << felt.cut_short
                                 << " cut short, most force " << felt.greatest_force << " N");
    CHECK(felt.worst <= 1.0);
    CHECK(felt.judged > kTicks / 5);
    CHECK(felt.greatest_force > 0.3);
  }
}

}  // namespace hapticd::test
