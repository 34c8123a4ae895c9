// Which Packets of Items are under way where the peer takes some before the oldest is acknowledged:
// which Item the next one begins with, whether it may leave, and when all begin again with the
// oldest (go-back-N, for the peer keeps none that comes early). PROTOCOL.md, section 4. Times are
// ns of one clock of the owner's. Not RT; asks for no memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace hapticd::wire {

inline constexpr std::int64_t kMillisecond_ns = 1'000'000;
/// A time that never comes.
inline constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

/// Most Packets of Items under way; what this implementation announces.
inline constexpr std::uint32_t kMaxAhead = 32;

/// When a Packet with Items is repeated, after the newest Item first left, ns; then every
/// kRepeat_ns.
inline constexpr std::array<std::int64_t, 5> kRepeats_ns{1 * kMillisecond_ns, 3 * kMillisecond_ns,
                                                         7 * kMillisecond_ns, 15 * kMillisecond_ns,
                                                         31 * kMillisecond_ns};
inline constexpr std::int64_t kRepeat_ns = 50 * kMillisecond_ns;

/// The Packets of one direction of a session.
class PacketsAhead {
 public:
  /// The peer announces so many. The largest number counts, kMaxAhead at most.
  void allow(std::uint32_t packets) noexcept {
    most_ = std::max(most_, std::min(packets, kMaxAhead));
  }
  [[nodiscard]] bool allowed() const noexcept { return most_ > 0; }

  /// Id of the Item that the next Packet begins with.
  [[nodiscard]] std::uint64_t next_id() const noexcept { return next_id_; }
  /// Another Packet may leave.
  [[nodiscard]] bool room() const noexcept { return count_ < std::min(width_, most_); }
  /// When the oldest Item leaves again; kNever_ns: nothing is under way.
  [[nodiscard]] std::int64_t due_ns() const noexcept { return due_ns_; }

  /// A Packet with the Items `first` to `last` leaves: from the oldest unacknowledged one on all
  /// begin anew with it, else `first` is next_id().
  void left(std::uint64_t first, std::uint64_t last, std::int64_t now_ns) noexcept;
  /// Items that had not been are acknowledged, up to `id`.
  void acknowledged(std::uint64_t id, std::int64_t now_ns) noexcept;
  /// The oldest Item leaves next, and the others again after it.
  void turn_back(std::int64_t now_ns) noexcept;

 private:
  [[nodiscard]] std::int64_t wait_ns() const noexcept;
  void widen() noexcept;
  void learn_round_trip(std::uint64_t id, std::int64_t now_ns) noexcept;

  std::uint32_t most_ = 0;
  std::uint32_t width_ = 1;  ///< Packets at a time that the road bears
  std::uint32_t borne_ = 0;  ///< acknowledged since it grew
  bool steep_ = true;        ///< it grows with every Packet, for it was never too wide
  std::array<std::uint64_t, kMaxAhead> last_ids_{};  ///< of the Packets under way, a ring
  std::size_t oldest_ = 0;                           ///< place in it
  std::uint32_t count_ = 0;
  std::uint64_t next_id_ = 1;
  std::uint64_t acknowledged_ = 0;
  std::uint64_t highest_ = 0;  ///< id that left
  std::size_t turns_ = 0;      ///< since Items were acknowledged,
  std::int64_t moved_ns_ = 0;  ///< which was then; or since the first of those under way left
  std::int64_t due_ns_ = kNever_ns;
  std::uint64_t timed_id_ = 0;  ///< a Packet's last Item, which left first at timed_ns_; 0: none
  std::int64_t timed_ns_ = 0;
  std::int64_t round_trip_ns_ = 0;  ///< the mean
};

}  // namespace hapticd::wire
