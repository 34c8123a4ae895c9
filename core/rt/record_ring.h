// A lossless channel between two threads for records of different lengths: a ring of bytes with one
// writer and one reader (Lamport, "Proving the correctness of multiprocess programs", 1977), as
// SpscRing is of items of one length. A record lies in one piece; where it does not fit before the
// end of the ring it begins at its start again. When full it refuses and counts, it never waits or
// overwrites. RT: yes on both sides, O(1), no lock, no fence, no heap.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/rt/cache_line.h"

namespace hapticd {

/// Records of up to `Bytes` / 4 bytes each, in `Bytes` of memory.
template <std::size_t Bytes>
class RecordRing {
  static_assert(Bytes % 64 == 0, "records are aligned, and a quarter of the ring holds one");

 public:
  /// Longest record, bytes.
  static constexpr std::size_t kMaxRecord = Bytes / 4;

  /// Writer only. Room for a record of `size` bytes (at most kMaxRecord), aligned to 16 bytes, to
  /// be filled before publish(); empty, and counted in overflow(), when there is none.
  [[nodiscard]] std::span<std::byte> writable(std::size_t size) noexcept {
    const std::size_t need = taken(size);
    std::uint64_t at = written_.load(std::memory_order_relaxed);
    const std::size_t before_end = Bytes - place(at);
    const std::size_t passed = need > before_end ? before_end : 0;
    const std::uint64_t read = read_.load(std::memory_order_acquire);
    if (size > kMaxRecord || at + passed + need - read > Bytes) {
      overflow_.store(overflow_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return {};
    }
    if (passed > 0) put_length(at, kPassed);
    at += passed;
    put_length(at, size);
    next_ = at + need;
    return {bytes_.data() + place(at) + kHeader, size};
  }

  /// Writer only. Appends what writable() gave.
  void publish() noexcept { written_.store(next_, std::memory_order_release); }

  /// Reader only. The oldest record, valid until release(); empty when there is none.
  [[nodiscard]] std::span<const std::byte> front() const noexcept {
    // Looked at once: what is written meanwhile may begin elsewhere.
    const std::uint64_t written = written_.load(std::memory_order_acquire);
    if (read_.load(std::memory_order_relaxed) == written) return {};
    const std::uint64_t at = first();
    return {bytes_.data() + place(at) + kHeader, length_at(at)};
  }

  /// Reader only. Gives the place of front() back, which was not empty.
  void release() noexcept {
    const std::uint64_t at = first();
    read_.store(at + taken(length_at(at)), std::memory_order_release);
  }

  /// Bytes on their way, at this moment. Any thread.
  [[nodiscard]] std::size_t size() const noexcept {
    const std::uint64_t read = read_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(written_.load(std::memory_order_acquire) - read);
  }

  /// Records refused since construction. Any thread.
  [[nodiscard]] std::uint64_t overflow() const noexcept {
    return overflow_.load(std::memory_order_relaxed);
  }

  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Bytes; }

 private:
  using Length = std::uint64_t;
  /// Stands where the rest of the ring is passed over.
  static constexpr Length kPassed = ~Length{0};

  /// Before each record; everything in the ring is aligned to it.
  static constexpr std::size_t kHeader = 16;

  /// Bytes that a record of `size` takes.
  [[nodiscard]] static constexpr std::size_t taken(std::size_t size) noexcept {
    return (kHeader + size + kHeader - 1) / kHeader * kHeader;
  }
  [[nodiscard]] static constexpr std::size_t place(std::uint64_t at) noexcept {
    return static_cast<std::size_t>(at % Bytes);
  }
  void put_length(std::uint64_t at, Length length) noexcept {
    std::memcpy(bytes_.data() + place(at), &length, sizeof(length));
  }
  [[nodiscard]] Length length_at(std::uint64_t at) const noexcept {
    Length length = 0;
    std::memcpy(&length, bytes_.data() + place(at), sizeof(length));
    return length;
  }
  /// Reader only. Where the oldest record begins; there must be one.
  [[nodiscard]] std::uint64_t first() const noexcept {
    const std::uint64_t at = read_.load(std::memory_order_relaxed);
    return length_at(at) == kPassed ? at + (Bytes - place(at)) : at;
  }

  alignas(kCacheLineBytes) std::atomic<std::uint64_t> written_{0};
  std::uint64_t next_ = 0;  ///< writer's: after the record that is being filled
  std::atomic<std::uint64_t> overflow_{0};
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> read_{0};
  // Value-initialised, which also touches every page before the loop starts.
  alignas(kCacheLineBytes) std::array<std::byte, Bytes> bytes_{};
};

}  // namespace hapticd
