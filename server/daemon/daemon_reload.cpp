// The configuration read anew, at SIGHUP: what a client could change in flight changes, as it would
// for a client; what belongs to the start stays, and the log names it. See daemon.h.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "server/daemon/daemon.h"

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

}  // namespace

void Daemon::reload() {
  DaemonOptions read = options_;
  try {
    settle_config(read);
  } catch (const StartError& error) {
    spdlog::error("reload: {}", error.what());
    return;
  }
  std::string later;
  bool recording_differs = false;
  const google::protobuf::Descriptor& type = *v1::Config::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const google::protobuf::FieldDescriptor* field = type.field(i);
    const v1::Config wanted = alone(read.config, field);
    if (wanted.SerializeAsString() == alone(options_.config, field).SerializeAsString()) continue;
    const bool of_scene =
        std::find(kOfScenes.begin(), kOfScenes.end(), field->name()) != kOfScenes.end();
    if (of_scene || field->name() == kRecord) {
      recording_differs = recording_differs || !of_scene;
      options_.config.GetReflection()->ClearField(&options_.config, field);
      options_.config.MergeFrom(wanted);
    } else {
      later += (later.empty() ? "" : ", ") + field->name();
    }
  }
  options_.gesture_given = read.gesture_given;
  if (!later.empty()) spdlog::warn("reload: takes effect at the next start only: {}", later);
  follow_config(options_.config, player_);
  report_budget();
  if (recording_differs && options_.config.record().empty()) recording_->stop();
  if (recording_differs && !options_.config.record().empty()) {
    recording_->stop();
    recording_->start(options_.config.record());
  }
  spdlog::info("reload: scene {}", options_.config.scene());
  reload_waits_ = true;
}

// A scene that a client has loaded, or is loading, comes first.
void Daemon::reload_scene() {
  if (!reload_waits_ || build_ || swapping_) return;
  reload_waits_ = false;
  v1::LoadScene load;
  load.set_name(options_.config.scene());
  build_scene(std::nullopt, load);
}

}  // namespace hapticd
