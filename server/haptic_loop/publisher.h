// What the loop tells the other threads: events as they happen, and the record of every tick. RT:
// yes.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/simulation/simulation.h"
#include "server/haptic_loop/loop_channels.h"
#include "server/haptic_loop/scene_slot.h"
#include "server/haptic_loop/tool_loop.h"

namespace hapticd {

class Publisher {
 public:
  /// `time` and `scenes` say when and of which scene things are told. All must outlive it.
  Publisher(LoopChannels& channels, const LoopTime& time, const SceneSlot& scenes) noexcept
      : channels_(channels), time_(time), scenes_(scenes) {}

  /// Something happened to a tool of the scene that plays, or to all: tool 0.
  template <typename What>
  void tell(const What& what, std::size_t tool = 0) noexcept {
    const PlayedScene& scene = scenes_.playing();
    channels_.events.push(
        {time_.tick, time_.t_ns, scene.scene_id, scene.tools[tool].tool_id, what});
  }

  /// Gives back a change of settings that is over or, when `dropped`, never began, and tells so.
  void retire(std::unique_ptr<SettingsChange> change, bool dropped = false) noexcept;

  /// What sounded in a tick that was rendered. Cost: that of an event each.
  void tell_strings(const StringEvents& events) noexcept;
  /// Finds the contacts of the tools after such a tick, and tells which touches began and ended.
  void tell_touches(std::span<ToolLoop> tools) noexcept;

  /// Completes `tick`, whose state, orders, budget and times are the loop's to set, with what is of
  /// `tools` and their contacts, and sends it.
  void publish(std::span<const ToolLoop> tools, Tick& tick) noexcept;

 private:
  LoopChannels& channels_;
  const LoopTime& time_;
  const SceneSlot& scenes_;
  TouchEvents touch_events_;
};

}  // namespace hapticd
