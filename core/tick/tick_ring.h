// Ticks on their way from the haptic thread to another: of each the head and the used part of every
// column, 1 to 3 kB with one tool, through a ring of bytes. RT: yes; push() is a copy.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "core/rt/record_ring.h"
#include "core/tick/tick.h"

namespace hapticd {

/// One writer, one reader, `Bytes` of memory.
template <std::size_t Bytes>
class TickRing {
 public:
  static_assert(RecordRing<Bytes>::kMaxRecord >= sizeof(Tick), "the fullest tick must fit");

  /// Writer only. Appends; false, and counted in overflow(), when full.
  bool push(const Tick& tick) noexcept {
    Sizes sizes{};
    std::size_t bytes = sizeof(Sizes) + sizeof(TickHead);
    each_column(tick, sizes, [&](const auto& column, std::size_t& size) {
      size = column.size();
      bytes += size * sizeof(*column.begin());
    });
    const std::span<std::byte> place = ring_.writable(bytes);
    if (place.empty()) return false;
    std::byte* to = place.data();
    put(&sizes, 1, to);
    const TickHead head = tick;
    put(&head, 1, to);
    each_column(tick, sizes,
                [&](const auto& column, std::size_t size) { put(column.begin(), size, to); });
    ring_.publish();
    return true;
  }

  /// Reader only. Takes the oldest tick; false, and `tick` untouched, when empty.
  bool pop(Tick& tick) noexcept {
    const std::span<const std::byte> oldest = ring_.front();
    if (oldest.empty()) return false;
    const std::byte* from = oldest.data();
    Sizes sizes;
    take(from, 1, &sizes);
    TickHead head;
    take(from, 1, &head);
    static_cast<TickHead&>(tick) = head;
    each_column(tick, sizes, [&](auto& column, std::size_t size) {
      column.clear();
      for (std::size_t k = 0; k < size; ++k) static_cast<void>(column.append());
      take(from, size, column.begin());
    });
    ring_.release();
    return true;
  }

  /// Bytes on their way, at this moment. Any thread.
  [[nodiscard]] std::size_t size() const noexcept { return ring_.size(); }
  /// Ticks refused since construction. Any thread.
  [[nodiscard]] std::uint64_t overflow() const noexcept { return ring_.overflow(); }
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Bytes; }

 private:
  /// Used entries of each column.
  using Sizes = std::array<std::size_t, 5>;

  template <typename Record, typename S, typename Each>
  static void each_column(Record& tick, S& sizes, const Each& each) noexcept {
    each(tick.tools, sizes[0]);
    each(tick.contacts, sizes[1]);
    each(tick.strings, sizes[2]);
    each(tick.string_forces, sizes[3]);
    each(tick.string_bends, sizes[4]);
  }
  template <typename T>
  static void put(const T* from, std::size_t count, std::byte*& to) noexcept {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > 0) std::memcpy(to, from, count * sizeof(T));
    to += count * sizeof(T);
  }
  template <typename T>
  static void take(const std::byte*& from, std::size_t count, T* to) noexcept {
    if (count > 0) std::memcpy(to, from, count * sizeof(T));
    from += count * sizeof(T);
  }

  RecordRing<Bytes> ring_;
};

}  // namespace hapticd
