// A device that follows poses given tick by tick: what queues them. Frame: D. SI. RT: yes, O(1).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// Ticks ahead that poses are kept for.
inline constexpr std::size_t kPoseQueue = 4096;

/// One pose of the handle in D.
struct QueuedPose {
  Array3 p_DH{};                    ///< m
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};  ///< unit
  Array3 v_DH_D{};                  ///< where has_velocity, m/s
  Array3 w_DH_D{};                  ///< likewise, rad/s
  bool has_velocity = false;        ///< else the difference of successive poses
  std::uint16_t buttons = 0;
};

/// What became of a pose.
enum class PosePush : std::uint8_t {
  kQueued,
  kDropped,  ///< its tick has run
  kFull,     ///< its tick is kPoseQueue or more ahead
};

/// The loop's thread calls all of it.
class PoseQueue {
 public:
  /// The tick of the next read, when ticks were skipped. A smaller one than before starts again:
  /// the queue is emptied, held() is 0.
  HD_REALTIME virtual void set_tick(std::uint64_t tick) noexcept = 0;

  /// Queues the pose of a tick; one queued for the same tick is replaced.
  HD_REALTIME virtual PosePush push(std::uint64_t tick, const QueuedPose& pose) noexcept = 0;

  /// Forgets what is queued: the controller is gone. The handle rests where it is.
  HD_REALTIME virtual void clear() noexcept = 0;

  /// Ticks read without their own pose since the start or the last set_tick back.
  [[nodiscard]] virtual std::uint64_t held() const noexcept = 0;

 protected:
  PoseQueue() = default;
  PoseQueue(const PoseQueue&) = default;
  PoseQueue& operator=(const PoseQueue&) = default;
  ~PoseQueue() = default;
};

}  // namespace hapticd
