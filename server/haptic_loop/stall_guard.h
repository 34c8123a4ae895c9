// What a loop and its guardian share: the guardian's thread looks whether the loop still ticks, and
// writes zero to the devices of one that stands still while force is on. Each call says whose it
// is; both may be in at once. RT: yes, a few atomic words; no lock.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/math/limits.h"
#include "core/safety/guardian.h"
#include "device/api/haptic_device.h"

namespace hapticd {

class StallGuard {
 public:
  /// Loop. A tick begins at `now_ns`; 0 in virtual time, which may stand still.
  void beat(std::int64_t now_ns) noexcept {
    heartbeat_ns_.store(now_ns, std::memory_order_relaxed);
  }
  /// Loop. Whether force may be on: only then a loop that stands still is a danger.
  void arm(bool force_on) noexcept { force_on_.store(force_on, std::memory_order_relaxed); }
  /// Loop. The device of tool `tool` is to be written zero to; null: of none.
  void watch(std::size_t tool, HapticDevice* device) noexcept {
    devices_[tool].store(device, std::memory_order_seq_cst);
  }
  /// Loop. From here on no device is written to, but those that busy() speaks of.
  void forget_devices() noexcept {
    for (std::size_t k = 0; k < kMaxTools; ++k) watch(k, nullptr);
  }
  /// Loop. The guardian is writing to devices, perhaps to ones that were forgotten since: whoever
  /// frees them must not hear of it before that is over.
  [[nodiscard]] bool busy() const noexcept { return writing_.load(std::memory_order_seq_cst); }
  /// Loop. Whether the guardian has found it stuck since the last call.
  [[nodiscard]] bool stalled() noexcept {
    const std::uint64_t stalls = stalls_.load(std::memory_order_relaxed);
    const bool anew = stalls != stalls_seen_;
    stalls_seen_ = stalls;
    return anew;
  }

  /// Guardian. One look.
  void look(std::int64_t now_ns) noexcept {
    const bool armed = force_on_.load(std::memory_order_relaxed);
    const std::int64_t heartbeat_ns = heartbeat_ns_.load(std::memory_order_relaxed);
    if (!must_write_zero(heartbeat_ns, now_ns, armed, guardian_)) return;
    writing_.store(true, std::memory_order_seq_cst);
    for (auto& watched : devices_) {
      HapticDevice* device = watched.load(std::memory_order_seq_cst);
      if (device != nullptr) device->write_zero(now_ns);
    }
    writing_.store(false, std::memory_order_seq_cst);
    stalls_.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  std::array<std::atomic<HapticDevice*>, kMaxTools> devices_{};
  std::atomic<std::int64_t> heartbeat_ns_{0};
  std::atomic<bool> writing_{false};  ///< to one of devices_
  std::atomic<bool> force_on_{false};
  std::atomic<std::uint64_t> stalls_{0};
  Guardian guardian_;              ///< of the guardian's thread
  std::uint64_t stalls_seen_ = 0;  ///< of the loop's
};

}  // namespace hapticd
