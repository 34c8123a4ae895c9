// One session as either side of it keeps it: counters of both directions, what was received, what
// is unacknowledged, and when the next Packet must leave. PROTOCOL.md, sections 2 to 4 and 7. Pure:
// the owner brings datagrams and the time (ns of one clock, never going back) and sends what
// write() gives. PLAIN, or DATA under the keys of a handshake. A client announces that it takes
// Packets ahead, a server does so in return: Packet.ahead. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hapticd/v1/stream.pb.h"
#include "proto/noise/handshake.h"
#include "proto/wire/clock_exchange.h"
#include "proto/wire/datagram.h"
#include "proto/wire/item_inbox.h"
#include "proto/wire/item_outbox.h"
#include "proto/wire/replay_window.h"

namespace hapticd::wire {

/// Longest silence of a sender, ns.
inline constexpr std::int64_t kKeepAlive_ns = 100 * kMillisecond_ns;
/// An Item that came again, so that its acknowledgement was lost, is acknowledged this long after
/// the last Packet, ns: below the 10 ms of the protocol, above what duplicates of one Packet take.
inline constexpr std::int64_t kAcknowledgeAgain_ns = 5 * kMillisecond_ns;
/// Longest Packet that is looked at for a Reset although its counter has been used, bytes.
inline constexpr std::size_t kResetBytes = 64;

enum class Side : std::uint8_t { kClient, kServer };

/// What became of a datagram.
enum class Verdict : std::uint8_t {
  kTaken,
  kRepeated,    ///< step 4: its counter was used before, or is too old
  kUnreadable,  ///< step 5: no Packet, first = 0, or more than 16 Items
  kForged,      ///< step 5: its tag does not verify
};

/// A datagram as far as the channel has dealt with it.
struct Incoming {
  Verdict verdict = Verdict::kUnreadable;
  bool newest = false;    ///< its counter is the highest so far
  v1::Packet packet;      ///< without its Items
  bool progress = false;  ///< it acknowledged Items that had not been
  ReceivedItems items;    ///< to be applied; broken covers an impossible ack as well
};

/// Parses the body of a datagram; false when step 5 fails.
[[nodiscard]] bool parse_packet(std::span<const std::uint8_t> body, v1::Packet& packet);

/// One session, seen from one side.
class Channel {
 public:
  Channel(Side side, std::uint32_t session);

  [[nodiscard]] std::uint32_t session() const noexcept { return session_; }

  /// From now on the session is the keyed one of this number, and speaks DATA. Before anything is
  /// received or written; Items sent already are kept.
  void secure(std::uint32_t session, const noise::Transport& transport) {
    session_ = session;
    transport_ = transport;
  }
  /// The kind of its datagrams in both directions.
  [[nodiscard]] DatagramKind kind() const noexcept {
    return transport_.has_value() ? DatagramKind::kData : DatagramKind::kPlain;
  }

  /// Steps 4 to 6 and the Items of a datagram of this session whose header is `header`, of kind().
  /// On the client's side of a PLAIN session a Reset is taken whatever its counter, marks none and
  /// applies nothing: its sender counts from 0, because it keeps no memory of the session.
  Incoming receive(const DatagramHeader& header, std::span<const std::uint8_t> body,
                   std::int64_t now_ns);

  /// Sends an Item; its id, or nothing when the backlog is full and the session has to end. The id
  /// is of use on the client's side only: a server's Items may overtake Results.
  std::optional<std::uint64_t> send(const v1::Item& item) { return outbox_.add(item); }
  /// Sends the Item after which none follows; never refused.
  void send_last(const v1::Item& item) { outbox_.add_last(item); }
  /// Items sent and not acknowledged, a blob counting as one until its pieces leave.
  [[nodiscard]] std::size_t unacknowledged() const noexcept { return outbox_.unacknowledged(); }
  /// Items and Chunks acknowledged so far.
  [[nodiscard]] std::uint64_t acknowledged() const noexcept { return outbox_.first_id() - 1; }
  /// Everything sent has arrived.
  [[nodiscard]] bool all_acknowledged() const noexcept { return outbox_.empty(); }
  /// Id the next Item sent will get, or its first Chunk.
  [[nodiscard]] std::uint64_t next_id() const noexcept { return outbox_.next_id(); }
  /// The current Packet.ack.
  [[nodiscard]] std::uint64_t applied() const noexcept { return inbox_.applied(); }

  /// When the next Packet must leave: for Items, acknowledgement or keep-alive. 0 = at once.
  [[nodiscard]] std::int64_t due_ns() const noexcept;

  /// Bytes a State may have in a Packet whose remaining parts, without Items, are `rest`.
  [[nodiscard]] std::size_t state_bytes(const v1::Packet& rest) const;
  /// The datagram that leaves now. `rest` is the Packet without ack, first, Items, ahead and State;
  /// these are put in, the Items that fit, and `state`, the encoding of a State. A State that
  /// does not fit beside all that could leave goes without Items. False when `rest` and `state`
  /// alone are too long: nothing leaves then.
  bool write(const v1::Packet& rest, std::int64_t now_ns, std::string& datagram,
             std::optional<std::string_view> state = std::nullopt);

 private:
  bool open_body(const DatagramHeader& header, std::span<const std::uint8_t>& body,
                 noise::Bytes& plain) const;
  void take_announcement(std::uint32_t ahead);
  [[nodiscard]] v1::Packet front() const;

  Side side_;
  std::uint32_t session_;
  std::optional<noise::Transport> transport_;  ///< DATA; nothing: PLAIN
  std::uint64_t counter_ = 0;
  std::uint64_t newest_counter_ = 0;
  bool any_received_ = false;
  ReplayWindow window_;
  ItemOutbox outbox_;
  ItemInbox inbox_;
  bool announces_;            ///< the peer may not know yet that it may send Packets ahead
  std::int64_t left_ns_ = 0;  ///< when the last Packet left; 0 = none did
  std::int64_t acknowledge_due_ns_ = kNever_ns;
};

}  // namespace hapticd::wire
