// A device that follows poses to the letter: a client's, tick by tick. Force is accepted and goes
// nowhere. Poses are passed on as they came, even those that are not finite: what to make of them
// is the loop's business. A pose for a tick already run is dropped, but on the real clock one newer
// than the last is used in the next tick; a tick without a pose is counted. Where its force goes to
// a hand the delay is learned from how long poses wait in the queue. RT: yes but for construction,
// O(1) per call.
#pragma once

#include <cstdint>
#include <vector>

#include "core/safety/stiffness_clamp.h"
#include "device/api/haptic_device.h"
#include "device/api/pose_queue.h"

namespace hapticd {

/// A wait that is this much longer than the declared delay is within it, s: a tick each for when
/// the pose came and when the force is told, which whoever measured the declared one has seen too.
inline constexpr double kUsualWait_s = 2e-3;

/// The most that is learned, s.
inline constexpr double kMostLearned_s = 0.1;

struct ScriptedOptions {
  Array3 p_DH{};  ///< where it is before the first pose
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};
  /// A tick without a pose repeats the last one at rest, as a fresh sample (virtual clock); else it
  /// brings no sample (real clock).
  bool hold = true;
};

class ScriptedDevice final : public HapticDevice, public PoseQueue {
 public:
  /// Allocates.
  ScriptedDevice(const DeviceProfile& profile, const ScriptedOptions& options);

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  /// The pose of the present tick; the next read is for the next tick. Of successive reads at the
  /// same `now_ns` too.
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  HD_REALTIME void set_tick(std::uint64_t tick) noexcept override;
  HD_REALTIME PosePush push(std::uint64_t tick, const QueuedPose& pose) noexcept override;
  HD_REALTIME void clear() noexcept override;
  [[nodiscard]] std::uint64_t held() const noexcept override { return held_; }

  // Loop's thread.
  /// The tick right after the last one queued; that of the next read when nothing is.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return next_tick_; }
  /// Poses dropped because their tick had run.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  /// Whether any pose is queued for the present tick or a later one.
  [[nodiscard]] bool waiting() const noexcept { return next_tick_ > tick_; }

 private:
  struct Slot {
    std::uint64_t tick = 0;
    bool filled = false;
    QueuedPose pose;
    std::int64_t given_ns = 0;  ///< the last read before it was
  };
  [[nodiscard]] Slot& slot(std::uint64_t tick) noexcept { return ring_[tick % kPoseQueue]; }

  DeviceProfile profile_;
  std::vector<Slot> ring_;
  HD_REALTIME void learn_wait(const Slot& slot, std::int64_t now_ns) noexcept;

  DeviceSample last_;
  DelayEstimator wait_;
  std::int64_t now_ns_ = 0;  ///< of the last read
  bool hold_;
  std::uint64_t tick_ = 0;       ///< of the next read
  std::uint64_t next_tick_ = 0;  ///< after the last one queued
  std::uint64_t last_tick_ = 0;  ///< that the newest pose used was for
  std::uint64_t held_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hapticd
