// See loop_snapshot.h.
#include "server/haptic_loop/loop_snapshot.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/safety/safety_fields.h"
#include "core/simulation/simulation_fields.h"

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
    if (!has_obstacle({touch.kind, touch.obstacle}, play.obstacles) || touch.part < 0 ||
        static_cast<std::size_t>(touch.part) >= scene.tools[tool].parts.size()) {
      return false;
    }
  }
  return true;
}

/// Strings, tools and rests that there are.
bool names_holders(const StringSharing& all, std::size_t strings, std::size_t tools,
                   std::span<const StringRest> rests) {
  const auto below = [](std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  for (const SharedString& holders : all) {
    if (!below(holders.string, strings)) return false;
    for (const std::int32_t holder : holders.holders) {
      if (!is_rest(holder)) {
        if (!below(holder, tools)) return false;
      } else if (rest_of(holder) >= rests.size() ||
                 rests[rest_of(holder)].string != holders.string) {
        return false;
      }
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
    if (!below(part.string, view.strings.size()) || !below(part.slot, kMaxTools + kMaxHeldRests)) {
      return false;
    }
  }
  return true;
}

/// Of a tool or string, as blocks have it.
std::uint32_t number(std::size_t k) noexcept { return static_cast<std::uint32_t>(k); }

void restore_tool(std::size_t k, PlayedScene& scene, ToolLoop& tool, SnapshotReader& read) {
  ToolPlay& play = scene.play.tools[k];
  double& delay_s = scene.tools[k].stiffness_limits.delay_s;
  read.take(StateKind::kTool, number(k), play.state, play.X_WH, play.view);
  read.take(StateKind::kToolLoop, number(k), tool.sample, tool.guard, tool.safety, tool.workspace,
            tool.touches, tool.write_failed, tool.wrench_not_finite, tool.contact_free, delay_s);
  read.require(usable(tool.guard) && usable(tool.workspace));
  tool.rendered = play.state.placed;
  const bool pushes = read.find(StateKind::kPush, number(k)) != nullptr;
  if (pushes) read.take(StateKind::kPush, number(k), tool.push);
  const bool measures = read.find(StateKind::kMeasuring, number(k)) != nullptr;
  if (measures) read.take(StateKind::kMeasuring, number(k), tool.spring_under_test);
  read.require(tool.push.t_s >= 0.0 && tool.spring_under_test.t_s >= 0.0 &&
               tool.spring_under_test.owed >= 0.0);
  read.require(delay_s >= 0.0 && delay_s <= kMaxDelay_s);
  read.require(fits_scene(play.state, play.scene) && names_parts(play.view));
  read.require(names_things(tool.touches, scene.scene->description(), k, play.scene));
}

void restore_strings(PlayedScene& scene, SnapshotReader& read) {
  OwnedSimulation& own = scene.play;
  for (std::size_t s = 0; s < own.tracks.size() && read.good(); ++s) {
    WholeString<PlayedString, std::vector<ToolStringState>> whole{
        own.tracks[s], own.visits, own.tracks.size(), s, scene.tools.size()};
    if (own.waves.empty()) {
      read.take(StateKind::kString, number(s), whole);
    } else {
      own.waves[s].state = WaveState{};
      read.take(StateKind::kString, number(s), whole, own.waves[s].state);
    }
    const std::int32_t player = own.tracks[s].player;
    read.require(player >= 0 && static_cast<std::size_t>(player) < scene.tools.size());
  }
}

}  // namespace

bool fill_snapshot(const LoopMemory& loop, const PlayedScene& scene, Snapshot& snapshot) noexcept {
  snapshot.next_tick = loop.time.tick;
  snapshot.scene_id = scene.scene_id;
  snapshot.loop_state = loop.machine.state;
  SnapshotWriter write(snapshot);
  const SettingsChange* const change = loop.ramp.change();
  const bool ramps = change != nullptr;
  write.add(StateKind::kLoop, 0, loop.time.t_ns, loop.first_tick, loop.machine, loop.overruns,
            ramps, loop.ramp.share());
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    snapshot.tool_ids[k] = scene.tools[k].tool_id;
    write.add(StateKind::kSettings, number(k), SettingsView{scene.settings, k});
    if (!ramps) continue;
    write.add(StateKind::kRampFrom, number(k), SettingsView{change->from, k});
    write.add(StateKind::kRampTo, number(k), SettingsView{change->to, k});
  }
  const StringPlayers& strings = scene.play.simulation->strings();
  AwakeStrings awake;
  for (const std::int32_t string : strings.awake_strings()) awake.push_back(string);
  write.add(StateKind::kSimulation, 0, awake, strings.sharing());
  // Of all tools or of none: blocks are numbered by their order.
  const auto any = [&](bool (*has)(const ToolLoop&)) {
    return std::any_of(loop.tools.begin(), loop.tools.begin() + number(scene.tools.size()), has);
  };
  const bool pushes = any([](const ToolLoop& tool) { return tool.push.axis != 0; });
  const bool measures = any([](const ToolLoop& tool) { return tool.spring_under_test.axis != 0; });
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    const ToolPlay& play = scene.play.tools[k];
    const ToolLoop& tool = loop.tools[k];
    write.add(StateKind::kTool, number(k), play.state, play.X_WH, play.view);
    write.add(StateKind::kToolLoop, number(k), tool.sample, tool.guard, tool.safety, tool.workspace,
              tool.touches, tool.write_failed, tool.wrench_not_finite, tool.contact_free,
              scene.tools[k].stiffness_limits.delay_s);
    if (pushes) write.add(StateKind::kPush, number(k), tool.push);
    if (measures) write.add(StateKind::kMeasuring, number(k), tool.spring_under_test);
  }
  const OwnedSimulation& own = scene.play;
  for (std::size_t s = 0; s < own.tracks.size(); ++s) {
    const WholeString<const PlayedString, const std::vector<ToolStringState>> whole{
        own.tracks[s], own.visits, own.tracks.size(), s, scene.tools.size()};
    if (own.waves.empty()) {
      write.add(StateKind::kString, number(s), whole);
    } else {
      write.add(StateKind::kString, number(s), whole, own.waves[s].state);
    }
  }
  return write.good();
}

bool restore(const Snapshot& snapshot, PlayedScene& scene, LoopMemory& loop) {
  SnapshotReader read(snapshot);
  read.require(snapshot.scene_id == scene.scene_id);
  bool ramps = false;
  double share = 0.0;
  read.take(StateKind::kLoop, 0, loop.time.t_ns, loop.first_tick, loop.machine, loop.overruns,
            ramps, share);
  loop.time.tick = snapshot.next_tick;
  auto change =
      ramps ? std::make_unique<SettingsChange>(SettingsChange{0, 0, scene.settings, scene.settings})
            : nullptr;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    SettingsPlace now{scene.settings, k};
    read.take(StateKind::kSettings, number(k), now);
    if (!ramps) continue;
    SettingsPlace from{change->from, k};
    read.take(StateKind::kRampFrom, number(k), from);
    SettingsPlace to{change->to, k};
    read.take(StateKind::kRampTo, number(k), to);
  }
  read.require(usable(scene.settings));
  if (ramps) {
    measure(*change);
    read.require(usable(change->from) && usable(change->to) && share >= 0.0 && share <= 1.0);
  }
  AwakeStrings awake;
  StringSharing sharing;
  StringPlayers& strings = scene.play.simulation->strings();
  read.take(StateKind::kSimulation, 0, awake, sharing);
  read.require(strings.set_awake({awake.begin(), awake.size()}));
  read.require(names_holders(sharing, scene.play.tracks.size(), scene.tools.size(),
                             scene.play.tools.front().scene.rests));
  if (read.good()) strings.sharing() = sharing;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) restore_tool(k, scene, loop.tools[k], read);
  loop.ramp.resume(std::move(change), share);
  if (!read.good()) return false;
  apply_settings(scene);
  restore_strings(scene, read);
  return read.good();
}

}  // namespace hapticd
