// The changes of live settings that wait for their tick, and the one whose ramp is under way. Each
// goes back to whoever lent it once it is over, overtaken or dropped, and that is told. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "server/haptic_loop/publisher.h"
#include "server/haptic_loop/settings_change.h"

namespace hapticd {

/// Changes of settings that wait for their tick, at most; further ones are refused.
inline constexpr std::size_t kWaitingChanges = 64;

class SettingsRamp {
 public:
  /// Keeps `change` until its tick. False, and it stays the caller's, when there is no room or it
  /// is for another scene than `scene`, which it has come too late for.
  [[nodiscard]] bool take(std::unique_ptr<SettingsChange>& change,
                          const PlayedScene& scene) noexcept;

  /// One tick: begins what is due in it, where the change under way has come to, and moves the
  /// settings of `scene` on; `tools` are as the tick before left them. Returns the number of the
  /// change that begins; 0: none.
  std::uint64_t follow(const LoopTime& time, std::span<const ToolLoop> tools, PlayedScene& scene,
                       Publisher& publisher) noexcept;

  /// Drops the changes for ticks after `tick`.
  void drop_later(std::uint64_t tick, Publisher& publisher) noexcept;
  /// Ends all of them: their scene is over.
  void end(Publisher& publisher) noexcept;

  /// For snapshots: the change under way, null: none, and its share in [0, 1].
  [[nodiscard]] const SettingsChange* change() const noexcept { return change_.get(); }
  [[nodiscard]] double share() const noexcept { return share_; }
  /// Goes on with a change at its share, or with none.
  void resume(std::unique_ptr<SettingsChange> change, double share) noexcept;

 private:
  std::unique_ptr<SettingsChange> change_;
  double share_ = 0.0;
  /// As they came; the first `waiting_count_`.
  std::array<std::unique_ptr<SettingsChange>, kWaitingChanges> waiting_;
  std::size_t waiting_count_ = 0;
};

}  // namespace hapticd
