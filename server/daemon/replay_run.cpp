// See replay_run.h.
#include "server/daemon/replay_run.h"

#include <utility>

#include "core/simulation/physics.h"
#include "server/recorder/state_record.h"
#include "server/recorder/tick_record.h"

namespace hapticd {

ReplayRun::ReplayRun(const std::string& path)
    : reader_(path),
      snapshot_(std::make_unique<Snapshot>()),
      replayed_(std::make_unique<Snapshot>()),
      tick_(std::make_unique<Tick>()),
      again_(std::make_unique<Tick>()) {
  summary_ = summarise(reader_);
  find_start();
}

Compared ReplayRun::compared() const noexcept {
  const std::uint32_t physics = header().has_physics() ? header().physics() : 1;
  return physics == kPhysics ? Compared::kAll : Compared::kPoses;
}

void ReplayRun::fail(const std::string& what) const {
  throw RecordingError(reader_.path() + ": " + what);
}

template <typename Message>
Message ReplayRun::parse(const RecordedMessage& message) const {
  Message parsed;
  if (!parsed.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
    fail("a " + Message::descriptor()->name() + " is damaged. Replay another recording.");
  }
  return parsed;
}

void ReplayRun::find_start() {
  RecordedMessage message;
  bool old_state = false;
  while (reader_.next(message)) {
    if (message.kind == RecordKind::kScene) {
      scene_ = parse<v1::SceneRecord>(message);
    } else if (message.kind == RecordKind::kParameters) {
      change_ = parse<v1::ParameterRecord>(message);
    } else if (message.kind == RecordKind::kTick) {
      has_tick_ = to_tick(parse<v1::TickRecord>(message), *tick_) && tick_->first &&
                  tick_->scene_id == scene_.scene_id();
      if (has_tick_) return;
      ++report_.skipped_ticks;
    } else if (message.kind == RecordKind::kSnapshot) {
      const auto snapshot = parse<v1::Snapshot>(message);
      has_snapshot_ = snapshot.scene_id() == scene_.scene_id() && to_snapshot(snapshot, *snapshot_);
      if (has_snapshot_) return;
      old_state = old_state || is_of_older_layout(snapshot);
    }
  }
  if (old_state) fail("begins with a state of hapticd 0.1; play it with that version");
  fail(
      "it has neither the first tick of a daemon nor a Snapshot, so there is nothing to start "
      "from. Record for at least a second.");
}

void ReplayRun::begin(HapticLoop& loop, LoopChannels& channels, MakeScene make_scene, bool verify) {
  loop_ = &loop;
  channels_ = &channels;
  make_scene_ = std::move(make_scene);
  verify_ = verify;
  in_step_ = true;
  if (has_snapshot_) restore(*snapshot_);
}

void ReplayRun::restore(const Snapshot& snapshot) {
  if (!loop_->restore(snapshot)) {
    fail("the Snapshot before tick " + std::to_string(snapshot.next_tick) +
         " does not fit its scene. Use the version that recorded it.");
  }
  in_step_ = true;
}

void ReplayRun::take_scene(const RecordedMessage& message) {
  scene_ = parse<v1::SceneRecord>(message);
  loop_->replace_scene(make_scene_(scene_));
}

void ReplayRun::take_snapshot(const RecordedMessage& message) {
  if (in_step_ && !verify_) return;
  const auto snapshot = parse<v1::Snapshot>(message);
  if (!to_snapshot(snapshot, *snapshot_) || snapshot_->scene_id != loop_->scene().scene_id) return;
  if (!in_step_) {
    restore(*snapshot_);
  } else if (snapshot_->next_tick == loop_->next_tick()) {
    compare_state(*snapshot_);
  }
}

// Ticks that are missing beyond those the loop passed over were lost by the recorder.
bool ReplayRun::take_tick(const RecordedMessage& message) {
  if (!to_tick(parse<v1::TickRecord>(message), *tick_)) {
    fail("a tick is damaged. Replay another recording.");
  }
  const bool follows = tick_->scene_id == loop_->scene().scene_id &&
                       tick_->tick == loop_->next_tick() + tick_->skipped;
  if (in_step_ && !follows) {
    in_step_ = false;
    ++report_.gaps;
  }
  if (!in_step_) ++report_.skipped_ticks;
  return in_step_;
}

bool ReplayRun::fetch() {
  RecordedMessage message;
  while (!has_tick_ && reader_.next(message)) {
    switch (message.kind) {
      case RecordKind::kScene:
        take_scene(message);
        break;
      case RecordKind::kParameters:
        change_ = parse<v1::ParameterRecord>(message);
        break;
      case RecordKind::kSnapshot:
        take_snapshot(message);
        break;
      case RecordKind::kTick:
        has_tick_ = take_tick(message);
        break;
      case RecordKind::kHeader:
      case RecordKind::kEvent:
        break;
    }
  }
  return has_tick_;
}

void ReplayRun::begin_change() {
  const SceneSettings& now = loop_->scene().settings;
  auto change = std::make_unique<SettingsChange>(SettingsChange{tick_->change, 0, now, now});
  if (!change_ || change_->number() != tick_->change || !get_settings(*change_, change->to) ||
      !loop_->replay_change(std::move(change))) {
    fail("the change of parameters at tick " + std::to_string(tick_->tick) +
         " is missing or damaged. Replay from a later recording.");
  }
}

void ReplayRun::play() {
  has_tick_ = false;
  if (tick_->tools.size() != loop_->scene().tools.size()) {
    fail("tick " + std::to_string(tick_->tick) + " has other tools than its scene.");
  }
  if (tick_->change != 0) begin_change();
  loop_->replay_once(*tick_);
  ++report_.ticks;
  compare_tick();
}

void ReplayRun::compare_tick() {
  while (channels_->recorded.pop(*again_)) {
    if (!verify_) continue;
    const std::string what = tick_difference(*tick_, *again_, compared());
    if (what.empty()) continue;
    ++report_.different_ticks;
    note(tick_->tick, tick_->scene_id, what);
  }
}

void ReplayRun::compare_state(const Snapshot& recorded) {
  if (compared() != Compared::kAll) return;
  ++report_.states;
  if (!loop_->fill_snapshot(*replayed_)) return;
  const std::string what = first_difference(recorded, *replayed_);
  if (what.empty()) return;
  ++report_.different_states;
  note(recorded.next_tick - 1, recorded.scene_id, "state of " + what);
}

void ReplayRun::note(std::uint64_t tick, std::uint32_t scene_id, const std::string& what) {
  if (!report_.first_difference.empty()) return;
  report_.first_difference =
      "tick " + std::to_string(tick) + " of scene " + std::to_string(scene_id) + ": " + what;
}

}  // namespace hapticd
