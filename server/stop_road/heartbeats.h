// The clients that must be alive for force to be on: each has said how long it may be silent. Pure:
// times come from the caller. No heap. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd {

/// Clients at a time.
inline constexpr std::size_t kMaxHeartbeats = 8;

/// How long the number of a client that has left is remembered, ns: longer than any heartbeat's
/// challenge is good for, so that none is taken for a new one.
inline constexpr std::int64_t kGoneMemory_ns = 2'000'000'000;

class Heartbeats {
 public:
  enum class Verdict : std::uint8_t {
    kCounts,
    kRepeated,  ///< its number is not above the client's last
    kFull,      ///< no place for another client
  };

  /// `client` is alive, with its request `number`, and may be silent for `timeout_ns`.
  Verdict beat(std::uint64_t client, std::uint64_t number, std::int64_t timeout_ns,
               std::int64_t now_ns) noexcept;
  /// `client` need not be alive any more; counts where it never had to be.
  Verdict leave(std::uint64_t client, std::uint64_t number, std::int64_t now_ns) noexcept;
  /// Those that are absent at `now_ns` need not be alive any more.
  void forget_absent(std::int64_t now_ns) noexcept;

  /// How many must be alive.
  [[nodiscard]] std::size_t count() const noexcept;
  /// When the first of them will have been silent for too long; `none` where there is none.
  [[nodiscard]] std::int64_t earliest_ns(std::int64_t none) const noexcept;

 private:
  struct Entry {
    std::uint64_t client = 0;   ///< 0: free
    std::uint64_t number = 0;   ///< its last
    bool needed = false;        ///< else it has left
    std::int64_t until_ns = 0;  ///< alive; of one that has left: remembered
  };

  [[nodiscard]] Entry* find(std::uint64_t client) noexcept;
  [[nodiscard]] Entry* place(std::int64_t now_ns) noexcept;

  std::array<Entry, kMaxHeartbeats> entries_{};
};

}  // namespace hapticd
