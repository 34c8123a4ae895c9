// A simulated device of every profile that is shipped pushes on a wall and plucks a string, played
// as the daemon plays scenes. Truth: the force that holds an arm's spring against the stiffness
// which the profile's numbers bear, half of b / (T / 2 + t_d), by hand.
#include <doctest/doctest.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "server/daemon/scene_player.h"
#include "server/haptic_loop/haptic_loop.h"
#include "server/scene_io/profile_loader.h"
#include "server/scene_io/sheet_translation.h"
#include "tests/server/daemon/recorded_session.h"

namespace hapticd::test {
namespace {

// The finger passes over the string, within the height of a stick that senses none.
constexpr const char* kString = R"(
name: "string"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0, 0.02] }
}
strings { name: "C2" p_wa_m: [-0.55, -0.0045, 0] p_wb_m: [0.55, -0.0045, 0] frequency_hz: 65.4 }
vibration {}
tones {}
)";

// 5 mm into the wall, if it gave way.
constexpr const char* kPush = R"(
name: "push"
tracks {
  waypoints { pose_wh { p_m: [0, 0, 0.025] q: [1, 0, 0, 0] } }
  waypoints { pose_wh { p_m: [0, 0, 0] q: [1, 0, 0, 0] } duration_s: 0.8 hold_s: 3 }
}
)";

constexpr const char* kPluck = R"(
name: "pluck"
tracks {
  waypoints { pose_wh { p_m: [0, 0, 0.02] q: [1, 0, 0, 0] } }
  waypoints { pose_wh { p_m: [0, 0, 0.02] q: [1, 0, 0, 0] } duration_s: 0.4 }
  waypoints { pose_wh { p_m: [0, 0, -0.04] q: [1, 0, 0, 0] } duration_s: 0.6 hold_s: 0.3 }
}
)";

/// What a device did.
struct Playing {
  double force = 0.0;  ///< written in the last tick, N
  double largest = 0.0;
  double computed = 0.0;  ///< largest, before any limit
  int tones = 0;
  double bound = 0.0;
  double scale = 1.0;
};

Playing play(const DeviceSheet& profile, const char* scene_text, const char* gesture_text,
             int ticks, double delay_s = -1.0) {
  LoadResult result = load_scene_text(scene_text, {});
  REQUIRE(result.loaded != nullptr);
  std::shared_ptr<const LoadedScene> loaded(std::move(result.loaded));
  v1::Gesture gesture;
  REQUIRE(google::protobuf::TextFormat::ParseFromString(gesture_text, &gesture));
  PlayerOptions options;
  options.devices.push_back({0, profile, *parse_source("simulated")});
  options.virtual_time = true;
  auto channels = std::make_unique<LoopChannels>();
  LoopOptions loop_options;
  loop_options.virtual_time = true;
  std::unique_ptr<PlayedScene> played =
      make_played_scene(loaded, 1, plan_gesture(gesture, *loaded), options);
  if (delay_s >= 0.0) CHECK(played->tools[0].stiffness_limits.delay_s == delay_s);
  HapticLoop loop(loop_options, std::move(played), *channels);
  const auto told = std::make_unique<Tick>();
  Playing playing;
  for (int tick = 0; tick < ticks; ++tick) {
    loop.tick_once(0);
    LoopEvent event;
    while (channels->events.pop(event)) {
      if (const auto* string = std::get_if<StringEvent>(&event.what)) {
        playing.tones += string->kind == StringEventKind::kTone ? 1 : 0;
      }
    }
    while (channels->ticks.pop(*told)) {
      const ToolTick& tool = told->tools[0];
      playing.force = to_vector(tool.F_written_H_W.f).norm();
      playing.largest = std::max(playing.largest, playing.force);
      playing.computed = std::max(playing.computed, to_vector(tool.F_computed_H_W.f).norm());
      playing.bound = tool.stiffness.bound;
      playing.scale = tool.stiffness.scale;
    }
  }
  return playing;
}

std::vector<std::string> shipped() {
  std::vector<std::string> names;
  for (const auto& entry :
       std::filesystem::directory_iterator(HAPTICD_SOURCE_DIR "/deploy/devices")) {
    if (entry.path().extension() == ".textproto") names.push_back(entry.path().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Stiffness that the numbers written in a profile bear at 1 kHz, N/m, by hand.
double borne(const v1::DeviceProfile& profile) {
  const bool damped = profile.has_damping_n_s_per_m();
  const double b = damped ? profile.damping_n_s_per_m().value(0) : 1.0;
  const double delay = profile.has_delay_s() ? profile.delay_s().value(0) : 0.0;
  const double promise =
      profile.has_stiffness_max_n_per_m() ? profile.stiffness_max_n_per_m().value(0) : HUGE_VAL;
  // A damping of 0 says that nobody knows it, and counts as 0.1.
  return std::min(0.5 * (b > 0.0 ? b : 0.1) / (0.5e-3 + delay), promise);
}

DeviceSheet profile_from(const std::string& file) {
  ProfileResult result = load_profile(file, ProfileFolders{});
  for (const SceneProblem& problem : result.problems) FAIL_CHECK(to_text(problem));
  REQUIRE(result.loaded.has_value());
  return std::move(*result.loaded);
}

}  // namespace

TEST_CASE("every shipped device pushes on a wall with what its numbers bear, and sounds a string") {
  constexpr double kCoupling = 1000.0;  // kt that scenes have by default
  constexpr double kArm = 400.0;        // a light arm toward its target
  constexpr double kDepth = 5e-3;
  const std::vector<std::string> files = shipped();
  CHECK(files.size() >= 7);
  for (const std::string& file : files) {
    CAPTURE(file);
    const DeviceSheet profile = profile_from(file);
    const Playing wall = play(profile, kWallScene, kPush, 3000);
    const Playing string = play(profile, kString, kPluck, 1300);
    CHECK(string.tones > 0);
    CHECK(wall.scale >= 0.05);
    if (profile.profile.actuated_axes == 0) {
      // No motors: what is touched is computed and heard, and nothing is pushed.
      CHECK(wall.largest == 0.0);
      CHECK(wall.computed > 0.1);
      continue;
    }
    const double stiffness = std::min(kCoupling, borne(to_profile(profile)));
    CHECK(wall.bound == doctest::Approx(borne(to_profile(profile))));
    const double balance = kDepth / (1.0 / kArm + 1.0 / stiffness);
    // Friction of the device holds a part; tremor of the arm and the skin of contacts add some.
    CHECK(wall.force >= 0.85 * balance - profile.profile.coulomb_friction[2]);
    CHECK(wall.force <= 1.25 * balance);
    CHECK(string.largest > 0.0);
  }
}

TEST_CASE("where a hand feels it, a guess of a damping repays nothing and bears as one unknown") {
  LoadResult result = load_scene_text(kWallScene, {});
  REQUIRE(result.loaded != nullptr);
  std::shared_ptr<const LoadedScene> loaded(std::move(result.loaded));
  for (const std::string& file : shipped()) {
    CAPTURE(file);
    for (const bool reaches : {false, true}) {
      DeviceSheet sheet = profile_from(file);
      sheet.profile.force_reaches_hand = reaches;
      const v1::DeviceProfile told = to_profile(sheet);
      const bool guess = !told.has_damping_n_s_per_m() || told.damping_n_s_per_m().guess();
      const double stated = sheet.profile.damping;
      PlayerOptions options;
      options.devices.push_back({0, sheet, *parse_source("scripted")});
      const auto played = make_played_scene(loaded, 1, nullptr, options);
      const PlayedTool& tool = played->tools[0];
      CHECK(tool.limits.passivity.damping == (guess && reaches ? 0.0 : stated));
      const double wanted = 1000.0;
      if (!reaches) {
        // Force goes nowhere, and no stiffness is too high.
        CHECK(tool.grant.scale == 1.0);
      } else if (guess) {
        const double lag = 0.5 / sheet.profile.report_rate + sheet.profile.delay;
        const double unknown =
            std::min(200.0 * 0.5e-3 / std::max(lag, 0.5e-3), 0.5 * sheet.profile.stiffness_max);
        CHECK(tool.grant.bound == doctest::Approx(unknown));
        CHECK(tool.grant.scale == doctest::Approx(unknown / wanted));
      } else {
        CHECK(tool.grant.bound == doctest::Approx(borne(told)));
      }
      CHECK(tool.grant.bound > 0.0);
    }
  }
}

TEST_CASE("a stiffness left out is that of a very large one, whatever else is left out too") {
  const DeviceSheet ideal = profile_from(HAPTICD_SOURCE_DIR "/deploy/devices/ideal.textproto");
  for (const bool damping : {true, false}) {
    for (const bool delay : {true, false}) {
      v1::DeviceProfile open = to_profile(ideal);
      if (!damping) open.clear_damping_n_s_per_m();
      if (delay) {
        open.mutable_delay_s()->add_value(2e-3);
        open.mutable_delay_s()->set_source("a test");
      }
      v1::DeviceProfile large = open;
      large.mutable_stiffness_max_n_per_m()->add_value(1e6);
      large.mutable_stiffness_max_n_per_m()->set_source("a test");
      ProfileResult open_profile = check_profile(open);
      ProfileResult large_profile = check_profile(large);
      REQUIRE(open_profile.loaded.has_value());
      REQUIRE(large_profile.loaded.has_value());
      const Playing left_out = play(*open_profile.loaded, kWallScene, kPush, 1500);
      const Playing stated = play(*large_profile.loaded, kWallScene, kPush, 1500);
      CHECK(left_out.largest == stated.largest);
      CHECK(left_out.largest > 0.1);
      CHECK(left_out.bound == stated.bound);
    }
  }
}

TEST_CASE("a PID device whose profile states no delay is taken for one of 3 ms") {
  DeviceSheet profile = profile_from(HAPTICD_SOURCE_DIR "/deploy/devices/pid.textproto");
  v1::DeviceProfile silent = to_profile(profile);
  silent.clear_delay_s();
  ProfileResult result = check_profile(silent);
  REQUIRE(result.loaded.has_value());
  static_cast<void>(play(*result.loaded, kWallScene, kPush, 1, 3e-3));
  silent.set_driver(v1::DRIVER_SIMULATED);
  result = check_profile(silent);
  REQUIRE(result.loaded.has_value());
  static_cast<void>(play(*result.loaded, kWallScene, kPush, 1, 0.0));
}

}  // namespace hapticd::test
