// See recorded_session.h.
#include "tests/server/daemon/recorded_session.h"

#include <doctest/doctest.h>
#include <google/protobuf/text_format.h>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/simulation/physics.h"
#include "proto/recording/schema_set.h"
#include "server/daemon/daemon_plan.h"
#include "server/haptic_loop/settings_change.h"
#include "server/recorder/recorder_thread.h"
#include "server/recorder/state_record.h"
#include "server/scene_io/profile_loader.h"
#include "server/scene_io/sheet_translation.h"
#include "tests/support/random.h"

namespace hapticd::test {

namespace {

constexpr const char* kStrings = R"(
name: "strings"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0.02, 0] }
}
strings { name: "C2" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] frequency_hz: 65.4 }
strings { name: "G2" p_wa_m: [-0.55, 0, 0.02] p_wb_m: [0.55, 0, 0.02] frequency_hz: 98 }
vibration {}
tones {}
)";

v1::SceneRecord scene_record(const char* text, std::uint32_t id) {
  LoadResult result = load_scene_text(text, {});
  REQUIRE(result.loaded != nullptr);
  v1::SceneRecord record;
  record.set_scene_id(id);
  *record.mutable_scene() = result.loaded->message;
  return record;
}

std::unique_ptr<PlayedScene> make_scene(const v1::SceneRecord& record,
                                        const PlayerOptions& options) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(record.scene(), &text);
  LoadResult result = load_scene_text(text, {});
  REQUIRE(result.loaded != nullptr);
  return make_played_scene(std::move(result.loaded), record.scene_id(), nullptr, options);
}

v1::RecordHeader header_of(bool virtual_time) {
  v1::RecordHeader header;
  header.set_period_ns(1'000'000);
  header.set_physics(kPhysics);
  header.mutable_config()->set_clock(virtual_time ? v1::CLOCK_MODE_VIRTUAL
                                                  : v1::CLOCK_MODE_REALTIME);
  header.mutable_config()->add_device()->set_source("scripted");
  const ProfileResult profile =
      load_profile(HAPTICD_SOURCE_DIR "/deploy/devices/ideal.textproto", ProfileFolders{});
  REQUIRE(profile.loaded.has_value());
  *header.add_devices()->mutable_profile() = to_profile(*profile.loaded);
  return header;
}

/// Where the hand is in a tick: presses a string aside and lets it slip, again and again; in the
/// second scene it goes into the wall and out.
Vector3 hand_at(int tick, std::uint32_t scene) {
  const double t = 1e-3 * tick;
  if (scene == 2) return {0.0, 1e-3 * std::sin(7.0 * t), 0.006 + 0.004 * std::sin(9.0 * t)};
  const double y = 0.0062 - 0.004 * std::sin(6.0 * t);
  return {0.05 * std::sin(t), tick < 260 ? 0.02 : y, 0.01 + 0.012 * std::sin(2.3 * t)};
}

/// Takes all that the loop has told and given back.
void empty(LoopChannels& channels) {
  LoopEvent event;
  while (channels.events.pop(event)) {
  }
  while (channels.scenes.back.pop() != nullptr || channels.changes.back.pop() != nullptr) {
  }
  const auto told = std::make_unique<Tick>();
  while (channels.ticks.pop(*told)) {
  }
}

class Session {
 public:
  Session(const std::string& path, bool virtual_time)
      : virtual_time_(virtual_time), header_(header_of(virtual_time)) {
    player_ = recorded_player(header_);
    for (ToolDevice& device : player_.devices) device.source = *parse_source("scripted");
    recorder_ = std::make_unique<RecorderThread>(*channels_, header_);
    const v1::SceneRecord first = scene_record(kStrings, 1);
    std::unique_ptr<PlayedScene> played = make_scene(first, player_);
    recorder_->announce(first, index_scene(*played->scene));
    recorder_->start(path);
    LoopOptions options;
    options.virtual_time = virtual_time;
    loop_ = std::make_unique<HapticLoop>(options, std::move(played), *channels_);
  }

  void run() {
    for (int k = 0; k < kSessionTicks; ++k) {
      act(k);
      tick(k);
    }
  }

 private:
  void send(const LoopCommandBody& what) { REQUIRE(channels_->commands.push({++commands_, what})); }

  void change(double kt, double tension) {
    const SceneSettings& now = loop_->scene().settings;
    auto change = std::make_unique<SettingsChange>(SettingsChange{0, 0, now, now});
    change->to.tools[0].coupling.kt = kt;
    for (StringParameters& piece : change->to.pieces) piece.tension = tension;
    v1::ParameterRecord record;
    record.set_number(commands_ + 1);
    put_settings(change->to, record);
    recorder_->announce_change(std::move(record));
    REQUIRE(channels_->changes.lent.push(change));
    send(ChangeSettingsCommand{});
  }

  void act(int tick) {
    // Now enough work for one linearisation, now any.
    if (tick % 40 == 20) send(WorkBudgetCommand{tick % 80 == 20 ? 1 : 0});
    if (tick == 600) change(700.0, 33.0);
    if (tick == 630) change(1100.0, 29.0);
    if (tick == 800 || tick == 2900) send(DisengageCommand{});
    if (tick == 900 || tick == 3000) send(EngageCommand{});
    if (tick == 1100) send(StopCommand{});
    if (tick == 1150 || tick == 1450) send(ClearCommand{});
    if (tick == 1500) send(ClutchCommand{0, true});
    if (tick == 1600) send(ClutchCommand{0, false});
    if (tick == 1700) send(RecentreCommand{});
    if (tick == 400) send(PushCommand{0, 4});
    if (tick == 1850) send(PushCommand{0, 1});  // a Snapshot finds it under way; the swap ends it
    if (tick == 2500) send(PushCommand{0, 5});  // Disengage ends it
    if (tick == 1980) change(900.0, 31.0);
    if (tick != 2100) return;
    const v1::SceneRecord second = scene_record(kWallScene, 2);
    std::unique_ptr<PlayedScene> scene = make_scene(second, player_);
    recorder_->announce(second, index_scene(*scene->scene));
    REQUIRE(channels_->scenes.lent.push(scene));
    send(SwapSceneCommand{});
  }

  void tick(int k) {
    if (virtual_time_ && k == 2100) loop_->take_commands();  // the scene is exchanged at once
    TickPose pose;
    pose.tick = loop_->next_tick();
    pose.pose.p_DH = to_array(hand_at(k, loop_->scene().scene_id));
    if (k >= 1400 && k < 1405) pose.pose.p_DH[1] = std::numeric_limits<double>::quiet_NaN();
    pose.pose.buttons = static_cast<std::uint16_t>(k / 700);
    // Now and then no pose comes; under real time that tick has no sample.
    if (k % 97 != 5) REQUIRE(channels_->poses.push(pose));
    std::uint64_t skipped = 0;
    if (!virtual_time_ && random_.chance(0.02)) skipped = 1 + random_.below(2);
    now_ns_ +=
        static_cast<std::int64_t>(1'000'000 * (1 + skipped) + random_.below(60'000)) - 30'000;
    loop_->tick_once(now_ns_, skipped);
    recorder_->make_room();
    empty(*channels_);
  }

  bool virtual_time_;
  v1::RecordHeader header_;
  PlayerOptions player_;
  std::unique_ptr<LoopChannels> channels_ = std::make_unique<LoopChannels>();
  std::unique_ptr<HapticLoop> loop_;
  std::unique_ptr<RecorderThread> recorder_;
  SplitMix64 random_{5};
  std::int64_t now_ns_ = 77'000'000'000;
  std::uint64_t commands_ = 0;
};

/// Writes messages as a recorder does.
class Copy {
 public:
  Copy(const std::string& path, const v1::RecordHeader& header) {
    REQUIRE(writer_.open(path, "test"));
    const std::array<std::pair<std::string_view, const google::protobuf::Descriptor*>, 6> kinds{
        {{kHeaderTopic, v1::RecordHeader::descriptor()},
         {kSceneTopic, v1::SceneRecord::descriptor()},
         {kParameterTopic, v1::ParameterRecord::descriptor()},
         {kTickTopic, v1::TickRecord::descriptor()},
         {kEventTopic, v1::EventRecord::descriptor()},
         {kSnapshotTopic, v1::Snapshot::descriptor()}}};
    for (const auto& [topic, type] : kinds) {
      writer_.add_channel(topic, type->full_name(), schema_set(*type));
    }
    write(RecordKind::kHeader, header.SerializeAsString());
  }
  ~Copy() { writer_.close(); }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;

  void write(RecordKind kind, std::string_view bytes) {
    writer_.write(static_cast<std::uint16_t>(static_cast<int>(kind) + 1), 0, bytes);
  }

 private:
  McapWriter writer_;
};

}  // namespace

void record_session(const std::string& path, bool virtual_time) {
  Session session(path, virtual_time);
  session.run();
}

std::unique_ptr<PlayedScene> replayed_scene(const v1::SceneRecord& record,
                                            const v1::RecordHeader& header) {
  return make_scene(record, recorded_player(header));
}

ReplayReport verify(const std::string& path) {
  ReplayRun run(path);
  const auto channels = std::make_unique<LoopChannels>();
  LoopOptions options;
  options.virtual_time = run.header().config().clock() == v1::CLOCK_MODE_VIRTUAL;
  options.snapshots = false;
  HapticLoop loop(options, replayed_scene(run.first_scene(), run.header()), *channels);
  run.begin(
      loop, *channels,
      [&](const v1::SceneRecord& record) { return replayed_scene(record, run.header()); }, true);
  while (run.fetch()) {
    run.play();
    empty(*channels);
  }
  return run.report();
}

std::vector<CopiedMessage> messages_of(const std::string& path) {
  RecordingReader reader(path);
  std::vector<CopiedMessage> messages;
  messages.reserve(std::size_t{2} * kSessionTicks);
  RecordedMessage message;
  while (reader.next(message)) messages.push_back({message.kind, std::string(message.data)});
  return messages;
}

void write_recording(const std::string& path, const v1::RecordHeader& header,
                     const std::vector<CopiedMessage>& messages) {
  Copy copy(path, header);
  for (const CopiedMessage& message : messages) copy.write(message.kind, message.bytes);
}

bool copy_from_snapshot(const std::string& from, int snapshot, const std::string& to) {
  std::vector<CopiedMessage> kept;
  std::string scene;
  int seen = 0;
  for (CopiedMessage& message : messages_of(from)) {
    if (kept.empty() && message.kind == RecordKind::kScene) scene = message.bytes;
    if (message.kind == RecordKind::kSnapshot && seen++ == snapshot) {
      kept.push_back({RecordKind::kScene, scene});
    }
    if (!kept.empty()) kept.push_back(std::move(message));
  }
  if (!kept.empty()) write_recording(to, RecordingReader(from).header(), kept);
  return !kept.empty();
}

void copy_changed(const std::string& from, const std::string& to,
                  const std::function<bool(v1::TickRecord&)>& change) {
  std::vector<CopiedMessage> kept;
  for (CopiedMessage& message : messages_of(from)) {
    if (message.kind == RecordKind::kTick) {
      v1::TickRecord tick;
      REQUIRE(tick.ParseFromString(message.bytes));
      if (!change(tick)) continue;
      message.bytes = tick.SerializeAsString();
    }
    kept.push_back(std::move(message));
  }
  write_recording(to, RecordingReader(from).header(), kept);
}

}  // namespace hapticd::test
