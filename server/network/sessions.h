// The sessions of a ProtocolServer: who lives, the datagrams of each to and from it, the handshakes
// that lead to keyed ones, and how they end. What their Items mean is not its business. Pure: no
// socket, no clock. Times are ns of one monotonic clock, never going back. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/rt/memory_boundary.h"
#include "server/network/handshakes.h"
#include "server/network/reset_limiter.h"
#include "server/network/server_host.h"
#include "server/network/session.h"

namespace hapticd {

/// What is told of sessions as they come and go. Both must be set.
struct SessionHandlers {
  std::function<void(Session&)> opened;  ///< its first Items may be told now
  std::function<void(Session&)> ended;   ///< nothing more is told to it
};

/// A Packet of a session, to be applied.
struct ArrivedPacket {
  Session* session = nullptr;
  wire::Incoming incoming;
};

class Sessions {
 public:
  /// Sends one datagram; may lose it. The bytes live only during the call.
  using Send = std::function<void(const Address&, std::span<const std::uint8_t>)>;

  Sessions(const ServerOptions& options, Send send, SessionHandlers handlers);

  /// The time of all that happens until the next call.
  void set_time(std::int64_t now_ns) noexcept { now_ns_ = now_ns; }
  [[nodiscard]] std::int64_t now_ns() const noexcept { return now_ns_; }

  /// One datagram as it came: the Packet to be applied; nothing where there is none. A first
  /// Packet opens its session.
  std::optional<ArrivedPacket> receive(const Address& from, std::span<const std::uint8_t> datagram);
  /// Sends what is due to everyone, and forgets the sessions that are over.
  void poll();

  /// In the order of their serial numbers.
  [[nodiscard]] std::span<const std::unique_ptr<Session>> all() const noexcept { return sessions_; }
  /// The session of this serial number; null: it is gone.
  [[nodiscard]] Session* find(std::uint64_t serial) const;

  /// Sends an Item; ends the session when too many are unacknowledged. Nothing for one that has
  /// ended.
  void tell(Session& session, const v1::Item& item);
  void tell_all(const v1::Item& item);
  /// Bytes that a State for this session may have in a Packet that leaves now.
  [[nodiscard]] std::size_t state_bytes(const Session& session) const;
  /// Sends a State, one datagram each part.
  void send_states(Session& session, const EncodedState& state);

  /// Says Bye, unless the session has ended.
  void close(Session& session, v1::ByeReason reason, const std::string& message);
  /// Others take the place of the keys of sessions, which there are; those opened with one that is
  /// gone are closed and told so.
  void replace_keys(const noise::ServerKeys& keys);
  /// Closes all, and opens none from now on.
  void shut_down(v1::ByeReason reason, const std::string& message);
  /// The session ends: `phase` is not kOpen.
  void end(Session& session, Phase phase);
  /// The session ends without a word: what it was in the middle of cannot go on. Asks for no
  /// memory.
  void fall(Session& session);
  /// That of `from` to which `datagram` belongs, if any.
  void fall(const Address& from, std::span<const std::uint8_t> datagram);
  /// Runs `work()` for the session, which falls where memory is short.
  template <typename Work>
  void serve(Session& session, Work&& work) {
    if (!within_memory(work)) fall(session);
  }

  [[nodiscard]] const ServerCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] ServerCounters& counters() noexcept { return counters_; }

 private:
  [[nodiscard]] Session* find(const Address& address, std::uint32_t number) const;
  [[nodiscard]] Session* surplus_looker() const;
  template <typename Counts>
  [[nodiscard]] Session* idlest_viewer(const Counts& counts) const;
  [[nodiscard]] std::size_t viewers_of(const Address& address) const;
  bool make_looker_place(const Address& from);
  bool make_room(const Address& from, wire::Role role);
  void evict(Session& session, const char* why);
  void remove(Session& session);
  Session* open(const Address& from, std::uint32_t number, const HalfOpen* half);
  Session* session_for(const Address& from, const wire::DatagramHeader& header,
                       std::span<const std::uint8_t> body);
  Session* keyed_session_for(const Address& from, const wire::DatagramHeader& header,
                             std::span<const std::uint8_t> body);
  void receive_hello(const Address& from, std::span<const std::uint8_t> received);
  Session* open_keyed(const HalfOpen& half, const wire::DatagramHeader& header,
                      std::span<const std::uint8_t> body);
  void refuse(const Address& to, std::uint32_t number, const v1::Reset& reset);
  void refuse_keyed(const HalfOpen& half, const v1::Reset& reset);
  bool count_verdict(wire::Verdict verdict);
  void poll_session(Session& session);
  void send_further();
  void transmit(Session& session, v1::Packet& rest,
                std::optional<std::string_view> state = std::nullopt);
  void send_datagram(const Address& to);

  std::uint32_t boot_id_;
  bool old_handshake_;
  Send send_;
  SessionHandlers handlers_;
  ServerCounters counters_;
  std::vector<std::unique_ptr<Session>> sessions_;
  std::uint64_t opened_ = 0;
  ResetLimiter reset_limiter_;
  std::unique_ptr<Handshakes> handshakes_;  ///< null: PLAIN is spoken
  bool shutting_down_ = false;
  std::int64_t now_ns_ = 0;
  std::string datagram_;  ///< being written; a member to keep its memory
};

}  // namespace hapticd
