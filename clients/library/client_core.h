// The client's side of the protocol (proto/PROTOCOL.md) as a pure state machine: datagrams and the
// time come in, datagrams go out through a callback. It opens a session, keeps it alive, repeats
// what is not acknowledged, and starts again when the server has forgotten it or was restarted. No
// socket, no clock, no thread; `Client` in client.h adds those. One thread calls everything;
// handlers are called from inside receive() and may call request(). Times are ns of one monotonic
// clock, above 0 and never going back. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "clients/library/key_handshake.h"
#include "clients/library/state_assembly.h"
#include "hapticd/v1/stream.pb.h"
#include "proto/wire/channel.h"
#include "proto/wire/clock_estimate.h"

namespace hapticd::client {

/// Why a session ended.
enum class SessionEnd : std::uint8_t {
  kForgotten,      ///< Reset: the server does not know it (any more)
  kFull,           ///< Reset: 32 sessions are open, or 24 that only look
  kRestarted,      ///< another boot id
  kBye,            ///< the server said Bye; ClientCore::bye() has reason and message
  kBacklog,        ///< 1024 Items unacknowledged
  kProtocolError,  ///< the server broke the rules
  kSilence,        ///< nothing was heard for 10 s, keyed 3 s
  kLeft,           ///< leave() is done
};

/// What the owner is told. All may be empty.
struct ClientHandlers {
  /// An Item of the server that is not a Result: events, SceneInfo, LeaseInfo, RecordInfo. Exactly
  /// once and in order within a session.
  std::function<void(const v1::Item&)> item;
  /// A State newer than all before it, its parts put together.
  std::function<void(const v1::State&)> state;
  /// A PoseBatch was refused.
  std::function<void(const v1::Result&)> pose_refused;
  /// The session is over. Unless it was left, another begins; it asks for the same States again,
  /// and gets SceneInfo first like every session. The lease is lost.
  std::function<void(SessionEnd)> ended;
};

/// Receives the Result of a request, or null when its session ended before it came.
using ResultHandler = std::function<void(const v1::Result*)>;

/// One client's connection to one server.
class ClientCore {
 public:
  /// Sends one datagram to the server; may lose it. The bytes live only during the call.
  using Send = std::function<void(std::span<const std::uint8_t>)>;
  /// Draws random numbers for sessions; for keyed ones they have to be fit for secrets.
  using Random = std::function<std::uint32_t()>;

  /// With a key the sessions are keyed, else PLAIN.
  ClientCore(Send send, Random random, ClientHandlers handlers,
             std::optional<ClientKey> key = std::nullopt);

  /// One datagram from the server's address. Anything may be in it.
  void receive(std::span<const std::uint8_t> datagram, std::int64_t now_ns);
  /// Sends what is due. At least every 10 ms, and after receive() and request().
  void poll(std::int64_t now_ns);
  /// When poll() has something to do, unless something comes in between.
  [[nodiscard]] std::int64_t due_ns() const;

  /// Sends a request. Its id in this session, or 0 when the session had to end or is ending. `done`
  /// is called once with the Result; not for a PoseBatch, which has none when it succeeds.
  std::uint64_t request(const v1::Item& item, ResultHandler done = {});
  /// Ends the session: Bye, repeated until acknowledged, 1 s at most. No other begins.
  void leave(std::int64_t now_ns);

  /// Anything was heard from the server in this session.
  [[nodiscard]] bool heard() const noexcept { return heard_ns_ != 0; }
  /// When the server was heard last in this session; 0 = never.
  [[nodiscard]] std::int64_t heard_ns() const noexcept { return heard_ns_; }
  /// What the server said when it refused a session, for people; empty: it never did.
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }
  /// leave() is done, or the server's Bye has been acknowledged for 1 s after it.
  [[nodiscard]] bool over() const noexcept { return phase_ == Phase::kOver; }
  /// Its number; 0 while a keyed one is not open.
  [[nodiscard]] std::uint32_t session() const noexcept { return channel_->session(); }
  [[nodiscard]] std::uint32_t boot_id() const noexcept { return boot_id_; }
  /// The server's clock, learned from this session.
  [[nodiscard]] const wire::ClockEstimate& clock() const noexcept { return clock_; }
  /// The server's last Bye.
  [[nodiscard]] const v1::Bye& bye() const noexcept { return bye_; }

 private:
  enum class Phase : std::uint8_t {
    kOpen,
    kLeaving,    ///< own Bye under way
    kDismissed,  ///< the server's Bye is acknowledged a while
    kOver,
  };

  void begin();
  void begin_keyed();
  void end(SessionEnd how);
  void abort(v1::ByeReason reason, const std::string& message, SessionEnd how);
  /// Ends the session when the Packet says that the server does not have it; whether it did.
  bool session_is_over(const v1::Packet& packet);
  void apply(wire::ReceivedItem& received);
  void take_result(const v1::Result& result);
  /// The Packet that leaves now; false when it could not be made.
  bool send_packet();

  Send send_;
  Random random_;
  ClientHandlers handlers_;
  std::optional<ClientKey> key_;
  std::string refusal_;
  std::unique_ptr<KeyHandshake> handshake_;  ///< until WELCOME has come
  std::unique_ptr<wire::Channel> channel_;
  Phase phase_ = Phase::kOpen;
  std::int64_t phase_until_ns_ = 0;
  std::int64_t now_ns_ = 0;
  std::int64_t heard_ns_ = 0;
  std::uint32_t boot_id_ = 0;
  StateAssembly states_;
  std::uint64_t told_seen_ = 0;  ///< Packet.seen as sent last
  wire::ClockEstimate clock_;
  std::int64_t clock_sent_ns_ = 0;
  std::size_t clocks_sent_ = 0;
  std::map<std::uint64_t, ResultHandler> pending_;
  std::optional<v1::Subscribe> subscription_;
  v1::Bye bye_;
  std::string datagram_;
};

}  // namespace hapticd::client
