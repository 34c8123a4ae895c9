// The inside of ProtocolServer. Private to server/network. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/network/encoded_states.h"
#include "server/network/handshakes.h"
#include "server/network/protocol_server.h"
#include "server/network/reset_limiter.h"
#include "server/network/session.h"

namespace hapticd {

/// Sessions at once, those that say goodbye included.
inline constexpr std::size_t kMaxSessions = 32;
/// Of them, places that those who only look cannot hold: somebody may have to say Stop.
inline constexpr std::size_t kControlPlaces = 8;
inline constexpr std::size_t kMaxLookers = kMaxSessions - kControlPlaces;
/// Silence after which a session is dropped, ns.
inline constexpr std::int64_t kDropAfter_ns = 10'000 * wire::kMillisecond_ns;
/// How long a Bye is repeated, and how long the other side's is acknowledged, ns. While the Items
/// before a Bye are still being acknowledged its time restarts, but ends after kLongFarewell_ns.
inline constexpr std::int64_t kFarewell_ns = 1000 * wire::kMillisecond_ns;
inline constexpr std::int64_t kLongFarewell_ns = 10'000 * wire::kMillisecond_ns;
/// Silence of its holder after which the lease ends, ns and ms.
inline constexpr std::int64_t kLease_ns = 2000 * wire::kMillisecond_ns;
inline constexpr std::uint32_t kLease_ms = 2000;
/// A Run of steps that waits repeats the newest State so often, ns.
inline constexpr std::int64_t kRepeatState_ns = 50 * wire::kMillisecond_ns;

/// Who controls.
struct Lease {
  std::uint64_t session = 0;  ///< serial number of the holder; 0 = nobody
  std::uint64_t fence = 0;    ///< of the last grant
  std::string holder;
  std::int64_t renewed_ns = 0;
};

struct ProtocolServer::Implementation {
  ServerOptions options;
  ServerHost host;
  Send send;
  ServerCounters counters;
  std::vector<std::unique_ptr<Session>> sessions;
  std::uint64_t sessions_opened = 0;
  std::uint64_t served_last = 0;  ///< serial of the session whose turn it was last to cost much
  Lease lease;
  ResetLimiter reset_limiter;
  std::vector<double> rest_radii_m;        ///< of the strings, from the newest SceneInfo
  std::unique_ptr<Handshakes> handshakes;  ///< null: PLAIN is spoken
  bool shutting_down = false;
  std::int64_t now_ns = 0;
  EncodedStates encoded_states;  ///< of the tick that was offered last
  std::string datagram;          ///< being written; a member to keep its memory

  // protocol_server.cpp: sessions and datagrams.
  Session* find(const Address& address, std::uint32_t number);
  Session* find(std::uint64_t serial);
  Session* open(const Address& from, std::uint32_t number, wire::Role role);
  bool make_room(wire::Role role);
  Session* surplus_looker();
  void refuse(const Address& to, std::uint32_t number, v1::ResetReason reason);
  Session* session_for(const Address& from, const wire::DatagramHeader& header,
                       std::span<const std::uint8_t> body);
  void receive_body(Session& session, const wire::DatagramHeader& header,
                    std::span<const std::uint8_t> body);
  void take(Session& session, wire::Incoming& incoming);
  void transmit(Session& session, v1::Packet& rest,
                std::optional<std::string_view> state = std::nullopt);
  void send_states(Session& session, const EncodedState& state);
  void poll_session(Session& session);
  void tell(Session& session, const v1::Item& item);
  void tell_all(const v1::Item& item);
  void note_scene(const v1::Item& item);
  void close(Session& session, v1::ByeReason reason, const std::string& message);
  void end(Session& session, Phase phase);

  // protocol_keyed.cpp: HELLO, and the first DATA of a session.
  void receive_keyed(const Address& from, const wire::DatagramHeader& header,
                     std::span<const std::uint8_t> received);
  void receive_hello(const Address& from, std::span<const std::uint8_t> received);
  Session* open_keyed(const HalfOpen& half, const wire::DatagramHeader& header,
                      std::span<const std::uint8_t> body);
  void refuse_full(const HalfOpen& half);

  // protocol_requests.cpp: Items, the order of requests, the lease.
  void apply(Session& session, wire::ReceivedItem& received);
  void overtake(Session& session, const wire::ReceivedItem& received);
  void pump(Session& session);
  [[nodiscard]] bool costs_too_much_now(const Session& session) const;
  void serve_costly();
  void carry_out(Session& session, const v1::Item& item);
  void finish(Session& session, v1::Result result);
  void tell_result(Session& session, std::uint64_t item, v1::Result result);
  void answer(const RequestId& id, v1::Result result);
  void subscribe(Session& session, const v1::Subscribe& request);
  void acquire(Session& session, const v1::Acquire& request);
  void end_lease(LeaseEnd how);
  void expire_lease();
  void abandon_requests(Session& session);
  [[nodiscard]] bool holds_lease(const Session& session) const {
    return lease.session == session.serial;
  }
  /// Why the session may not make this request; nothing: it may.
  [[nodiscard]] std::optional<v1::Result> refusal(const Session& session,
                                                  const v1::Item& item) const;
  [[nodiscard]] v1::LeaseInfo lease_info(const Session& session) const;
  void tell_lease();
};

}  // namespace hapticd
