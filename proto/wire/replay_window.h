// Which counters of a peer have been used: PROTOCOL.md, section 2, steps 4 and 6. A ring of bits
// over the 2048 values up to the largest one marked. No allocation. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd::wire {

/// Values the window remembers. At 1000 datagrams a second and reordering of 50 ms some 50 are in
/// use; what comes later than the window is dropped.
inline constexpr std::uint64_t kReplayWindow = 2048;

/// Remembers counters. Asking and marking are apart, because a datagram that does not open must not
/// be able to block a counter.
class ReplayWindow {
 public:
  /// Not marked, and not below the window.
  [[nodiscard]] bool is_new(std::uint64_t counter) const noexcept {
    if (!any_ || counter > largest_) return true;
    if (largest_ - counter >= kReplayWindow) return false;
    return (word(counter) & bit(counter)) == 0;
  }

  /// Marks `counter`, which is_new().
  void mark(std::uint64_t counter) noexcept {
    if (!any_) {
      any_ = true;
      largest_ = counter;
    } else if (counter > largest_) {
      forget(largest_, counter);
      largest_ = counter;
    }
    marked_[index(counter)] |= bit(counter);
  }

 private:
  static std::size_t index(std::uint64_t counter) noexcept {
    return static_cast<std::size_t>(counter % kReplayWindow / 64);
  }
  static std::uint64_t bit(std::uint64_t counter) noexcept {
    return std::uint64_t{1} << (counter % 64);
  }
  [[nodiscard]] std::uint64_t word(std::uint64_t counter) const noexcept {
    return marked_[index(counter)];
  }

  /// Clears the places of the values in (from, to].
  void forget(std::uint64_t from, std::uint64_t to) noexcept {
    if (to - from >= kReplayWindow) {
      marked_.fill(0);
      return;
    }
    for (std::uint64_t counter = from + 1; counter != to + 1; ++counter) {
      marked_[index(counter)] &= ~bit(counter);
    }
  }

  std::array<std::uint64_t, kReplayWindow / 64> marked_{};
  std::uint64_t largest_ = 0;
  bool any_ = false;
};

}  // namespace hapticd::wire
