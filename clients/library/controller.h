// Control of one hapticd: the lease, scenes, scripted poses and lockstep. Every request carries the
// fencing number of the lease it was acquired under, so a controller that lost the lease and took
// it again does nothing by old assumptions. PROTOCOL.md, sections 8, 9 and 11. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "clients/library/client.h"

namespace hapticd::client {

/// Poses in one PoseBatch: with velocity 8 stay below the 1000 bytes of one Item, without 14.
inline constexpr int kPosesPerBatch = 14;
inline constexpr int kMovingPosesPerBatch = 8;

/// Holds the lease of a Client's server. The Client must outlive it.
class Controller {
 public:
  explicit Controller(Client& client) : client_(client) {}

  /// Takes the lease, under the name `holder` (64 bytes at most). BUSY when another session holds
  /// it.
  v1::Result acquire(const std::string& holder, std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// The same, also from a session that holds it. All are told the reason, 1 to 400 bytes. A Run of
  /// its steps ends, and force fades to zero.
  v1::Result take_over(const std::string& holder, const std::string& reason,
                       std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// Whether the server still says that the lease is the one acquired here.
  [[nodiscard]] bool holds() const;
  /// Fencing number of the lease acquired last; 0 = none.
  [[nodiscard]] std::uint64_t fence() const noexcept { return fence_; }
  /// Gives the lease back.
  v1::Result release();

  /// Loads an installed scene and waits until it plays. For one in a file: scene_file.h.
  v1::Result load_scene(const std::string& name,
                        std::chrono::nanoseconds timeout = std::chrono::seconds(60));
  /// Queues the pose X_DH of a scripted tool's handle for the tick after the last one queued. Sent
  /// when a batch is full, and before every other request of this class. Refusals come to
  /// ClientHandlers::pose_refused.
  void pose(std::uint32_t tool_id, const v1::Pose& pose_dh,
            const std::optional<v1::Twist>& twist_dh_d = std::nullopt);
  /// Advances the virtual clock by `steps` ticks; Result.run has the hash of all States. They come
  /// to ClientHandlers::state by their ticks, those of this run from next_tick - steps on; one that
  /// is lost does not come again, so state() may be older than the last tick.
  v1::Result run(std::uint64_t steps, std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// Sends any request under the fence and awaits its Result. That of an Acquire is kept, as by
  /// acquire().
  v1::Result call(v1::Item request, std::chrono::nanoseconds timeout = kDefaultTimeout);
  /// Zero wrench at the next tick, latched. Needs no lease.
  v1::Result stop();

 private:
  v1::Result acquire(const v1::Item& item, std::chrono::nanoseconds timeout);
  void flush();

  Client& client_;
  std::uint64_t fence_ = 0;
  v1::Item batch_;
  bool batch_moves_ = false;
};

}  // namespace hapticd::client
