// A haptic loop with a scripted device under virtual time, driven pose by pose, and all it told.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/daemon/scene_player.h"
#include "server/haptic_loop/haptic_loop.h"
#include "tests/server/haptic_loop/wall_scene.h"

namespace hapticd::test {

/// The same finger above a string along x that rings; home is 10 mm above it.
extern const char* const kStringScene;

/// Three fingers of 5 mm, tools 7, 2 and 30, 100 mm apart along x before the same wall.
extern const char* const kThreeFingerScene;

/// Everything one tick told.
struct ToldTick {
  Tick tick;
  std::vector<LoopEvent> events;
};

/// How the loop of a test is made.
struct LoopSetting {
  std::string source = "scripted";
  std::string profile = "ideal";
  bool guards_armed = false;
  bool real_time = false;  ///< instants are given, 1 ms apart
  /// Of a tick; 0: no bound; absent: as where nobody says.
  std::optional<double> budget_us = std::nullopt;
};

/// What plays `text`, for LoopRun or to swap to.
std::unique_ptr<PlayedScene> played_scene(const std::string& text, std::uint32_t scene_id,
                                          const LoopSetting& setting = {});

class LoopRun {
 public:
  explicit LoopRun(const std::string& scene, const LoopSetting& setting = {});

  /// One tick with the handle at p_WH (the map is the identity).
  const ToldTick& tick(const Vector3& p_WH);
  /// One tick with the handle of each tool.
  const ToldTick& tick_all(std::span<const Vector3> p_WH);
  /// One tick with whatever the device does.
  const ToldTick& tick();
  /// Time passes without a tick, ns.
  void stand_still(std::int64_t t_ns) noexcept { now_ns_ += t_ns; }
  /// Sends a command; it is obeyed in the next tick.
  void send(const LoopCommandBody& what);
  /// Lends what a command needs, and sends it.
  void swap_to(std::unique_ptr<PlayedScene> scene);
  void play(std::unique_ptr<GesturePlan> plan);
  void change(std::unique_ptr<SettingsChange> change);
  /// Ticks at `p_WH` until the loop is engaged at full gain.
  void engage(const Vector3& p_WH);

  /// Instant of the last tick under real time, ns.
  [[nodiscard]] std::int64_t now_ns() const noexcept { return now_ns_; }
  [[nodiscard]] HapticLoop& loop() noexcept { return *loop_; }
  [[nodiscard]] LoopChannels& channels() noexcept { return *channels_; }

 private:
  std::unique_ptr<LoopChannels> channels_ = std::make_unique<LoopChannels>();
  std::unique_ptr<HapticLoop> loop_;
  ToldTick told_;
  std::int64_t now_ns_ = 1'000'000'000;
  std::uint64_t commands_ = 0;
};

/// The force written in a tick, in W.
inline Vector3 force(const ToldTick& told, std::size_t tool = 0) {
  return to_vector(told.tick.tools[tool].F_written_H_W.f);
}

/// How many of the events of a tick are a `What`.
template <typename What>
int count(const ToldTick& told) {
  int found = 0;
  for (const LoopEvent& event : told.events) found += std::holds_alternative<What>(event.what);
  return found;
}

}  // namespace hapticd::test
