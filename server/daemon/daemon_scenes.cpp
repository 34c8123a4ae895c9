// Scenes: loaded off-thread, put on the air, swapped, told to everyone. See daemon.h.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>

#include "core/math/assert.h"
#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"
#include "server/scene_io/gesture_loader.h"

namespace hapticd {
namespace {

using wire::result_of;

/// What a scene is refused for.
struct Faults {
  v1::ResultCode code = v1::RESULT_CODE_INVALID;
  std::string path;  ///< of the first
  std::string text;  ///< of all
};

Faults faults_of(const LoadResult& result) {
  Faults faults;
  if (result.missing) faults = {v1::RESULT_CODE_NOT_FOUND, "name", ""};
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt) continue;
    if (faults.path.empty()) faults.path = problem.field;
    faults.text += (faults.text.empty() ? "" : "\n") + to_text(problem);
  }
  return faults;
}

}  // namespace

LoadOptions Daemon::load_options() const {
  LoadOptions load;
  load.paths = installed_paths();
  double most = kUnlimited;
  for (const ToolDevice& device : player_.devices) {
    most = std::min(most, device.profile.profile.stiffness_max);
  }
  if (most < kUnlimited) load.device_stiffness = most;
  load.quality = quality_wish();
  return load;
}

bool Daemon::simulates() const {
  return std::any_of(player_.devices.begin(), player_.devices.end(),
                     [](const ToolDevice& device) { return device.source == "simulated"; });
}

Daemon::LiveScene& Daemon::begin_playing(std::shared_ptr<const LoadedScene> loaded) {
  LiveScene scene;
  scene.id = ++last_scene_id_;
  scene.index = index_scene(*loaded->scene);
  v1::SceneInfo& info = scene.info;
  info = describe_scene(*loaded);
  info.set_scene_id(scene.id);
  info.set_rate_hz(options_.config.rate());
  info.set_clock(options_.config.clock());
  info.set_server_version(HAPTICD_VERSION);
  scene.live = loaded->message;
  leave_open(loaded->given, scene.live);
  scene.choice = loaded->given.choice;
  tell_scene(scene.live, scene.choice, info);
  scene.settings = scene_settings(loaded->scene->description());
  scene.in_force = {scene.live, scene.choice, scene.settings};
  scene.loaded = std::move(loaded);
  announce_scene(scene);
  if (playing_id_ == 0) playing_id_ = scene.id;
  scenes_.push_back(std::move(scene));
  return scenes_.back();
}

// The default gesture is for scenes it fits; one that was asked for has to fit.
std::unique_ptr<GesturePlan> Daemon::first_gesture(const LoadedScene& scene) const {
  if (!simulates()) return nullptr;
  const GestureResult result = load_gesture(options_.config.gesture(), installed_gestures());
  if (!result.gesture) {
    std::string text;
    for (const SceneProblem& problem : result.problems) text += to_text(problem) + "\n";
    throw StartError(kExitInput, text.substr(0, text.size() - 1));
  }
  try {
    std::unique_ptr<GesturePlan> plan = plan_gesture(*result.gesture, scene);
    plan->repeat = 0;
    return plan;
  } catch (const std::runtime_error& error) {
    if (options_.gesture_given) throw;
    spdlog::info("the hand rests: {}", error.what());
    return nullptr;
  }
}

const Daemon::LiveScene& Daemon::playing(std::uint32_t scene_id) const {
  for (const LiveScene& scene : scenes_) {
    if (scene.id == scene_id) return scene;
  }
  HD_ASSERT(false);
  return scenes_.front();
}

void Daemon::build_scene(std::optional<RequestId> request, const v1::LoadScene& load) {
  if (build_ || swapping_) {
    if (request) {
      server_->answer(*request, result_of(v1::RESULT_CODE_BUSY, "load_scene",
                                          "Another scene is being loaded. Try again."));
    }
    return;
  }
  LoadOptions options = load_options();
  if (load.has_preset()) options.preset = load.preset();
  // Of the configuration the name may be any file's; a peer's is an installed scene's.
  const bool any_file = !request;
  build_ = SceneBuild{request, load.check_only(),
                      std::async(std::launch::async, [load, options, any_file] {
                        if (load.has_text()) return load_scene_text(load.text(), options);
                        return any_file ? load_scene(load.name(), options)
                                        : load_installed_scene(load.name(), options);
                      })};
}

void Daemon::finish_build() {
  if (!build_ || build_->result.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return;
  }
  SceneBuild build = std::move(*build_);
  build_.reset();
  const auto fail = [&](v1::ResultCode code, const std::string& path, const std::string& message) {
    if (build.request) {
      server_->answer(*build.request, result_of(code, path, message));
    } else {
      spdlog::error("{}", message);
    }
  };
  LoadResult result;
  try {
    result = build.result.get();
  } catch (const std::exception& error) {
    fail(v1::RESULT_CODE_FAILED, "load_scene", error.what());
    return;
  }
  if (result.loaded == nullptr) {
    const Faults faults = faults_of(result);
    fail(faults.code, faults.path, faults.text);
    return;
  }
  if (build.check_only) {
    server_->answer(*build.request, result_of(v1::RESULT_CODE_OK, "", ""));
    return;
  }
  try {
    std::shared_ptr<const LoadedScene> loaded(std::move(result.loaded));
    std::unique_ptr<GesturePlan> gesture;
    try {
      gesture = first_gesture(*loaded);
    } catch (const std::runtime_error& error) {
      spdlog::info("the hand rests: {}", error.what());
    }
    std::unique_ptr<PlayedScene> played =
        make_played_scene(loaded, last_scene_id_ + 1, std::move(gesture), player_);
    swap_to(std::move(loaded), std::move(played), build.request);
  } catch (const std::runtime_error& error) {
    fail(v1::RESULT_CODE_INVALID, "load_scene", error.what());
  }
}

void Daemon::swap_to(std::shared_ptr<const LoadedScene> loaded, std::unique_ptr<PlayedScene> played,
                     std::optional<RequestId> request) {
  begin_playing(std::move(loaded));
  const std::uint64_t number = ++last_command_;
  if (!channels_->commands.push({number, SwapSceneCommand{played.get()}})) {
    scenes_.pop_back();
    throw std::runtime_error("The loop has too many commands to obey. Try again.");
  }
  static_cast<void>(played.release());  // the loop's from here on
  swapping_ = true;
  if (request) commands_.emplace_back(number, *request);
  if (!virtual_time_) return;
  loop_->take_commands();
  hash_ = StateHash{};
  take_events();
}

void Daemon::finish_swap(std::uint32_t scene_id) {
  playing_id_ = scene_id;
  swapping_ = false;
  next_pose_ticks_ = {};
  change_tick_ = 0;
  v1::Item item;
  *item.mutable_scene_info() = playing(playing_id_).info;
  server_->broadcast(item);
}

}  // namespace hapticd
