// A device that follows poses to the letter: a client's, tick by tick. Force is accepted and goes
// nowhere. Poses are passed on as they came, not finite ones too: what to make of those is the
// loop's business. A pose for a tick already run is dropped; a tick without a pose is counted. RT:
// yes but for construction, O(1) per call.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/wrench.h"
#include "device/api/haptic_device.h"

namespace hapticd {

/// Ticks ahead that poses are kept for.
inline constexpr std::size_t kScriptedQueue = 4096;

/// One pose of the handle in D.
struct ScriptedPose {
  Array3 p_DH{};
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};
  Array3 v_DH_D{};  ///< where has_velocity
  Array3 w_DH_D{};
  bool has_velocity = false;  ///< else the difference of successive poses
  std::uint16_t buttons = 0;
};

/// What became of a pose.
enum class ScriptedPush : std::uint8_t {
  kQueued,
  kDropped,  ///< its tick has run
  kFull,     ///< its tick is kScriptedQueue or more ahead
};

struct ScriptedOptions {
  Array3 p_DH{};  ///< where it is before the first pose
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};
  /// A tick without a pose repeats the last one at rest, as a fresh sample (virtual clock); else it
  /// brings no sample (real clock).
  bool hold = true;
};

class ScriptedDevice final : public HapticDevice {
 public:
  /// Allocates.
  ScriptedDevice(const DeviceProfile& profile, const ScriptedOptions& options);

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  /// The pose of the present tick; the next read is for the next tick. Of successive reads at the
  /// same `now_ns` too.
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// The tick of the next read, when ticks were skipped. A smaller one than before starts again:
  /// queue and counts are emptied. Loop's thread, as all that follows.
  HD_REALTIME void set_tick(std::uint64_t tick) noexcept;

  /// Queues the pose of a tick; one queued for the same tick is replaced.
  HD_REALTIME ScriptedPush push(std::uint64_t tick, const ScriptedPose& pose) noexcept;

  /// Forgets what is queued: the controller is gone. The handle rests where it is.
  HD_REALTIME void clear() noexcept;

  /// The tick right after the last one queued; that of the next read when nothing is.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return next_tick_; }
  /// Ticks read without their own pose since the start or the last set_tick back.
  [[nodiscard]] std::uint64_t held() const noexcept { return held_; }
  /// Poses dropped because their tick had run.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  /// Whether any pose is queued for the present tick or a later one.
  [[nodiscard]] bool waiting() const noexcept { return next_tick_ > tick_; }

 private:
  struct Slot {
    std::uint64_t tick = 0;
    bool filled = false;
    ScriptedPose pose;
  };
  [[nodiscard]] Slot& slot(std::uint64_t tick) noexcept { return ring_[tick % kScriptedQueue]; }

  DeviceProfile profile_;
  std::vector<Slot> ring_;
  DeviceSample last_;
  bool hold_;
  std::uint64_t tick_ = 0;       ///< of the next read
  std::uint64_t next_tick_ = 0;  ///< after the last one queued
  std::uint64_t held_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hapticd
