// See loop_run.h.
#include "tests/server/haptic_loop/loop_run.h"

#include <doctest/doctest.h>

#include "server/scene_io/profile_loader.h"

namespace hapticd::test {

const char* const kStringScene = R"(
name: "string"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0.01534, 0] }
}
strings { name: "C2" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] frequency_hz: 65.4 }
vibration {}
tones {}
)";

const char* const kThreeFingerScene = R"(
name: "fingers"
tools {
  tool_id: 7
  name: "finger_7"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [-0.1, 0, 0.025] }
}
tools {
  tool_id: 2
  name: "finger_2"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0, 0.025] }
  coupling { kt_n_per_m: 500 }
}
tools {
  tool_id: 30
  name: "finger_30"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0.1, 0, 0.025] }
}
bodies { name: "wall" shape { spheres { centre_m: [0, 0, -1000] radius_m: 1000 } } }
)";

std::unique_ptr<PlayedScene> played_scene(const std::string& text, std::uint32_t scene_id,
                                          const LoopSetting& setting) {
  LoadResult result = load_scene_text(text, {});
  REQUIRE(result.loaded != nullptr);
  PlayerOptions options;
  const ProfileResult profile = load_profile(
      HAPTICD_SOURCE_DIR "/deploy/devices/" + setting.profile + ".textproto", ProfileFolders{});
  REQUIRE(profile.loaded.has_value());
  options.devices.push_back({0, *profile.loaded, *parse_source(setting.source)});
  options.virtual_time = !setting.real_time;
  options.budget_us = setting.budget_us;
  return make_played_scene(std::move(result.loaded), scene_id, nullptr, options);
}

LoopRun::LoopRun(const std::string& scene, const LoopSetting& setting) {
  LoopOptions options;
  options.virtual_time = !setting.real_time;
  options.guards_armed = setting.guards_armed;
  loop_ = std::make_unique<HapticLoop>(options, played_scene(scene, 1, setting), *channels_);
}

const ToldTick& LoopRun::tick(const Vector3& p_WH) { return tick_all({&p_WH, 1}); }

const ToldTick& LoopRun::tick_all(std::span<const Vector3> p_WH) {
  for (std::size_t k = 0; k < p_WH.size(); ++k) {
    TickPose pose;
    pose.tick = loop_->next_tick();
    pose.tool = static_cast<std::uint32_t>(k);
    pose.pose.p_DH = to_array(p_WH[k]);
    REQUIRE(channels_->poses.push(pose));
  }
  return tick();
}

const ToldTick& LoopRun::tick() {
  now_ns_ += 1'000'000;
  loop_->tick_once(now_ns_);
  told_.events.clear();
  LoopEvent event;
  while (channels_->events.pop(event)) {
    told_.events.push_back(event);
  }
  while (channels_->scenes.back.pop() != nullptr || channels_->gestures.back.pop() != nullptr ||
         channels_->changes.back.pop() != nullptr) {
  }
  while (channels_->ticks.pop(told_.tick)) {
  }
  return told_;
}

void LoopRun::send(const LoopCommandBody& what) {
  REQUIRE(channels_->commands.push({++commands_, what}));
}

void LoopRun::swap_to(std::unique_ptr<PlayedScene> scene) {
  REQUIRE(channels_->scenes.lent.push(scene));
  send(SwapSceneCommand{});
}

void LoopRun::play(std::unique_ptr<GesturePlan> plan) {
  REQUIRE(channels_->gestures.lent.push(plan));
  send(PlayGestureCommand{});
}

void LoopRun::change(std::unique_ptr<SettingsChange> change) {
  REQUIRE(channels_->changes.lent.push(change));
  send(ChangeSettingsCommand{});
}

void LoopRun::engage(const Vector3& p_WH) {
  for (int k = 0; k < 250; ++k) tick(p_WH);
  REQUIRE(told_.tick.state == LoopState::kEngaged);
}

}  // namespace hapticd::test
