// A recording takes the place of devices, clients and clock: scenes, settings and everything else
// that the bits depend on are the recording's. See daemon.h, replay_run.h.
#include <google/protobuf/text_format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Ticks between two looks at the socket.
constexpr int kTicksPerLook = 64;

/// The driver that was behind a recorded device.
DeviceDriver recorded_driver(const std::string& source, const DeviceProfile& profile) {
  if (source == "simulated") return DeviceDriver::kSimulated;
  if (source == "scripted") return DeviceDriver::kScripted;
  return profile.driver;
}

/// The first file of a recorded scene that is not the same here; empty: all are.
std::string changed_asset(const v1::SceneRecord& record, const LoadedScene& loaded) {
  for (const v1::Asset& asset : record.assets()) {
    const auto same = [&](const SceneAsset& here) {
      return here.name == asset.name() &&
             std::equal(here.hash.begin(), here.hash.end(), asset.hash().begin(),
                        asset.hash().end(),
                        [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
    };
    if (std::none_of(loaded.assets.begin(), loaded.assets.end(), same)) return asset.name();
  }
  return "";
}

}  // namespace

std::unique_ptr<ReplayRun> open_replay(DaemonOptions& options) {
  const std::string& source = options.config.device(0).source();
  if (source.rfind(kReplaySource, 0) != 0) return nullptr;
  try {
    auto replay = std::make_unique<ReplayRun>(source.substr(kReplaySource.size()));
    v1::Config config = replay->header().config();
    config.set_clock(options.config.clock());
    config.set_listen(options.config.listen());
    config.set_keys(options.config.keys());
    config.set_verify(options.config.verify());
    config.clear_record();
    options.config = std::move(config);
    return replay;
  } catch (const RecordingError& error) {
    throw StartError(kExitInput, error.what());
  }
}

PlayerOptions recorded_player(const v1::RecordHeader& header) {
  PlayerOptions player;
  const v1::Config& config = header.config();
  for (int k = 0; k < header.devices_size(); ++k) {
    const v1::RecordedDevice& device = header.devices(k);
    ProfileResult profile = check_profile(device.profile());
    if (!profile.loaded || k >= config.device_size()) {
      throw StartError(kExitInput,
                       "the recording's device profile does not hold in this version: " +
                           faults_text(profile.problems) + ". Use the version that recorded it.");
    }
    ToolDevice tool{device.tool_id(), std::move(*profile.loaded), "replay"};
    tool.recorded = recorded_driver(config.device(k).source(), tool.profile.profile);
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

std::unique_ptr<PlayedScene> Daemon::make_recorded_scene(const v1::SceneRecord& record) {
  const std::string which =
      replay_->path() + ": scene " + std::to_string(record.scene_id()) + " of the recording ";
  std::string text;
  google::protobuf::TextFormat::PrintToString(record.scene(), &text);
  LoadOptions options = load_options();
  options.quality = {};
  options.longest_info = std::numeric_limits<std::size_t>::max();  // It was played.
  options.paths.models.insert(options.paths.models.begin(),
                              std::filesystem::path(replay_->path()).parent_path());
  LoadResult result = load_scene_text(text, options);
  if (result.loaded == nullptr) {
    throw StartError(kExitInput, which + "cannot be played here:\n" + faults_text(result.problems));
  }
  const std::string asset = changed_asset(record, *result.loaded);
  if (!asset.empty()) {
    throw StartError(kExitInput, which + "was made with another " + asset +
                                     " than the one here. Install the assets it was recorded "
                                     "with, or put the file beside the recording.");
  }
  if (result.loaded->message.SerializeAsString() != record.scene().SerializeAsString()) {
    throw StartError(kExitInput,
                     which + "means something else to this version. Use the one that recorded it.");
  }
  last_scene_id_ = record.scene_id() - 1;
  LiveScene& scene = begin_playing(std::move(result.loaded));
  scene.info.set_hash(record.hash());
  player_.max_force = record.has_max_force_n() ? record.max_force_n() : kUnlimited;
  return make_played_scene(scene.loaded, scene.id, nullptr, player_);
}

void Daemon::begin_replay() {
  try {
    replay_->begin(
        *loop_, *channels_,
        [this](const v1::SceneRecord& record) { return make_recorded_scene(record); },
        options_.config.verify());
  } catch (const RecordingError& error) {
    throw StartError(kExitInput, error.what());
  }
}

bool Daemon::pass_replay(std::int64_t now_ns) {
  if (ending_since_ns_ >= 0) return false;
  const bool paced = options_.config.clock() == v1::CLOCK_MODE_REALTIME;
  try {
    for (int k = 0; k < kTicksPerLook; ++k) {
      if (!paced && !server_->may_step(now_ns)) return false;
      if (!replay_->fetch()) {
        end_replay(now_ns);
        return false;
      }
      const auto dt_ns = static_cast<std::int64_t>(replay_->tick().dt_ns);
      if (live_due_ns_ == 0) live_due_ns_ = now_ns - dt_ns;
      if (paced && live_due_ns_ + dt_ns > now_ns) return false;
      live_due_ns_ += dt_ns;
      replay_->play();
      take_events();
      take_snapshots(now_ns);
    }
  } catch (const std::runtime_error& error) {
    spdlog::error("the replay ends: {}", error.what());
    exit_code_ = kExitInput;
    end_replay(now_ns);
    return false;
  }
  return true;
}

void Daemon::end_replay(std::int64_t now_ns) {
  const ReplayReport& report = replay_->report();
  const RecordingSummary& summary = replay_->summary();
  spdlog::info("replayed {} of {} ticks of {}", report.ticks, summary.ticks, replay_->path());
  if (report.skipped_ticks > 0) {
    spdlog::warn("{} ticks were not played: {}", report.skipped_ticks,
                 report.gaps > 0 ? "the recorder had lost some before them"
                                 : "there was no Snapshot before them");
  }
  if (!summary.complete) spdlog::warn("the recording was not closed: {}", summary.end);
  if (options_.config.verify()) {
    const bool same = report.different_ticks == 0 && report.different_states == 0;
    if (same) {
      spdlog::info("identical: every wrench to the bit, and {} states", report.states);
    } else {
      spdlog::error("different: {} of {} ticks and {} of {} states; the first is {}",
                    report.different_ticks, report.ticks, report.different_states, report.states,
                    report.first_difference);
      if (exit_code_ == kExitGood) exit_code_ = kExitReplay;
    }
  }
  ending_since_ns_ = now_ns;
  server_->shut_down(v1::BYE_REASON_SHUTDOWN, "The replay is over.", now_ns);
}

void Daemon::fill_replay(v1::State& state) const {
  if (!replay_) return;
  v1::ReplayState& replay = *state.mutable_replay();
  replay.set_tick(snapshot_->tick);
  replay.set_last_tick(replay_->summary().last_tick);
  replay.set_different_ticks(replay_->report().different_ticks);
}

bool Daemon::refuse_in_replay(const RequestId& id, const v1::Item& item) {
  if (!replay_) return false;
  switch (item.body_case()) {
    case v1::Item::kGetParameters:
    case v1::Item::kListScenes:
    case v1::Item::kListGestures:
    case v1::Item::kListRecordings:
    case v1::Item::kGetDeviceInfo:
    case v1::Item::kReplay:
      return false;
    default:
      break;
  }
  server_->answer(
      id, result_of(v1::RESULT_CODE_WRONG_STATE, "",
                    "A recording is being replayed: nothing but what was recorded reaches it."));
  return true;
}

void Daemon::answer_replay(const RequestId& id, const v1::Replay& replay) {
  if (replay.file().empty() && replay_) {
    end_requested_ = true;
    return server_->answer(id, result_of(v1::RESULT_CODE_OK));
  }
  const char* why =
      "Devices play. A replay has a daemon of its own: hapticctl replay, or hapticd --device "
      "replay:FILE.";
  if (replay_) {
    why = "Another recording is being replayed. End it first, with an empty name.";
  } else if (replay.file().empty()) {
    why = "No replay runs.";
  }
  server_->answer(id, result_of(v1::RESULT_CODE_WRONG_STATE, "replay.file", why));
}

}  // namespace hapticd
