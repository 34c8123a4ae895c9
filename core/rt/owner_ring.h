// A lossless channel between two threads for what has one owner at a time, such as a
// std::unique_ptr: a ring with one writer and one reader (see spsc_ring.h). What goes in is the
// ring's until it comes out, and dies with the ring if it never does. RT: yes on both sides, O(1),
// no lock, no heap: what is in a place is moved out before another thing is moved in.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "core/rt/cache_line.h"

namespace hapticd {

/// Up to `Capacity` (a power of two) owners on their way from one thread to another, in order. A
/// default-constructed `Owner`, and one that was moved from, owns nothing.
template <typename Owner, std::size_t Capacity>
class OwnerRing {
  static_assert(std::is_nothrow_move_assignable_v<Owner> &&
                    std::is_nothrow_default_constructible_v<Owner>,
                "an owner is handed over without a throw");
  static_assert(std::has_single_bit(Capacity), "the capacity is a power of two");

 public:
  /// Writer only. Takes what `owner` has; false, and `owner` untouched, when full.
  bool push(Owner& owner) noexcept {
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == Capacity) return false;
    items_[written % Capacity] = std::move(owner);
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  /// Reader only. The oldest owner, who leaves the ring; one of nothing when it is empty.
  [[nodiscard]] Owner pop() noexcept {
    const std::uint64_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) return Owner{};
    Owner oldest = std::move(items_[read % Capacity]);
    read_.store(read + 1, std::memory_order_release);
    return oldest;
  }

  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }

 private:
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> written_{0};
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> read_{0};
  alignas(kCacheLineBytes) std::array<Owner, Capacity> items_{};
};

}  // namespace hapticd
