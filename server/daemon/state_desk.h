// The newest tick as clients see it: its State, its times, and the hash that a Run of steps is
// answered with. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "server/daemon/scene_desk.h"
#include "server/daemon/tick_statistics.h"
#include "server/encoding/state_hash.h"
#include "server/encoding/told_soundings.h"
#include "server/haptic_loop/haptic_loop.h"
#include "server/network/server_host.h"

namespace hapticd {

class StateDesk {
 public:
  /// What clients are told of a tick and its record does not know.
  using Complete = std::function<void(const Tick&, v1::State&)>;

  /// `scenes` outlives this.
  StateDesk(const SceneDesk& scenes, Complete complete)
      : scenes_(scenes), complete_(std::move(complete)) {}

  /// Takes the oldest tick out of `ticks`; false when there is none.
  bool take(NetworkTicks& ticks);
  /// Takes the State of the tick into the hash.
  void add_to_hash();
  [[nodiscard]] const Tick& newest() const noexcept { return *newest_; }

  /// Takes an event that clients are told: States repeat what sounds. The hash leaves that out: it
  /// depends on who subscribed when.
  void note(std::uint32_t scene_id, const v1::Item& event) { soundings_.take(scene_id, event); }
  /// Fills in the State of the newest tick.
  void fill(const Subscription& subscription, v1::State& state);

  /// Of all ticks of the scene that was begun last.
  [[nodiscard]] const StateHash& hash() const noexcept { return hash_; }
  void restart_hash() { hash_ = StateHash{}; }

 private:
  const SceneDesk& scenes_;
  Complete complete_;
  std::unique_ptr<Tick> newest_ = std::make_unique<Tick>();
  TickStatistics statistics_;
  ToldSoundings soundings_;
  StateHash hash_;
};

}  // namespace hapticd
