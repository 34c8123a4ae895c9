// All that the loop keeps from tick to tick, written down and taken back, and the ticks of a
// replay. See haptic_loop.h. RT: yes, but for restore().
#include <algorithm>
#include <memory>

#include "core/safety/safety_fields.h"
#include "core/simulation/simulation_fields.h"
#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {

// What nothing is computed from is left out, as in the ticks of a recording.
template <FieldsOf<DeviceSample> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [t_ns, counter, p_DH, q_DH, v_DH_D, w_DH_D, grip_m, temperature_deg_c, measured_delay_s,
         buttons, flags, has_velocity] = state;
  visit(t_ns, counter, p_DH, q_DH, measured_delay_s, buttons, flags, has_velocity);
  if (has_velocity) visit(v_DH_D, w_DH_D);
  static_cast<void>(grip_m);
  static_cast<void>(temperature_deg_c);
}

namespace {

/// Time between two snapshots, ns. Longer: a replay of the last minute begins later in it.
constexpr std::int64_t kSnapshotEvery_ns = 1'000'000'000;

/// Awake strings, as the block of the simulation has them.
using AwakeStrings = FixedVector<std::int32_t, kMaxStrings>;

/// The part of the snapshot that settings are; the strings' are with the first tool.
struct SettingsView {
  const SceneSettings& settings;
  std::size_t tool;
};

HD_REALTIME void visit_fields(const SettingsView& view, StateWriter& visit) noexcept {
  visit(view.settings.tools[view.tool]);
  if (view.tool != 0) return;
  for (const StringParameters& piece : view.settings.pieces) visit(piece);
}

struct SettingsPlace {
  SceneSettings& settings;
  std::size_t tool;
};

void visit_fields(SettingsPlace& place, StateReader& visit) noexcept {
  visit(place.settings.tools[place.tool]);
  if (place.tool != 0) return;
  for (StringParameters& piece : place.settings.pieces) visit(piece);
}

/// A string and how every tool sees it.
template <typename Track, typename Visits>
struct WholeString {
  Track& track;
  Visits& visits;
  std::size_t strings;
  std::size_t string;
  std::size_t tools;
};

template <typename Track, typename Visits, typename Visit>
HD_REALTIME void visit_fields(const WholeString<Track, Visits>& whole, Visit& visit) noexcept {
  visit(whole.track);
  for (std::size_t k = 0; k < whole.tools; ++k) {
    visit(whole.visits[k * whole.strings + whole.string]);
  }
}

/// Names of what is touched, as events will tell them.
bool names_things(const TouchDetector& detector, const SceneDescription& scene, std::size_t tool,
                  const ToolScene& play) {
  for (const TouchEvent& touch : detector.touches) {
    const std::size_t things =
        is_string(touch.kind) ? play.obstacles.capsules_W.size() : play.obstacles.bodies.size();
    if (touch.obstacle < 0 || static_cast<std::size_t>(touch.obstacle) >= things ||
        touch.part < 0 || static_cast<std::size_t>(touch.part) >= scene.tools[tool].parts.size()) {
      return false;
    }
  }
  return true;
}

/// Strings and tools that there are.
bool names_holders(const StringSharing& all, std::size_t strings, std::size_t tools) {
  const auto below = [](std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  for (const SharedString& holders : all) {
    if (!below(holders.string, strings)) return false;
    for (const std::int32_t tool : holders.tools) {
      if (!below(tool, tools)) return false;
    }
  }
  return true;
}

/// Parts of strings that there are.
bool names_parts(const StringSegments& view) {
  const auto below = [](std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  for (const StringPart& part : view.parts) {
    if (!below(part.string, view.strings.size()) || !below(part.slot, kMaxTools)) return false;
  }
  return true;
}

}  // namespace

bool HapticLoop::fill_snapshot(Snapshot& snapshot) const noexcept {
  const PlayedScene& scene = *scene_;
  snapshot.next_tick = time_.tick;
  snapshot.scene_id = scene.scene_id;
  snapshot.loop_state = machine_.state;
  const auto tool_number = [](std::size_t k) { return static_cast<std::uint32_t>(k); };
  SnapshotWriter write(snapshot);
  const bool ramps = change_ != nullptr;
  write.add(StateKind::kLoop, 0, time_.t_ns, first_tick_, machine_, overrun_watch_, ramps,
            change_share_);
  for (std::size_t k = 0; k < tool_count(); ++k) {
    snapshot.tool_ids[k] = scene.tools[k].tool_id;
    write.add(StateKind::kSettings, tool_number(k), SettingsView{scene.settings, k});
    if (!ramps) continue;
    write.add(StateKind::kRampFrom, tool_number(k), SettingsView{change_->from, k});
    write.add(StateKind::kRampTo, tool_number(k), SettingsView{change_->to, k});
  }
  const Simulation& simulation = *scene.play.simulation;
  AwakeStrings awake;
  for (const std::int32_t string : simulation.awake_strings()) awake.push_back(string);
  write.add(StateKind::kSimulation, 0, awake, simulation.holders());
  // Of all tools or of none: blocks are numbered by their order.
  const bool pushes = std::any_of(tools_.begin(), tools_.begin() + tool_number(tool_count()),
                                  [](const ToolLoop& tool) { return tool.push.axis != 0; });
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolPlay& play = scene.play.tools[k];
    const ToolLoop& tool = tools_[k];
    write.add(StateKind::kTool, tool_number(k), play.state, play.X_WH, play.view);
    write.add(StateKind::kToolLoop, tool_number(k), tool.sample, tool.guard, tool.safety,
              tool.workspace, tool.touches, tool.write_failed, tool.wrench_not_finite,
              tool.contact_free, scene.tools[k].stiffness_limits.delay_s);
    if (pushes) write.add(StateKind::kPush, tool_number(k), tool.push);
  }
  const OwnedSimulation& own = scene.play;
  for (std::size_t s = 0; s < own.tracks.size(); ++s) {
    const WholeString<const PlayedString, const std::vector<ToolStringState>> whole{
        own.tracks[s], own.visits, own.tracks.size(), s, tool_count()};
    if (own.modes.empty()) {
      write.add(StateKind::kString, tool_number(s), whole);
    } else {
      write.add(StateKind::kString, tool_number(s), whole, own.modes[s]);
    }
  }
  return write.good();
}

bool HapticLoop::restore(const Snapshot& snapshot) {
  PlayedScene& scene = *scene_;
  const auto tool_number = [](std::size_t k) { return static_cast<std::uint32_t>(k); };
  SnapshotReader read(snapshot);
  read.require(snapshot.scene_id == scene.scene_id);
  bool ramps = false;
  read.take(StateKind::kLoop, 0, time_.t_ns, first_tick_, machine_, overrun_watch_, ramps,
            change_share_);
  time_.tick = snapshot.next_tick;
  ever_ticked_ = true;
  change_ =
      ramps ? std::make_unique<SettingsChange>(SettingsChange{0, 0, scene.settings, scene.settings})
            : nullptr;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    SettingsPlace now{scene.settings, k};
    read.take(StateKind::kSettings, tool_number(k), now);
    if (!ramps) continue;
    SettingsPlace from{change_->from, k};
    read.take(StateKind::kRampFrom, tool_number(k), from);
    SettingsPlace to{change_->to, k};
    read.take(StateKind::kRampTo, tool_number(k), to);
  }
  read.require(usable(scene.settings));
  if (ramps) {
    read.require(usable(change_->from) && usable(change_->to) && change_share_ >= 0.0 &&
                 change_share_ <= 1.0);
  }
  AwakeStrings awake;
  StringSharing holders;
  read.take(StateKind::kSimulation, 0, awake, holders);
  read.require(scene.play.simulation->set_awake({awake.begin(), awake.size()}));
  read.require(names_holders(holders, scene.play.tracks.size(), tool_count()));
  if (read.good()) scene.play.simulation->set_holders(holders);
  for (std::size_t k = 0; k < tool_count(); ++k) restore_tool(k, read);
  if (!read.good()) return false;
  apply_settings(scene);
  restore_strings(read);
  return read.good();
}

void HapticLoop::restore_tool(std::size_t k, SnapshotReader& read) {
  ToolPlay& play = scene_->play.tools[k];
  ToolLoop& tool = tools_[k];
  double& delay_s = scene_->tools[k].stiffness_limits.delay_s;
  read.take(StateKind::kTool, static_cast<std::uint32_t>(k), play.state, play.X_WH, play.view);
  read.take(StateKind::kToolLoop, static_cast<std::uint32_t>(k), tool.sample, tool.guard,
            tool.safety, tool.workspace, tool.touches, tool.write_failed, tool.wrench_not_finite,
            tool.contact_free, delay_s);
  read.require(usable(tool.guard) && usable(tool.workspace));
  const bool pushes = read.find(StateKind::kPush, static_cast<std::uint32_t>(k)) != nullptr;
  if (pushes) read.take(StateKind::kPush, static_cast<std::uint32_t>(k), tool.push);
  read.require(tool.push.t_s >= 0.0);
  read.require(delay_s >= 0.0 && delay_s <= kMaxDelay_s);
  read.require(fits_scene(play.state, play.scene) && names_parts(play.view));
  read.require(names_things(tool.touches, scene_->scene->description(), k, play.scene));
}

void HapticLoop::restore_strings(SnapshotReader& read) {
  OwnedSimulation& own = scene_->play;
  for (std::size_t s = 0; s < own.tracks.size() && read.good(); ++s) {
    WholeString<PlayedString, std::vector<ToolStringState>> whole{
        own.tracks[s], own.visits, own.tracks.size(), s, tool_count()};
    if (own.modes.empty()) {
      read.take(StateKind::kString, static_cast<std::uint32_t>(s), whole);
    } else {
      read.take(StateKind::kString, static_cast<std::uint32_t>(s), whole, own.modes[s]);
    }
    const std::int32_t player = own.tracks[s].player;
    read.require(player >= 0 && static_cast<std::size_t>(player) < tool_count());
  }
}

// After the tick, but before its number grows: the snapshot is of what the next tick starts from.
void HapticLoop::publish_snapshot() noexcept {
  if (!options_.snapshots || time_.t_ns < snapshot_due_ns_) return;
  Snapshot* snapshot = channels_.snapshots.writable();
  if (snapshot == nullptr) return;
  snapshot_due_ns_ = time_.t_ns + kSnapshotEvery_ns;
  if (!fill_snapshot(*snapshot)) return;
  ++snapshot->next_tick;
  channels_.snapshots.publish();
}

void HapticLoop::replay_once(const Tick& recorded) noexcept {
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolTick& from = recorded.tools[k];
    ToolLoop& tool = tools_[k];
    tool.recentre = tool.recentre_asked = from.asked.recentre;
    tool.clutch_open = from.asked.clutch_open;
    tool.push_asked = from.asked.push;
    SampleSource* source = scene_->tools[k].device.facets.samples;
    if (source == nullptr) continue;
    ReplayedSample sample;
    sample.outcome = from.lost   ? ReadOutcome::kLost
                     : from.came ? ReadOutcome::kFresh
                                 : ReadOutcome::kNothing;
    sample.write_good = !from.write_failed;
    sample.sample = from.sample;
    source->put(sample);
  }
  orders_ = recorded.orders;
  work_budget_ = static_cast<std::int64_t>(recorded.budget.work);
  give_back_scene();
  pass(recorded.t_ns, recorded.skipped);
}

bool HapticLoop::replay_change(std::unique_ptr<SettingsChange> change) noexcept {
  if (change->to.pieces.size() != scene_->settings.pieces.size() ||
      change->to.tools.size() != scene_->settings.tools.size() ||
      waiting_changes_ == changes_.size()) {
    return false;
  }
  changes_[waiting_changes_++] = std::move(change);
  return true;
}

}  // namespace hapticd
