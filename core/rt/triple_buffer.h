// The newest snapshot for a slower reader: three slots, one the writer's, one the reader's, one in
// the middle. Publishing swaps the writer's slot with the middle one, updating swaps the reader's
// with it if that is newer, so neither waits and no snapshot is torn. Unlike a seqlock it needs no
// fence and no racing copy. One writer, one reader. RT: yes on both sides, O(1) plus the copy.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "core/rt/cache_line.h"

namespace hapticd {

/// Hands the newest plain `T` from one thread to another; older ones are dropped.
template <typename T>
class TripleBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "what crosses a thread is plain data");

 public:
  /// Writer only. The slot to fill before publish(). It holds an older snapshot: write every
  /// member.
  [[nodiscard]] T& writable() noexcept { return slots_[write_slot_].value; }

  /// Writer only. Makes the filled slot the newest; writable() is another slot afterwards.
  void publish() noexcept {
    write_slot_ = middle_.exchange(write_slot_ | kFresh, std::memory_order_acq_rel) & kSlotMask;
  }

  /// Writer only. Copies `value` and publishes it.
  void write(const T& value) noexcept {
    writable() = value;
    publish();
  }

  /// Reader only. Moves latest() to the newest snapshot; false when it already was.
  bool update() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    read_slot_ = middle_.exchange(read_slot_, std::memory_order_acq_rel) & kSlotMask;
    return true;
  }

  /// Reader only. The snapshot of the last update(), T{} before the first; valid until the next
  /// update().
  [[nodiscard]] const T& latest() const noexcept { return slots_[read_slot_].value; }

 private:
  static constexpr std::uint32_t kSlotMask = 3;
  static constexpr std::uint32_t kFresh = 4;  // the middle slot is newer than the reader's

  struct alignas(kCacheLineBytes) Slot {
    T value{};
  };

  std::array<Slot, 3> slots_{};
  alignas(kCacheLineBytes) std::uint32_t write_slot_ = 0;
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> middle_{1};
  alignas(kCacheLineBytes) std::uint32_t read_slot_ = 2;
};

}  // namespace hapticd
