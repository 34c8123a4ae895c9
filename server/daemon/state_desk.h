// The newest tick as clients see it: its State, its times, and the hash that a Run of steps is
// answered with. Not RT.
#pragma once

#include <cstdint>
#include <functional>

#include "server/daemon/scene_desk.h"
#include "server/daemon/tick_statistics.h"
#include "server/encoding/state_hash.h"
#include "server/network/server_host.h"

namespace hapticd {

class StateDesk {
 public:
  /// What clients are told of a tick and no snapshot knows.
  using Complete = std::function<void(const Snapshot&, v1::State&)>;

  /// `scenes` outlives this.
  StateDesk(const SceneDesk& scenes, Complete complete)
      : scenes_(scenes), complete_(std::move(complete)) {}

  /// A tick is over; `snapshot` lives until release().
  void take(const Snapshot& snapshot);
  /// Takes the State of the tick into the hash.
  void add_to_hash();
  /// Nothing of the tick is asked for any more.
  void release() noexcept { snapshot_ = nullptr; }
  [[nodiscard]] const Snapshot& newest() const noexcept { return *snapshot_; }

  /// Fills in the State of the newest tick, between take() and release().
  void fill(const Subscription& subscription, v1::State& state);

  /// Of all ticks of the scene that was begun last.
  [[nodiscard]] const StateHash& hash() const noexcept { return hash_; }
  void restart_hash() { hash_ = StateHash{}; }

 private:
  const SceneDesk& scenes_;
  Complete complete_;
  const Snapshot* snapshot_ = nullptr;
  TickStatistics statistics_;
  StateHash hash_;
};

}  // namespace hapticd
