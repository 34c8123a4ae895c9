// See daemon_plan.h.
#include "server/daemon/daemon_plan.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "server/scene_io/profile_loader.h"

namespace hapticd {
namespace {

/// Fields that take effect with the scene, which is loaded anew.
constexpr std::array<std::string_view, 7> kOfScenes{"scene", "quality", "budget_us", "gesture",
                                                    "arm",   "seed",    "max_force"};
/// The field that starts and ends the recording of the session.
constexpr std::string_view kRecord = "record";

/// `field` of `config` and nothing else.
v1::Config alone(v1::Config config, const google::protobuf::FieldDescriptor* field) {
  const google::protobuf::Descriptor& type = *v1::Config::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    if (type.field(i) != field) config.GetReflection()->ClearField(&config, type.field(i));
  }
  return config;
}

QualityWish quality_wish(const DaemonPlan& plan) {
  const v1::Config& config = plan.options.config;
  QualityWish wish;
  wish.usual_budget_us = usual_budget_us(plan.player);
  if (config.budget_us() > 0.0) wish.budget_us = config.budget_us();
  if (config.quality().empty()) return wish;
  wish.quality.emplace();
  if (config.quality() == "auto") {
    wish.quality->mutable_automatic();
  } else {
    wish.quality->set_level(static_cast<std::uint32_t>(std::stoul(config.quality())));
  }
  return wish;
}

}  // namespace

PlayerOptions player_options(const v1::Config& config) {
  PlayerOptions player;
  for (const v1::DeviceChoice& device : config.device()) {
    ProfileResult profile = load_profile(device.profile(), installed_profiles());
    if (!profile.loaded) {
      std::string text;
      for (const SceneProblem& problem : profile.problems) text += to_text(problem) + "\n";
      throw StartError(kExitInput, text.substr(0, text.size() - 1));
    }
    player.devices.push_back(
        {device.tool_id(), std::move(*profile.loaded), *parse_source(device.source())});
  }
  player.period_ns = std::llround(1e9 / config.rate());
  player.virtual_time = config.clock() == v1::CLOCK_MODE_VIRTUAL;
  if (!config.inject().empty()) player.injection = parse_injection(config.inject());
  follow_config(config, player);
  return player;
}

PlayerOptions recorded_player(const v1::RecordHeader& header) {
  PlayerOptions player;
  const v1::Config& config = header.config();
  for (int k = 0; k < header.devices_size(); ++k) {
    const v1::RecordedDevice& device = header.devices(k);
    ProfileResult profile = check_profile(device.profile());
    if (!profile.loaded || k >= config.device_size()) {
      throw StartError(kExitInput, "the recording's device profile is not valid in this version: " +
                                       faults_text(profile.problems) +
                                       ". Use the version that recorded it.");
    }
    ToolDevice tool{
        device.tool_id(), std::move(*profile.loaded), {&driver_entry(DeviceDriver::kReplay), ""}};
    tool.recorded = recorded_driver(config.device(k).source(), tool.sheet.profile);
    player.devices.push_back(std::move(tool));
  }
  if (player.devices.empty()) {
    throw StartError(kExitInput, "the recording names no device. Replay another one.");
  }
  player.period_ns =
      static_cast<std::int64_t>(std::clamp<std::uint64_t>(header.period_ns(), 100'000, 4'000'000));
  player.virtual_time = config.clock() == v1::CLOCK_MODE_VIRTUAL;
  return player;
}

LoadOptions load_options(const DaemonPlan& plan) {
  LoadOptions load;
  load.paths = installed_paths();
  double most = kUnlimited;
  for (const ToolDevice& device : plan.player.devices) {
    most = std::min(most, device.sheet.profile.stiffness_max);
  }
  if (most < kUnlimited) load.device_stiffness = most;
  load.quality = quality_wish(plan);
  return load;
}

bool simulates(const PlayerOptions& player) {
  return std::any_of(player.devices.begin(), player.devices.end(),
                     [](const ToolDevice& device) { return device.source.driver->plays_gestures; });
}

void warn_of_no_bound(const PlayerOptions& player) {
  if (player.budget_us != 0.0) return;
  spdlog::warn(
      "--budget-us 0: the work of a tick has no bound, so fast or deep contact may make it late; "
      "leave the option out to bound it to half the tick");
}

Reread reread(DaemonPlan& plan) {
  v1::Config& config = plan.options.config;
  DaemonOptions read = plan.options;
  try {
    settle_config(read);
  } catch (const StartError& error) {
    spdlog::error("reload: {}", error.what());
    return {};
  }
  std::string later;
  bool recording_differs = false;
  const google::protobuf::Descriptor& type = *v1::Config::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const google::protobuf::FieldDescriptor* field = type.field(i);
    const v1::Config wanted = alone(read.config, field);
    if (wanted.SerializeAsString() == alone(config, field).SerializeAsString()) continue;
    const bool of_scene =
        std::find(kOfScenes.begin(), kOfScenes.end(), field->name()) != kOfScenes.end();
    if (of_scene || field->name() == kRecord) {
      recording_differs = recording_differs || !of_scene;
      config.GetReflection()->ClearField(&config, field);
      config.MergeFrom(wanted);
    } else {
      later += (later.empty() ? "" : ", ") + field->name();
    }
  }
  plan.options.gesture_given = read.gesture_given;
  if (!later.empty()) spdlog::warn("reload: takes effect at the next start only: {}", later);
  follow_config(config, plan.player);
  warn_of_no_bound(plan.player);
  return {true, recording_differs};
}

}  // namespace hapticd
