// The sending half of "exactly once, in order": PROTOCOL.md, sections 4 and 5. Keeps every Item
// until it is acknowledged, says how many of the oldest fit into a Packet and when the next Packet
// must leave, and cuts what is too long into Chunks. Times are ns of one clock of the owner's. Not
// RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <string>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::wire {

inline constexpr std::int64_t kMillisecond_ns = 1'000'000;
/// A time that never comes.
inline constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

/// Items in one Packet.
inline constexpr std::size_t kMaxItems = 16;
/// Unacknowledged Items. A blob counts as one until its pieces are under way.
inline constexpr std::size_t kMaxUnacknowledged = 1024;
/// Longest encoding of an Item, and of what a Chunk carries, and of a blob, bytes.
inline constexpr std::size_t kItemBytes = 1000;
inline constexpr std::size_t kChunkBytes = 900;
inline constexpr std::size_t kBlobBytes = std::size_t{4} << 20U;
/// Bytes of blobs held: a scene that is sent and the one that replaces it meanwhile. Beyond it a
/// session is closed like one with too many Items.
inline constexpr std::size_t kMaxBlobBytesHeld = 2 * kBlobBytes;

/// When a Packet with Items is repeated, after the newest Item first left, ns; then every
/// kRepeat_ns.
inline constexpr std::array<std::int64_t, 5> kRepeats_ns{1 * kMillisecond_ns, 3 * kMillisecond_ns,
                                                         7 * kMillisecond_ns, 15 * kMillisecond_ns,
                                                         31 * kMillisecond_ns};
inline constexpr std::int64_t kRepeat_ns = 50 * kMillisecond_ns;

/// Unacknowledged Items of one direction of a session.
class ItemOutbox {
 public:
  /// Takes `item` in; its id, or that of the last Chunk it travels in. Nothing when the outbox is
  /// full or the Item is longer than a blob may be: the session has to end then.
  std::optional<std::uint64_t> add(const v1::Item& item);
  /// Takes in the Item that ends the session, full or not. At most 1000 bytes.
  std::uint64_t add_last(const v1::Item& item);

  /// The peer has everything up to `id`. False when that was never sent: the peer is broken.
  [[nodiscard]] bool acknowledge(std::uint64_t id);

  /// Packet.first: id of the oldest unacknowledged Item, or the id the next one will get.
  [[nodiscard]] std::uint64_t first_id() const noexcept { return acknowledged_ + 1; }
  /// Id the next Item will get.
  [[nodiscard]] std::uint64_t next_id() const noexcept { return next_id_; }
  /// Items not acknowledged yet, counted as kMaxUnacknowledged counts them.
  [[nodiscard]] std::size_t unacknowledged() const noexcept {
    return window_.size() + waiting_.size();
  }
  /// Nothing is unacknowledged.
  [[nodiscard]] bool empty() const noexcept { return window_.empty(); }

  /// How many of the oldest Items fit into `bytes` of a Packet, each with its tag and length; at
  /// most kMaxItems.
  [[nodiscard]] std::size_t fitting(std::size_t bytes) const noexcept;
  /// Appends the first `count` Items as fields `items` of an encoded Packet.
  void append(std::size_t count, std::string& packet) const;
  /// A Packet with the first `count` Items leaves now.
  void sent(std::size_t count, std::int64_t now_ns) noexcept;

  /// When a Packet with Items must leave: at once (0) if one that never left fits into `bytes`.
  [[nodiscard]] std::int64_t due_ns(std::size_t bytes) const noexcept;

 private:
  /// An Item that waits: its encoding; cut into Chunks when blob > 0.
  struct Waiting {
    std::string bytes;
    std::uint32_t blob = 0;
    std::size_t taken = 0;  ///< bytes of a blob that are in the window
  };

  std::uint64_t push(std::string bytes);
  void refill();

  std::deque<std::string> window_;  ///< encoded Items from first_id() on, at most kMaxItems
  std::deque<Waiting> waiting_;
  std::size_t blob_bytes_held_ = 0;
  std::uint64_t acknowledged_ = 0;
  std::uint64_t highest_sent_ = 0;
  std::uint64_t next_id_ = 1;
  std::uint32_t blobs_ = 0;
  std::int64_t newest_left_ns_ = 0;
  std::int64_t repeat_due_ns_ = kNever_ns;
  std::size_t repeats_ = 0;
};

}  // namespace hapticd::wire
