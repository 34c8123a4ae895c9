// A lossless channel between two threads: a ring with one writer and one reader (Lamport, "Proving
// the correctness of multiprocess programs", 1977). The writer owns one index, the reader the
// other; releasing an index publishes the item, or the free place, before it. Indices are 64 bits
// and never wrap. When full it refuses and counts, it never waits or overwrites. RT: yes on both
// sides, O(1), no lock, no fence, no heap.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "core/rt/cache_line.h"

namespace hapticd {

/// Up to `Capacity` (a power of two) items of plain `T` on their way from one thread to another, in
/// order.
template <typename T, std::size_t Capacity>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>, "what crosses a thread is plain data");
  static_assert(std::has_single_bit(Capacity), "the capacity is a power of two");

 public:
  /// Writer only. Appends; false, and counted in overflow(), when full.
  bool push(const T& item) noexcept {
    T* const place = writable();
    if (place == nullptr) return false;
    *place = item;
    publish();
    return true;
  }

  /// Writer only. The place of the next item, to be filled before publish(); null, and counted in
  /// overflow(), when full. It holds an older item: write every member that is read.
  [[nodiscard]] T* writable() noexcept {
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == Capacity) {
      overflow_.store(overflow_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return nullptr;
    }
    return &items_[written % Capacity];
  }

  /// Writer only. Appends what writable() pointed to.
  void publish() noexcept {
    written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Reader only. Takes the oldest item; false, and `item` untouched, when empty.
  bool pop(T& item) noexcept {
    const T* const oldest = front();
    if (oldest == nullptr) return false;
    item = *oldest;
    release();
    return true;
  }

  /// Reader only. The oldest item, valid until release(); null when empty.
  [[nodiscard]] const T* front() const noexcept {
    const std::uint64_t read = read_.load(std::memory_order_relaxed);
    return read == written_.load(std::memory_order_acquire) ? nullptr : &items_[read % Capacity];
  }

  /// Reader only. Gives the place of front() back.
  void release() noexcept {
    read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Items on their way, at this moment. Any thread.
  [[nodiscard]] std::size_t size() const noexcept {
    const std::uint64_t read = read_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(written_.load(std::memory_order_acquire) - read);
  }

  /// Items refused since construction. Any thread.
  [[nodiscard]] std::uint64_t overflow() const noexcept {
    return overflow_.load(std::memory_order_relaxed);
  }

  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }

 private:
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> overflow_{0};
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> read_{0};
  // Value-initialised, which also touches every page before the loop starts.
  alignas(kCacheLineBytes) std::array<T, Capacity> items_{};
};

}  // namespace hapticd
