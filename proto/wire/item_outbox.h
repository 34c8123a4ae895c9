// The sending half of "exactly once, in order": PROTOCOL.md, sections 4 and 5. Keeps every Item
// until it is acknowledged, says which of them a Packet takes and when the next Packet must leave,
// and cuts what is too long into Chunks. A Packet begins with the oldest Item; where the peer takes
// Packets ahead and one does not hold all, with the next Item that is not under way. Times are ns
// of one clock of the owner's. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "hapticd/v1/stream.pb.h"
#include "proto/wire/datagram.h"
#include "proto/wire/packets_ahead.h"

namespace hapticd::wire {

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
/// Bytes a Packet may have without header and tag.
inline constexpr std::size_t kPacketBytes = kDatagramBytes - kHeaderBytes - kTagBytes;
/// Bytes of a Packet for Items, each with its tag and length, where there is no State: without ack,
/// first, seen, newest, boot_id, and clock with three times. Who sends a boot_id has no seen, which
/// leaves room for `ahead`.
inline constexpr std::size_t kItemsBytes = kPacketBytes - (4 * 11 + 5 + 2 + 3 * 11);
static_assert(kItemsBytes >= kItemBytes + 3, "an Item of any permitted length fits");

/// Whether Items may leave before the rest of a Result that is cut into Chunks. Not where the ids
/// that add() gives are of use to anybody.
enum class Overtaking : std::uint8_t { kNever, kResults };

/// Unacknowledged Items of one direction of a session.
class ItemOutbox {
 public:
  explicit ItemOutbox(Overtaking overtaking = Overtaking::kNever) : overtaking_(overtaking) {}

  /// The peer takes so many Packets ahead: Packet.ahead.
  void allow_ahead(std::uint32_t packets) noexcept { ahead_.allow(packets); }

  /// Takes `item` in; its id, or that of the last Chunk it travels in, unless others overtake it.
  /// Nothing when the outbox is full or the Item is longer than a blob may be: the session has to
  /// end then.
  std::optional<std::uint64_t> add(const v1::Item& item);
  /// Takes in the Item that ends the session, full or not. At most 1000 bytes.
  std::uint64_t add_last(const v1::Item& item);

  /// The peer has everything up to `id`. False when that was never sent: the peer is broken.
  [[nodiscard]] bool acknowledge(std::uint64_t id, std::int64_t now_ns);

  /// Id of the oldest unacknowledged Item, or the id the next one will get: Packet.first of a
  /// Packet without Items.
  [[nodiscard]] std::uint64_t first_id() const noexcept { return acknowledged_ + 1; }
  /// Packet.first of a Packet with Items that leaves now.
  [[nodiscard]] std::uint64_t leaving_id() const noexcept {
    return fits_one_packet() ? first_id() : ahead_.next_id();
  }
  /// Id the next Item will get.
  [[nodiscard]] std::uint64_t next_id() const noexcept { return next_id_; }
  /// Items not acknowledged yet, counted as kMaxUnacknowledged counts them.
  [[nodiscard]] std::size_t unacknowledged() const noexcept {
    return window_.size() + waiting_.size();
  }
  /// Nothing is unacknowledged.
  [[nodiscard]] bool empty() const noexcept { return window_.empty(); }

  /// Before a Packet is made: what is late leaves again, from the oldest Item on.
  void prepare(std::int64_t now_ns);
  /// How many Items from leaving_id() on fit into `bytes` of a Packet, each with its tag and
  /// length; at most kMaxItems. 0 when no further Packet may leave.
  [[nodiscard]] std::size_t fitting(std::size_t bytes) const noexcept;
  /// Appends `count` Items from leaving_id() on as fields `items` of an encoded Packet.
  void append(std::size_t count, std::string& packet) const;
  /// A Packet with `count` Items from leaving_id() on leaves now.
  void sent(std::size_t count, std::int64_t now_ns) noexcept;

  /// When a Packet with Items must leave: at once (0) if one that never left fits into `bytes`.
  [[nodiscard]] std::int64_t due_ns(std::size_t bytes) const noexcept;

 private:
  /// What an Item does where order may change.
  enum class Place : std::uint8_t { kKeeps, kOvertakes, kIsOvertaken };

  /// An Item that waits: its encoding; cut into Chunks when blob > 0.
  struct Waiting {
    std::string bytes;
    Place place = Place::kKeeps;
    std::uint32_t blob = 0;
    std::size_t taken = 0;  ///< bytes of a blob that are in the window
  };

  std::uint64_t push(std::string bytes, Place place);
  void refill();
  [[nodiscard]] bool wants_more() const noexcept;
  void begin_schedule(std::int64_t now_ns) noexcept;
  /// All that is unacknowledged fits into one Packet, or may not leave in several.
  [[nodiscard]] bool fits_one_packet() const noexcept;
  /// Place in the window of the Item leaving_id().
  [[nodiscard]] std::size_t leaving() const noexcept {
    return static_cast<std::size_t>(leaving_id() - first_id());
  }

  Overtaking overtaking_;
  PacketsAhead ahead_;
  /// Encoded Items from first_id() on: at most kMaxItems; where the peer takes Packets ahead those
  /// under way and what another one takes.
  std::deque<std::string> window_;
  std::size_t window_bytes_ = 0;  ///< in Packets: with tags and lengths
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
