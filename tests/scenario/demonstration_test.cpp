// The gestures that are shipped, played by a simulated hand on the Guqin: device plant, arm and
// scene coupled as in the loop. Each string that shall sound does; the way of the tool is judged by
// exhaustive search.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "device/simulated/simulated_device.h"
#include "server/scene_io/profile_loader.h"
#include "tests/scenario/shipped_gesture.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
/// The law: the tool never sinks into anything, m.
constexpr double kDeepest = -1e-6;
/// Longest play of one gesture, ticks.
constexpr std::int64_t kMaxPlay = 60'000;

DeviceProfile shipped_profile(const std::string& name) {
  const ProfileResult result = load_profile(name, {HAPTICD_SOURCE_DIR "/deploy/devices"});
  REQUIRE(result.loaded.has_value());
  return result.loaded->profile;
}

/// What came of playing a gesture.
struct Played {
  std::vector<std::int32_t> tones;
  std::vector<Pose> X_WH;  ///< of every tick
  double greatest_force = 0.0;
  double greatest_energy = 0.0;
  bool finite = true;
};

Played play(const Scene& scene, const GestureMotion& motion, const DeviceProfile& profile,
            ArmKind arm) {
  SimulatedDevice device(profile, {.X_DH = scene.description().tools[0].X_WG, .arm = arm});
  device.play(motion.track(), 1);
  OwnedSimulation tool = scene.simulate(0);
  SimulationTick output;
  Played played;
  for (std::int64_t tick = 0; tick < kMaxPlay; ++tick) {
    DeviceSample sample;
    device.read(tick * kTick_ns, sample);
    if (tick > 0 && !device.gesture().playing) break;
    output.step(*tool.simulation, {sample.t_ns, sample.p_DH, sample.q_DH});
    for (const StringEvent& event : output.events()) {
      if (event.kind == StringEventKind::kTone) played.tones.push_back(event.string);
    }
    const Wrench& F_H_W = output.tool(0).F_H_W;
    played.X_WH.push_back({to_quaternion(sample.q_DH), to_vector(sample.p_DH)});
    played.finite = played.finite && std::isfinite(F_H_W.f.norm() + F_H_W.t.norm());
    played.greatest_force = std::max(played.greatest_force, F_H_W.f.norm());
    played.greatest_energy = std::max(played.greatest_energy, device.plant().energy);
    device.write(tick * kTick_ns,
                 {.f_H_D = to_array(F_H_W.f), .t_H_D = to_array(F_H_W.t), .enable = true});
  }
  CHECK(device.gesture().finished == 1);
  return played;
}

std::map<std::int32_t, int> count(const std::vector<std::int32_t>& tones) {
  std::map<std::int32_t, int> counts;
  for (const std::int32_t string : tones) ++counts[string];
  return counts;
}

}  // namespace

TEST_CASE("the demonstration sounds every string of the Guqin and sinks into nothing") {
  const auto loaded = load_shipped("guqin");
  const Scene& scene = *loaded->scene;
  const Played played = play(scene, shipped_gesture("demonstration", scene.description()),
                             shipped_profile("premium_3_0_6dof"), ArmKind::kLight);
  CHECK(played.finite);
  CHECK(played.greatest_force > 0.5);
  CHECK(played.greatest_force < 5.0);
  const std::map<std::int32_t, int> tones = count(played.tones);
  CHECK(tones.size() == loaded->message.strings_size());
  for (const auto& tone : tones) CHECK(tone.second >= 2);

  // The same poses again, judged now and then along the whole way of a tick.
  PathRun run(scene);
  const std::size_t judged = static_cast<std::size_t>(scaled(500));
  const std::size_t stride = played.X_WH.size() / judged + 1;
  double smallest = 1.0;
  for (std::size_t tick = 0; tick < played.X_WH.size(); ++tick) {
    if (tick % stride == stride / 2) {
      smallest = std::min(smallest, run.judged_tick(played.X_WH[tick]));
    } else {
      run.tick(played.X_WH[tick]);
    }
  }
  CHECK(smallest >= kDeepest);
}

TEST_CASE("a firm hand on an ideal device plays the demonstration too") {
  const auto loaded = load_shipped("guqin");
  const Scene& scene = *loaded->scene;
  const Played played = play(scene, shipped_gesture("demonstration", scene.description()),
                             shipped_profile("ideal"), ArmKind::kFirm);
  CHECK(played.finite);
  CHECK(count(played.tones).size() == 7);
}

TEST_CASE("nobody at the handle: the demonstration plays no tone and moves nothing") {
  const auto loaded = load_shipped("guqin");
  const Scene& scene = *loaded->scene;
  const Played played = play(scene, shipped_gesture("demonstration", scene.description()),
                             shipped_profile("premium_3_0_6dof"), ArmKind::kOff);
  CHECK(played.tones.empty());
  CHECK(played.greatest_force == 0.0);
  CHECK(played.greatest_energy == 0.0);
}

TEST_CASE("the shipped gestures pluck the strings they name, in order") {
  const auto loaded = load_shipped("guqin");
  const Scene& scene = *loaded->scene;
  const std::pair<const char*, std::vector<std::int32_t>> cases[] = {
      {"pluck_each", {0, 1, 2, 3, 4, 5, 6}},
      {"strum", {0, 1, 2, 3, 4, 5, 6}},
      {"press_and_hold", {3}},
      {"glide", {3}}};
  for (const auto& each : cases) {
    const Played played = play(scene, shipped_gesture(each.first, scene.description()),
                               shipped_profile("premium_3_0_6dof"), ArmKind::kLight);
    std::vector<std::int32_t> order = played.tones;
    order.erase(std::unique(order.begin(), order.end()), order.end());
    CAPTURE(each.first);
    CHECK(order == each.second);
    CHECK(played.greatest_force < 5.0);
  }
}

}  // namespace hapticd::test
