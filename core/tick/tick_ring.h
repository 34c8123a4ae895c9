// Ticks on their way from the haptic thread to another: of each the head and the used part of every
// column, 1 to 3 kB with one tool, through a ring of bytes. RT: yes; push() is a copy.
#pragma once

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
    const Sizes sizes{tick.tools.size(), tick.contacts.size(), tick.strings.size(),
                      tick.string_forces.size()};
    const std::span<std::byte> place = ring_.writable(bytes_of(sizes));
    if (place.empty()) return false;
    std::byte* to = place.data();
    put(&sizes, 1, to);
    const TickHead head = tick;
    put(&head, 1, to);
    put(tick.tools.begin(), sizes.tools, to);
    put(tick.contacts.begin(), sizes.contacts, to);
    put(tick.strings.begin(), sizes.strings, to);
    put(tick.string_forces.begin(), sizes.string_forces, to);
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
    take_column(from, sizes.tools, tick.tools);
    take_column(from, sizes.contacts, tick.contacts);
    take_column(from, sizes.strings, tick.strings);
    take_column(from, sizes.string_forces, tick.string_forces);
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
  struct Sizes {
    std::size_t tools = 0;
    std::size_t contacts = 0;
    std::size_t strings = 0;
    std::size_t string_forces = 0;
  };

  [[nodiscard]] static constexpr std::size_t bytes_of(const Sizes& sizes) noexcept {
    return sizeof(Sizes) + sizeof(TickHead) + sizes.tools * sizeof(ToolTick) +
           sizes.contacts * sizeof(ContactTick) + sizes.strings * sizeof(StringTick) +
           sizes.string_forces * sizeof(StringForceTick);
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
  template <typename Column>
  static void take_column(const std::byte*& from, std::size_t count, Column& column) noexcept {
    column.clear();
    for (std::size_t k = 0; k < count; ++k) static_cast<void>(column.append());
    take(from, count, column.begin());
  }

  RecordRing<Bytes> ring_;
};

}  // namespace hapticd
